# SPDX-License-Identifier: MIT
"""The summary of a campaign over the zoo as tables of text."""

from rich.table import Table

from . import zoo_summary
from .simulator import OUTCOMES


def titled(title, left, right):
    made = Table(title=title, title_justify="left")
    made.add_column(left, no_wrap=True)
    for name in right:
        made.add_column(name, justify="right")
    return made


def class_table(campaign, rows):
    made = titled("How the motors of each class ended, %", "class",
                  ("motors", *OUTCOMES, "held coarsely", "false faults"))
    for line in zoo_summary.classes(campaign, rows):
        made.add_row(line.name, str(line.runs), *(f"{line.percent[outcome]:.1f}" for outcome in OUTCOMES),
                     f"{line.coarse_percent:.1f}", str(line.false_faults))
    return made


def number_table(campaign, rows):
    """Each cell is the end of a part of the range, and how many of its motors do not hold."""
    made = titled(f"Not within the limits, % of the motors in each {zoo_summary.PARTS}th by a number", "number",
                  ("from", *("up to: %" for _ in range(zoo_summary.PARTS))))
    for line in zoo_summary.gatherings(campaign, rows):
        cells = (f"{edge:.3g}: {percent:.0f}" for edge, percent in zip(line.edges[1:], line.percent, strict=True))
        made.add_row(line.name, f"{line.edges[0]:.3g}", *cells)
    return made


def lines(rows):
    """Faults, refusals, errors."""
    found = zoo_summary.faults(rows)
    if found:
        yield "faults: " + ", ".join(f"{name}{' (false)' if one['false'] else ''} {one['runs']}"
                                     for name, one in found.items())
    refused = zoo_summary.refusals(rows)
    if refused:
        yield "refused: " + ", ".join(f"{count} for {reason}" for reason, count in refused.items())
    for name, value in zoo_summary.errors(rows).items():
        if value is not None:
            yield f"{name} of {zoo_summary.ERROR_QUANTILE} % of the locked: {value:.3g}"
