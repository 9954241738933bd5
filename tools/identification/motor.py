# SPDX-License-Identifier: MIT
"""One simulated motor of the zoo: it is identified, and then run with what was found."""

import json
import random
import subprocess
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

NUMBERS = ("resistance_ohm", "inductance_d_h", "inductance_q_h", "flux_linkage_wb", "inertia_kg_m2")
DEAD_TIME = 0.5, 1.5     # of the board's
SATURATION_PCT = {"d": 10, "q": 20, "cross": 50}   # at most, as host_sim/imperfections/saturated.toml counts them
LONGEST_S = 120


@dataclass(frozen=True)
class Programs:
    motorsim: Path
    nfconfig: Path


@dataclass(frozen=True)
class Motor:
    """`seed` and `number` of the zoo; the draws of this file belong to both."""

    seed: int
    number: int

    @property
    def name(self):
        return f"zoo:{self.number}@{self.seed}:user"

    def plant(self, programs):
        """What is worse than `:user` makes it: dead time ±50 %, and saturated iron."""
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([programs.nfconfig, "zoo", self.name, "--out", f"{folder}/zoo"], check=True,
                           capture_output=True, text=True, timeout=LONGEST_S)
            board = tomllib.loads(Path(folder, "zoo/board.toml").read_text(encoding="utf-8"))["board"]
            plant = tomllib.loads(Path(folder, "zoo/user.toml").read_text(encoding="utf-8"))["plant"]
        draw = random.Random(f"{self.number}@{self.seed}")
        dead_time_s = board["dead_time_s"] * draw.uniform(*DEAD_TIME)
        # a knee is where the current charges the leg's output within the dead time
        knee_a = plant["commutation_knee_a"] * plant["dead_time_s"] / dead_time_s
        values = {"dead_time_s": dead_time_s, "commutation_knee_a": knee_a}
        values |= {f"saturation_{axis}_pct": draw.uniform(0, most) for axis, most in SATURATION_PCT.items()}
        return {key: f"{value:.6g}" for key, value in values.items()}

    def settings(self, plant):
        return [word for key, value in plant.items() for word in ("--set", f"plant.{key}={value}")]


def identify_command(programs, motor, plant, extra=()):
    return [str(programs.motorsim), "identify", motor.name, *motor.settings(plant), *extra]


def last_line(text, status):
    return (text.strip().splitlines() or [f"ended with status {status}, without a word"])[-1]


def trouble(error):
    """A program that failed, or that did not end, as a refusal."""
    name = Path(error.cmd[0]).name
    if isinstance(error, subprocess.TimeoutExpired):
        return f"{name}: no result within {error.timeout:g} s"
    return f"{name}: {last_line(error.stderr, error.returncode)}"


TROUBLES = subprocess.TimeoutExpired, subprocess.CalledProcessError


def identified(programs, motor, folder):
    """What `motorsim identify --json` says of it, with `refusal`. Leaves the motor file and the console's lines in `folder`."""
    try:
        return measured(programs, motor, folder)
    except TROUBLES as error:
        return {"motor": motor.name, "refusal": trouble(error)}


def measured(programs, motor, folder):
    plant = motor.plant(programs)
    stem = f"{folder}/{motor.number}"
    command = identify_command(programs, motor, plant, ["--json", "-", "-o", f"{stem}.toml", "--overwrite", "--log", f"{stem}.log"])
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONGEST_S)
    refusal = None if done.returncode == 0 else last_line(done.stderr, done.returncode)
    found = {"motor": motor.name, "plant": plant, "refusal": refusal}
    if done.returncode == 0:
        written = tomllib.loads(Path(f"{stem}.toml").read_text(encoding="utf-8"))
        found |= json.loads(done.stdout)
        found |= {"rated_torque_nm": written["motor"]["rated_torque_nm"], "speed_rpm": written["measured"]["speed_rpm"]}
    return found


def run_command(programs, motor, found, folder):
    """The motor in its scenario with the identified file: the scales make the true machine of that file."""
    scale = {key: found[key]["truth"] / found[key]["value"] for key in NUMBERS}
    plant = found["plant"] | {
        "resistance_scale": scale["resistance_ohm"], "inductance_scale": scale["inductance_d_h"],
        "saliency_scale": scale["inductance_q_h"] / scale["inductance_d_h"], "flux_scale": scale["flux_linkage_wb"],
        "inertia_scale": scale["inertia_kg_m2"]}
    return [str(programs.motorsim), "run", motor.name, "--motor", f"{folder}/{motor.number}.toml", *motor.settings(plant),
            "--json", "-"]


def driven(programs, motor, found, folder):
    try:
        done = subprocess.run(run_command(programs, motor, found, folder), capture_output=True, text=True, check=False,
                              timeout=LONGEST_S)
    except TROUBLES as error:
        return {"refusal": trouble(error)}
    if not done.stdout:
        return {"refusal": last_line(done.stderr, done.returncode)}
    metrics = json.loads(done.stdout)
    return {key: metrics[key] for key in ("locked", "limit_cycle", "faults", "speed_error_command_pct", "speed_error_load_pct")}
