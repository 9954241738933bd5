# SPDX-License-Identifier: MIT
"""The comparison as tables: rows are estimators, columns the sets of a scenario, or how the motors of the zoo end."""

import statistics

from robustness.simulator import FAILED_SAFE, LOCKED, OFF_LIMITS, UNCONTROLLED

from . import runs

SCENARIOS = ("s1_robust", "s2_robust", "s3_robust")
SETS = ("ideal", "adc", "deadtime", "hot", "saturated", "imp", "all")
SEEDS = 5
VARIANTS = ("zoo", "zoo_user")
MOTORS, ZOO_SEED = 100, 1
ZOO_GAINS = "_zoo"
SHARED_LEAST = 5    # motors: a median of fewer says nothing
ENDINGS = {LOCKED: "locked", OFF_LIMITS: "swings", FAILED_SAFE: "fault", UNCONTROLLED: "lost"}
DRIVE = "neurofoc, the firmware"
# Rows of a table in their order. The last is the firmware's law in double precision, its gains by the same search.
TITLES = {
    "luenberger": "Luenberger + PLL",
    "sliding_mode": "sliding mode + PLL",
    "flux": "flux observer + PLL",
    "kalman": "Kalman filter, 4 states",
    "neural": "eq. (22), double precision",
}


def title(estimator):
    """A row's head: a file of gains goes by its own name."""
    return DRIVE if estimator is None else TITLES.get(estimator.removesuffix(ZOO_GAINS), estimator)


# ---- S1 to S3 ----


def cell(outcomes):
    """The worst of several seeds."""
    lost = sum(not one.locked for one in outcomes)
    if lost:
        return "lost" if lost == len(outcomes) else f"lost in {lost} of {len(outcomes)}"
    speed, angle = max(one.speed_pct for one in outcomes), max(one.angle_deg for one in outcomes)
    return f"{speed:.2g}, {angle:.1f}°"


def heads(sets):
    return ["estimator", *(f"`{name}`" for name in sets)]


def rows(program, estimators, scenario, sets=SETS, seeds=SEEDS):
    """The texts of each row. `estimators`: names, files of gains, or None for the drive's own."""
    wanted = runs.cases([scenario], sets, range(1, seeds + 1))
    pairs = [(case, estimator) for estimator in estimators for case in wanted]
    found = {}
    for (case, estimator), outcome in zip(pairs, runs.run_all(program, pairs)):
        found.setdefault((estimator, case.imperfections), []).append(outcome)
    return [[title(estimator), *(cell(found[estimator, name]) for name in sets)] for estimator in estimators]


# ---- the zoo ----


def zoo_outcomes(program, estimators, variant, count, told=lambda: None):
    """Those of each estimator, without the motors that are refused."""
    wanted = runs.motors(variant, ZOO_SEED, count)
    found = iter(runs.run_all(program, [(motor, estimator) for estimator in estimators for motor in wanted], told))
    lines = [[next(found) for _ in wanted] for _ in estimators]
    kept = [number for number, one in enumerate(lines[0]) if one.ending != runs.REFUSED]
    return [[line[number] for number in kept] for line in lines]


def zoo_table(estimators, lines):
    """Heads and rows: how the motors ended in percent, and the median error of those that all estimators lock."""
    shared = [number for number, line in enumerate(zip(*lines)) if all(one.ending == LOCKED for one in line)]
    made = []
    for estimator, line in zip(estimators, lines):
        shares = [100 * sum(one.ending == ending for one in line) / len(line) for ending in ENDINGS]
        error = f"{statistics.median(line[number].speed_pct for number in shared):.2g}" if len(shared) >= SHARED_LEAST else "–"
        made.append([title(estimator), *(f"{share:.1f}" for share in shares), error])
    return [f"of {len(lines[0])} motors", *(f"{name}, %" for name in ENDINGS.values()), f"speed error of {len(shared)}, %"], made
