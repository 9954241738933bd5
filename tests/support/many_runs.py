# SPDX-License-Identifier: MIT
"""How many runs a test makes that repeats one, as testing_runs() for C: few in `tools/dev test`, many in the evidence.

Where a run takes seconds, the evidence makes some of the runs. NF_MANY_RUNS=whole makes all of them.
"""

import os

ASKED = os.environ.get("NF_MANY_RUNS")


def are_asked():
    return ASKED in ("1", "whole")


def of(few, many, whole):
    return whole if ASKED == "whole" else many if are_asked() else few
