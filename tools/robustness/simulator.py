# SPDX-License-Identifier: MIT
"""The simulator as a campaign uses it: commands, trial runs, and what a run's result is."""

import json
import os
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

from . import worker
from .campaign import ROOT, CampaignError

MOTORSIM = ROOT / "build" / "host" / "motorsim"
BAD_INPUT = 2
OUTCOMES = LOCKED, REFUSED, OFF_LIMITS, FAILED_SAFE, UNCONTROLLED = (
    "locked", "refused", "held, off limits", "failed safe", "uncontrolled")
KINDS = ("motors", "boards", "tunings", "imperfections", "scenarios")
# Of motorsim's results, those that are kept: all but what a campaign states itself.
NOT_KEPT = ("scenario", "with", "notes", "seed", "saturations")


@dataclass(frozen=True)
class Simulator:
    path: Path

    def command(self, campaign, values):
        return [str(self.path), *campaign.arguments(values)]

    def rerun(self, campaign, run, extra=()):
        """The full command of one run."""
        return [*self.command(campaign, campaign.values(run)), *extra]


def find(path):
    if not os.access(path, os.X_OK) or path.is_dir():
        raise CampaignError(f"{path}: no program; expected motorsim: run tools/dev build")
    return Simulator(path.resolve())


def data_files(campaign):
    """All files that a run may read: those of the data folder, and what the campaign names."""
    folder = Path(os.environ.get("NEUROFOC_DATA") or ROOT / "host_sim").resolve()
    found = {path for kind in KINDS for path in (folder / kind).glob("*.toml")}
    words, _ = campaign.drawn.words(campaign.values(0))
    found |= {path for path in map(Path, words) if path.is_file()}
    return sorted(map(str, found))


def try_out(simulator, campaign):
    """Refuses a campaign that the simulator does, at the ends of all ranges and in run 0."""
    for values in (*campaign.corners(), campaign.values(0)):
        command = [*simulator.command(campaign, values), "--json", "-"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        message = done.stderr.strip().rpartition("\n")[2]
        result_of(campaign, done.returncode, done.stdout, message)


def result_of(campaign, status, output, message):
    """The metrics that a run has printed; refuses a run without."""
    refusal = campaign.drawn.refusal(message) if status == BAD_INPUT else None
    if refusal:
        return refusal
    if status == BAD_INPUT:
        reason = message.removeprefix("motorsim: ").removeprefix("--set: ")
        raise CampaignError(f"{campaign.path}: {reason}")
    try:
        metrics = json.loads(output)
        metrics = {key: value for key, value in metrics.items() if key not in NOT_KEPT}
        outcome(metrics)
    except (ValueError, AttributeError, KeyError) as error:
        raise CampaignError(f"motorsim: exit status {status}, {message or 'no message'}; "
                            "expected a run's results as JSON") from error
    if "accepted" not in metrics:
        scenario = campaign.drawn.words(campaign.values(0))[0][0]
        raise CampaignError(f"{campaign.path}: scenario {scenario} has no limits for these "
                            "imperfection sets; expected [accept.any] in it")
    return metrics


def outcome(metrics):
    """How a run ended: within the scenario's limits, else in a latched fault with open gates, else
    with the rotor held all the time, only not as well as the limits ask. A motor of the zoo may be
    refused."""
    if "refused" in metrics:
        return REFUSED
    if metrics.get("accepted"):
        return LOCKED
    if metrics["state_final"] == "FAULT" and not metrics["gates_enabled_final"]:
        return FAILED_SAFE
    if metrics["locked"] and metrics["state_final"] != "FAULT" and metrics["gates_enabled_final"]:
        return OFF_LIMITS
    return UNCONTROLLED


def fingerprint(simulator, campaign):
    try:
        return worker.fingerprint(str(simulator.path), data_files(campaign))
    except OSError as error:
        raise CampaignError(f"{error.filename}: {error.strerror}; expected a file to read") from error


def as_shell(command):
    """A command to copy: the simulator relative to where one is, if it is below."""
    path = Path(command[0])
    here = Path.cwd()
    shown = path.relative_to(here) if path.is_relative_to(here) else path
    return shlex.join([str(shown), *command[1:]])
