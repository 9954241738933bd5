# SPDX-License-Identifier: MIT
"""What a campaign over the zoo says: how each class ended, and by which dimensionless numbers the failures gather."""

import json
from collections import Counter
from dataclasses import asdict, dataclass

import numpy as np

from whole_file import whole_file

from . import summary, zoo
from .campaign import CampaignError
from .simulator import LOCKED, OUTCOMES, REFUSED

FILE = "summary.json"
PARTS = 5
ALL = "all"
# What the drive promises of the largest speed error, of rated speed, and of how many of the locked runs.
ERRORS, ERROR_QUANTILE = ("speed_error_command_pct", "speed_error_load_pct"), 95


@dataclass(frozen=True)
class Share:
    """How the runs of a class ended."""

    name: str
    runs: int
    percent: dict         # by outcome
    coarse_percent: float  # held against rated speed alone, whether it swings or not
    false_faults: int
    faults: dict          # runs by the fault's name


@dataclass(frozen=True)
class Gathering:
    """The share of the runs that do not hold, in parts of a number's range with as many runs in each."""

    name: str
    edges: tuple    # one more than parts
    percent: tuple


def share(name, rows):
    found = Counter(row["outcome"] for row in rows)
    coarse = sum(row["metrics"].get("locked_coarse", False) for row in rows)
    return Share(name, len(rows), {outcome: 100 * found[outcome] / len(rows) for outcome in OUTCOMES},
                 100 * coarse / len(rows), sum(bool(zoo.false_faults(row)) for row in rows),
                 {name: one["runs"] for name, one in faults(rows).items()})


def classes(campaign, rows):
    """A line for each class, and one for all."""
    sorted_in = {name: [row for row in rows if zoo.class_of(row) == name] for name in campaign.drawn.classes}
    return [*(share(name, found) for name, found in sorted_in.items() if found), share(ALL, rows)]


def gatherings(campaign, rows):
    """What matters most comes first."""
    known = [row for row in rows if zoo.has_numbers(row)]
    axes = {name: axis for name, axis in campaign.axes(known).items() if name != "class"}
    made = []
    for name, found in summary.ranking(axes, known, PARTS).items():
        edges = (axes[name].distribution.at(part / PARTS) for part in range(PARTS + 1))
        made.append(Gathering(name, tuple(edges), tuple(found)))
    return made


def faults(rows):
    """The runs with each fault, by its name; those that name a broken part are false."""
    found = Counter(name for row in rows for name in set(zoo.names_of_faults(row)))
    return {name: {"runs": count, "false": name in zoo.FALSE_FAULTS} for name, count in found.most_common()}


def refusals(rows):
    return dict(Counter(row["metrics"]["refused_for"] for row in rows if row["outcome"] == REFUSED))


def errors(rows):
    """The quantile of each of ERRORS among the locked runs; None without any."""
    locked = [row for row in rows if row["outcome"] == LOCKED]
    found = {name: [value for value, _ in summary.measured(locked, name)] for name in ERRORS}
    return {name: float(np.percentile(values, ERROR_QUANTILE)) if values else None
            for name, values in found.items()}


def content(campaign, rows):
    return {
        "campaign": campaign.name, "variant": campaign.drawn.variant, "seed": campaign.seed,
        "set": campaign.fixed, "runs": len(rows),
        "classes": [asdict(line) for line in classes(campaign, rows)],
        "numbers": [asdict(line) for line in gatherings(campaign, rows)],
        "faults": faults(rows), "refused": refusals(rows),
        f"errors_p{ERROR_QUANTILE}_of_the_locked": errors(rows),
        "accepted": [asdict(demand) for demand in summary.demands(campaign, rows)],
    }


def write(folder, campaign, rows):
    path = folder / FILE
    try:
        with whole_file(path) as file:
            json.dump(content(campaign, rows), file, indent=2, ensure_ascii=False)
            file.write("\n")
    except OSError as error:
        raise CampaignError(f"{error.filename}: {error.strerror}; expected a place to write to") from error
    return path
