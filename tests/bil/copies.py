# SPDX-License-Identifier: MIT
"""Runs of which each goes on from the same moment of an emulated board."""

import os
import traceback


def in_a_copy(act):
    """What `act` returns, a text, in a copy of this process: what it changes is not changed here. What it raises is an error
    here, too."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            with open(writer, "w", newline="") as pipe:
                pipe.write(act())
            status = 0
        except BaseException:  # nothing of the copy goes on behind this
            traceback.print_exc()
        finally:
            os._exit(status)
    os.close(writer)
    with open(reader, newline="") as pipe:
        text = pipe.read()
    if os.waitpid(child, 0)[1] != 0:
        raise RuntimeError("the copy has ended with an error, see above")
    return text
