# SPDX-License-Identifier: MIT
"""The committed budget: each figure bounded on both sides.

The upper bound is close: a tick must not get dearer unseen. The lower one is there because a tick that
got cheap may have stopped doing something; it leaves room for what makes the code better.
"""

import math
import tomllib

from whole_file import read_whole

from .image import BenchError

BELOW_PERCENT, ABOVE_PERCENT = 10, 3
TOML_BYTES_MAX = 1 << 20

HEADER = """\
# What the control tick may cost: [lowest, highest] of each figure, measured −{below} % and +{above} %.
# Held by the test target.cost. Written by `tools/dev figures --write budget`; say in the
# commit why the figures moved.
"""


def bounds(value):
    """The whole numbers around a value with its margins."""
    return [math.floor(value * (1 - BELOW_PERCENT / 100)), math.ceil(value * (1 + ABOVE_PERCENT / 100))]


def as_toml(figures):
    lines = [HEADER.format(below=BELOW_PERCENT, above=ABOVE_PERCENT)]
    for group, values in figures.items():
        lines.append(f"[{group}]")
        lines += [f"{name} = {bounds(value)}" for name, value in values.items()]
        lines.append("")
    return "\n".join(lines)


def read(path):
    """Bounds by group and figure."""
    try:
        budget = tomllib.loads(read_whole(path, TOML_BYTES_MAX).decode())
    except OSError as error:
        raise BenchError(f"{path}: {error.strerror}; expected a budget, which `tools/dev figures --write` "
                         "writes") from error
    except (ValueError, RecursionError) as error:
        raise BenchError(f"{path}: {error}; expected TOML") from error
    return checked(path, budget)


def checked(path, budget):
    """The file's tables [core.group], each figure a pair; anything else is refused."""
    found = {}
    for core, groups in budget.items():
        for group, values in groups.items() if isinstance(groups, dict) else [("", groups)]:
            if not isinstance(values, dict):
                raise BenchError(f"{path}: {core} {group} is {values}; expected tables "
                                 "[core.group] of figures")
            for name, pair in values.items():
                check_pair(path, f"{core}.{group}.{name}", pair)
            found[f"{core}.{group}"] = values
    return found


def check_pair(path, name, pair):
    numbers = isinstance(pair, list) and len(pair) == 2 and all(
        type(bound) in (int, float) for bound in pair)
    if not numbers or pair[0] > pair[1]:
        raise BenchError(f"{path}: {name} is {pair}; expected [lowest, highest]")


def findings(figures, budget):
    """A line for each figure that is outside its bounds, or on one side only."""
    lines = []
    for group, values in figures.items():
        allowed = budget.get(group, {})
        for name, value in values.items():
            lines += finding(f"{group}.{name}", value, allowed.get(name))
        lines += [f"{group}.{name}: not measured, allowed {pair[0]} to {pair[1]}"
                  for name, pair in allowed.items() if name not in values]
    return lines


def finding(name, value, pair):
    if pair is None:
        return [f"{name}: {value:g}, not in the budget"]
    if value > pair[1]:
        return [f"{name}: {value:g}, more than allowed ({pair[0]} to {pair[1]})"]
    if value < pair[0]:
        return [f"{name}: {value:g}, less than allowed ({pair[0]} to {pair[1]})"]
    return []
