# SPDX-License-Identifier: MIT
"""How many runs a test makes that repeats one: few in `tools/dev test`, many in the evidence, as testing_runs() for C."""

import os


def are_asked():
    return os.environ.get("NF_MANY_RUNS") == "1"
