# SPDX-License-Identifier: MIT
"""The search for gains: the same for each estimator, with as many trials, and repeatable from its seed.

There are two goals. `scenarios` are S1 to S3 with the sets `ideal`, `imp` and `all`. `zoo` are motors of the zoo, half of them as their
files say and half as users have them. The cost of gains is the mean over the runs of a goal of the largest speed error in % of
rated speed plus the largest angle error in electrical degrees; a run that loses the rotor costs as much as LOST. Noise and motors
have other seeds than those of the comparison.

A third of the trials is spread over the ranges of the gains, evenly in their logarithms. From the best of them on each trial is a
normal step from the best so far. The step grows after a success and shrinks after a failure, so that one in five succeeds.
The search for the zoo begins with the gains for the scenarios.
"""

import math
import random
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

from whole_file import whole_file

from . import runs

SEED = 1
LOST = 100.0
SPREAD = 1 / 3          # of the trials
STEP, STEP_LEAST = 0.15, 0.005      # of a range's logarithm
GROWTH = 1.5            # of the step after a success; after a failure its fourth root, the other way
DIGITS = 3              # of a gain


@dataclass(frozen=True)
class Goal:
    """What gains are for."""

    cases: tuple
    evaluations: int    # a run of the zoo takes ten times as long
    suffix: str         # of the names of the files
    first: str | None   # suffix of the gains to begin with


GOALS = {
    "scenarios": Goal(tuple(runs.cases(("s1_robust", "s2_robust", "s3_robust"), ("ideal", "imp", "all"), (101, 102, 103))),
                      300, "", None),
    "zoo": Goal((*runs.motors("zoo", 101, 6), *runs.motors("zoo_user", 102, 6)), 30, "_zoo", ""),
}


def cost_of(outcomes):
    """Of motors that are refused nothing can be said."""
    known = [outcome for outcome in outcomes if outcome.ending != runs.REFUSED]
    return sum(min(LOST, outcome.speed_pct + outcome.angle_deg) if outcome.locked else LOST
               for outcome in known) / len(known)


def gain_of(gain, share):
    """The gain at a share, 0 to 1, of the logarithm of its range."""
    value = gain["min"] * (gain["max"] / gain["min"]) ** share
    return min(max(float(f"{value:.{DIGITS}g}"), gain["min"]), gain["max"])


def share_of(gain, value):
    """The inverse of gain_of()."""
    return math.log(value / gain["min"]) / math.log(gain["max"] / gain["min"])


def trials(count, evaluations, generator, first=None):
    """Points of the unit cube; after each it has to be told by send() whether that is the best so far."""
    best, step = None, STEP
    for number in range(evaluations):
        if number < evaluations * SPREAD:
            point = first if first and number == 0 else [generator.random() for _ in range(count)]
            if (yield point):
                best = point
            continue
        point = [min(max(share + generator.gauss(0.0, step), 0.0), 1.0) for share in best]
        if (yield point):
            best, step = point, step * GROWTH
        else:
            step = max(step / GROWTH ** 0.25, STEP_LEAST)


def search(gains, cost, evaluations, seed=SEED, first=None, told=None):
    """The gains of least cost, by name, and that cost.

    `gains`: ranges by name; `first`: gains to begin with; `told` is called after each trial.
    """
    begin = [share_of(gain, first[name]) for name, gain in gains.items()] if first else None
    points = trials(len(gains), evaluations, random.Random(seed), begin)
    best, least = None, math.inf
    point = next(points)
    while True:
        found = {name: gain_of(gain, share) for (name, gain), share in zip(gains.items(), point)}
        value = cost(found)
        better = value < least
        best, least = (found, value) if better else (best, least)
        if told:
            told()
        try:
            point = points.send(better)
        except StopIteration:
            return best, least


def file_text(estimator, gains, head=()):
    lines = [*(f"# {line}" for line in head), f'estimator = "{estimator}"', "", "[gain]",
             *(f"{name} = {value:.{DIGITS}g}" for name, value in gains.items())]
    return "".join(f"{line}\n" for line in lines)


def cost_with(program, estimator, cases):
    """The cost of an estimator's gains in the simulator."""
    def cost(gains):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "gains.toml"
            path.write_text(file_text(estimator, gains), encoding="utf-8")
            return cost_of(runs.run_all(program, [(case, path) for case in cases]))
    return cost


def gains_in(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))["gain"]


def tune(program, estimator, gains, goal, evaluations, seed, folder, told=None):
    """Searches, and writes the file of the estimator into the folder; its path, and the cost. `goal`: a name of GOALS."""
    aim = GOALS[goal]
    first = None if aim.first is None else gains_in(Path(folder) / f"{estimator}{aim.first}.toml")
    best, least = search(gains, cost_with(program, estimator, aim.cases), evaluations, seed, first, told)
    command = f"tools/compare tune {estimator} --goal {goal} --evaluations {evaluations} --seed {seed}"
    head = (f"Found by `{command}`", f"with a cost of {least:.3g} (tools/comparison/search.py).")
    path = Path(folder) / f"{estimator}{aim.suffix}.toml"
    with whole_file(path) as file:
        file.write(file_text(estimator, best, head))
    return path, least
