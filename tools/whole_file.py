# SPDX-License-Identifier: MIT
"""Files that are written whole or not at all, and read whole or not at all."""

import errno
import os
import signal
import threading
from contextlib import contextmanager
from pathlib import Path

ENDS = (signal.SIGHUP, signal.SIGTERM)  # Ctrl-C is an exception


def read_whole(path, most=1 << 30):
    """All bytes of a file or a pipe. OSError where it goes on behind `most`, as a device without an end does."""
    with open(path, "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"is longer than {most} bytes", str(path))
    return content


@contextmanager
def removed_by_signals(path):
    """A signal that ends the program removes the file first. Only the main thread may say what a signal does."""
    def remove_and_end(number, _):
        path.unlink(missing_ok=True)
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)

    main = threading.current_thread() is threading.main_thread()
    before = {number: signal.getsignal(number) for number in ENDS if main}
    taken = [number for number, action in before.items() if action == signal.SIG_DFL]
    for number in taken:
        signal.signal(number, remove_and_end)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


@contextmanager
def whole_file(path, **options):
    """A text file to write, which takes the place of `path` when all of it is written."""
    beside = Path(f"{path}.{os.getpid()}.part")
    try:
        with removed_by_signals(beside):
            with open(beside, "x", encoding="utf-8", **options) as file:
                yield file
            beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
