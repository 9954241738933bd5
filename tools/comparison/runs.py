# SPDX-License-Identifier: MIT
"""Runs of the simulator with an estimator in the place of the drive's observer."""

import functools
import json
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from robustness import campaign
from robustness.campaign import ROOT
from robustness.simulator import BAD_INPUT, MOTORSIM, REFUSED, outcome

PEERS = ROOT / "host_sim" / "peers"
NOISY = {"adc", "imp", "all"}   # sets in which a seed tells


class CompareError(Exception):
    """One line for the user: what is wrong, and what was expected."""


@dataclass(frozen=True)
class Case:
    """A scenario with a set, whatever estimates."""

    scenario: str
    imperfections: str
    seed: int

    def arguments(self):
        return ["run", self.scenario, "--with", self.imperfections, "--set", f"scenario.seed={self.seed}"]

    def refusal(self, _):
        return None


@functools.cache
def zoo(variant, seed):
    """The campaign `zoo` or `zoo_user`, of that seed."""
    return campaign.changed(campaign.load(variant), seed=seed)


@dataclass(frozen=True)
class Motor:
    """A motor of the zoo in its scenario, whatever estimates."""

    variant: str    # a campaign
    seed: int
    number: int

    def arguments(self):
        found = zoo(self.variant, self.seed)
        return found.arguments(found.values(self.number))

    def refusal(self, message):
        return zoo(self.variant, self.seed).drawn.refusal(message)


@dataclass(frozen=True)
class Outcome:
    """What is compared: how a run ended, and its largest errors, transients included."""

    locked: bool
    speed_pct: float    # of rated speed
    angle_deg: float    # electrical
    ending: str         # as campaigns call it


def cases(scenarios, sets, seeds):
    """All runs of scenarios and sets; of a set without noise the first seed says all."""
    return [Case(scenario, name, seed) for scenario in scenarios for name in sets
            for seed in (seeds if name in NOISY else seeds[:1])]


def motors(variant, seed, count):
    return [Motor(variant, seed, number) for number in range(count)]


def asked(program, arguments, refusal=lambda _: None):
    """What the simulator prints, as JSON; `refusal` may have something else for what it refuses."""
    try:
        done = subprocess.run([str(program), *arguments], capture_output=True, text=True, check=False)
    except OSError as error:
        raise CompareError(f"{program}: {error.strerror}; expected motorsim: run tools/dev build") from error
    if done.returncode == BAD_INPUT:
        message = done.stderr.strip().removeprefix("motorsim: ")
        refused = refusal(message)
        if refused:
            return refused
        raise CompareError(message)
    try:
        return json.loads(done.stdout)
    except ValueError as error:
        raise CompareError(f"{program}: exit status {done.returncode} and no results; expected motorsim") from error


def run(program, case, estimator):
    """`estimator`: a name or a file of gains; None is the drive's own observer."""
    chosen = [] if estimator is None else ["--estimator", str(estimator)]
    metrics = asked(program, [*case.arguments(), "--json", "-", *chosen], case.refusal)
    ending = outcome(metrics)
    if ending == REFUSED:
        return Outcome(False, None, None, ending)
    return Outcome(metrics["locked"], metrics["speed_error_max_pct"], metrics["angle_error_max_deg"], ending)


def run_all(program, wanted, told=lambda: None):
    """Outcomes of (case, estimator), on all cores; `told` is called after each."""
    def one(pair):
        found = run(program, *pair)
        told()
        return found
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return list(pool.map(one, wanted))
