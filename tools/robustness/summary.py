# SPDX-License-Identifier: MIT
"""What the results of a campaign say: counts, figures, where the runs gather that do not hold."""

import math
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from .distributions import is_number
from .simulator import LOCKED, OUTCOMES, UNCONTROLLED

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
    found = Counter(row["outcome"] for row in rows)
    return [Count(outcome, found[outcome], 100 * found[outcome] / len(rows),
                  *interval(found[outcome], len(rows))) for outcome in OUTCOMES]


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
    texts = [re.sub(r", limit: .*", "", text) for text in metrics.get("failed_limits", ())]
    return ", ".join([*metrics.get("faults", ()), *texts])


def failures(rows):
    """Runs that do not hold: the uncontrolled ones first."""
    return sorted((row for row in rows if row["outcome"] != LOCKED),
                  key=lambda row: (-OUTCOMES.index(row["outcome"]), row["run"]))


def part_of(distribution, row, key, parts):
    return min(int(distribution.place(row["values"][key]) * parts), parts - 1)


def shares(campaign, rows, key):
    """Percent of the runs that do not hold, in each part of a parameter's range; NaN without runs."""
    hits, total = np.zeros(PARTS), np.zeros(PARTS)
    for row in rows:
        part = part_of(campaign.vary[key], row, key, PARTS)
        total[part] += 1
        hits[part] += row["outcome"] != LOCKED
    return 100 * np.divide(hits, total, out=np.full(PARTS, np.nan), where=total > 0)


def spread(found):
    """How much of the range of a parameter matters: the largest less the smallest share."""
    known = found[~np.isnan(found)]
    return float(np.ptp(known)) if len(known) else 0.0


def ranking(campaign, rows):
    """The shares by parameter; what matters most comes first. A seed has no order to speak of."""
    found = {key: shares(campaign, rows, key) for key in campaign.vary if key != SEED}
    return dict(sorted(found.items(), key=lambda item: -spread(item[1])))


def demands(campaign, rows):
    """The campaign's acceptance, each demand with what was found."""
    found = {count.outcome: count for count in counts(rows)}
    made = []
    wanted = campaign.accept.locked_pct
    if wanted is not None:
        percent = found[LOCKED].percent
        made.append(Demand("locked_pct", percent, wanted, percent >= wanted, "≥"))
    most = campaign.accept.uncontrolled
    if most is not None:
        runs = found[UNCONTROLLED].runs
        made.append(Demand("uncontrolled", runs, most, runs <= most, "≤"))
    return made
