# SPDX-License-Identifier: MIT
"""What the results of a campaign say: counts, figures, where the runs gather that do not hold."""

import math
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from .distributions import is_number
from . import zoo
from .simulator import LOCKED, OFF_LIMITS, OUTCOMES, REFUSED, UNCONTROLLED

SURE = 1.96  # standard deviations to either side hold 95 %
QUANTILES = (50, 95, 99)
PARTS = 3    # of a parameter's range
SEED = "scenario.seed"


@dataclass(frozen=True)
class Count:
    outcome: str
    runs: int
    percent: float
    low: float   # of the 95 % interval, percent
    high: float


@dataclass(frozen=True)
class Worst:
    value: float
    run: int


@dataclass(frozen=True)
class Figure:
    """A metric; the quantiles and `held` are of the locked runs, and empty without any."""

    name: str
    quantiles: tuple
    held: Worst | None
    all: Worst


@dataclass(frozen=True)
class Demand:
    """A line of the campaign's own acceptance."""

    name: str
    found: float
    limit: float
    holds: bool
    sign: str


def interval(hits, count):
    """Wilson's 95 % interval of a share, percent; right also where nothing or everything hits."""
    share, square = hits / count, SURE * SURE
    middle = share + square / (2 * count)
    half = SURE * math.sqrt(share * (1 - share) / count + square / (4 * count * count))
    low, high = ((middle + side * half) / (1 + square / count) for side in (-1, 1))
    return 100 * max(low, 0.0), 100 * min(high, 1.0)


def counts(rows):
    """Of each outcome; only a motor of the zoo is ever refused."""
    found = Counter(row["outcome"] for row in rows)
    return [Count(outcome, found[outcome], 100 * found[outcome] / len(rows),
                  *interval(found[outcome], len(rows)))
            for outcome in OUTCOMES if outcome != REFUSED or found[REFUSED]]


def measured(rows, name):
    """Values and runs of a metric, of those rows that have one."""
    found = [(row["metrics"].get(name), row["run"]) for row in rows]
    return [(value, run) for value, run in found if is_number(value)]


def worst(found):
    return Worst(*max(found, key=lambda pair: pair[0])) if found else None


def figures(rows):
    """All metrics that are numbers; each is the worse the larger it is."""
    locked = [row for row in rows if row["outcome"] == LOCKED]
    names = {name: None for row in rows for name in row["metrics"]}
    made = []
    for name in names:
        everywhere, held = measured(rows, name), measured(locked, name)
        if everywhere:
            quantiles = np.percentile([value for value, _ in held], QUANTILES) if held else ()
            made.append(Figure(name, tuple(quantiles), worst(held), worst(everywhere)))
    return made


def reasons(rows):
    """Broken limits and faults by name, each with the number of runs that it is found in."""
    found = Counter()
    for row in rows:
        broken = [text.split(" = ")[0] for text in row["metrics"].get("failed_limits", ())]
        faults = {"fault " + text.split("@")[0] for text in row["metrics"].get("faults", ())}
        found.update((*broken, *sorted(faults)))
    return found.most_common()


def reason(row):
    """Why a run is none that holds, in a few words."""
    metrics = row["metrics"]
    if row["outcome"] == REFUSED:
        return metrics["refused"]
    texts = [re.sub(r", limit: .*", "", text) for text in metrics.get("failed_limits", ())]
    return ", ".join([*metrics.get("faults", ()), *texts])


def failures(rows):
    """Runs that do not hold: the uncontrolled ones first."""
    return sorted((row for row in rows if row["outcome"] != LOCKED),
                  key=lambda row: (-OUTCOMES.index(row["outcome"]), row["run"]))


def part_of(axis, row, parts):
    return min(int(axis.place(row) * parts), parts - 1)


def shares(axis, rows, parts=PARTS):
    """Percent of the runs that do not hold, in each part of an axis; NaN without runs."""
    hits, total = np.zeros(parts), np.zeros(parts)
    for row in rows:
        part = part_of(axis, row, parts)
        total[part] += 1
        hits[part] += row["outcome"] != LOCKED
    return 100 * np.divide(hits, total, out=np.full(parts, np.nan), where=total > 0)


def spread(found):
    """How much of the range of a parameter matters: the largest less the smallest share."""
    known = found[~np.isnan(found)]
    return float(np.ptp(known)) if len(known) else 0.0


def ranking(axes, rows, parts=PARTS):
    """The shares by axis; what matters most comes first. A seed has no order to speak of."""
    found = {key: shares(axis, rows, parts) for key, axis in axes.items() if key != SEED}
    return dict(sorted(found.items(), key=lambda item: -spread(item[1])))


def demands(campaign, rows):
    """The campaign's acceptance, each demand with what was found."""
    outcomes = Counter(row["outcome"] for row in rows)
    unnamed = outcomes[UNCONTROLLED] + outcomes[OFF_LIMITS]
    found = {
        "locked_pct": (100 * outcomes[LOCKED] / len(rows), "≥"),
        "uncontrolled": (outcomes[UNCONTROLLED], "≤"),
        "unnamed_pct": (100 * unnamed / len(rows), "≤"),
        "false_faults": (sum(bool(zoo.false_faults(row)) for row in rows), "≤"),
        "refused_formats": (sum(row["metrics"].get("refused_for") == zoo.FOR_FORMAT for row in rows), "≤"),
    }
    made = []
    for name, (value, sign) in found.items():
        limit = getattr(campaign.accept, name)
        if limit is not None:
            made.append(Demand(name, value, limit, value >= limit if sign == "≥" else value <= limit, sign))
    return made
