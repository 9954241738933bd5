# SPDX-License-Identifier: MIT
"""What the firmware's words mean: the table that `motorsim signals` prints. Knows nothing of gdb."""

import argparse
import json
import shlex
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
MOTORSIM = ROOT / "build/host/motorsim"
TURN = 2**32
SPEED = "drive.rotor.observer.speed"  # one of those that are steps a tick
NAME_WIDTH, VALUE_WIDTH, RAW_WIDTH = 35, 19, 11  # as motorsim's own lines


class TableError(Exception):
    """There is no table; the text says why."""


class Word:
    """A word of the firmware: SI = (raw − zero)·one."""

    def __init__(self, entry):
        self.name, self.home, self.member = entry["name"], entry["home"], entry["member"]
        self.unit, self.format = entry["unit"], entry["format"]
        self.one, self.zero = entry["one"], entry["zero"]

    @property
    def is_plain(self):
        """Its raw value says it all."""
        return self.one == 1 and self.zero == 0

    def si_text(self, raw):
        """The value with its unit."""
        return f"{(raw - self.zero) * self.one:.6g} {self.unit}".rstrip()

    def text(self, raw):
        """As a value in gdb."""
        return f"{self.si_text(raw)} (raw {raw}, {self.format})"

    def line(self, raw):
        """As a line of a list."""
        si = f"{(raw - self.zero) * self.one:.6g} {self.unit}"
        return f"{self.name:<{NAME_WIDTH}} {si:<{VALUE_WIDTH}} raw {raw:<{RAW_WIDTH}} {self.format}"


class Table:
    """The words and stages of one scenario's configuration."""

    def __init__(self, content):
        self.scenario, self.crc, self.bases = (content[key] for key in ("scenario", "crc", "bases"))
        self.stages = content["stages"]
        self.words = {entry["name"]: Word(entry) for entry in content["words"]}

    def speed_text(self, step):
        """A step a tick as speed of the shaft, and of the rotor's field."""
        rad_s = step / TURN * 6.283185307179586 / self.bases["control_period_s"]
        return f"{step * self.words[SPEED].one:.6g} rpm, {rad_s:.6g} rad/s el"

    def __str__(self):
        bases = self.bases
        return (f"{self.scenario}: I_b = {bases['current_a']:g} A, U_b = {bases['voltage_v']:g} V, "
                f"{bases['control_period_s'] * 1e6:g} us a tick, {bases['pole_pairs']} pole pairs")


class Parser(argparse.ArgumentParser):
    """Bad arguments are not its to report: the program does."""

    def error(self, message):
        """In place of an exit."""
        raise ValueError(message)


def choice_of(arguments):
    """Of motorsim's arguments those that choose a configuration, or None."""
    parser = Parser(add_help=False)
    parser.add_argument("command", choices=("run", "debug"))
    parser.add_argument("scenario")
    parser.add_argument("--with", action="append", default=[], dest="sets")
    parser.add_argument("--set", action="append", default=[], dest="settings")
    try:
        chosen, _ = parser.parse_known_args(shlex.split(arguments))
    except ValueError:
        return None
    return [chosen.scenario, *(f"--with={name}" for name in chosen.sets),
            *(f"--set={setting}" for setting in chosen.settings)]


def load(choice, motorsim=MOTORSIM):
    """The table of a configuration, chosen as for motorsim. Raises TableError."""
    try:
        run = subprocess.run([motorsim, "signals", *choice], capture_output=True, text=True,
                             check=False)
    except OSError as error:
        raise TableError(f"{motorsim}: {error.strerror}; `cmake --build --preset host` makes it") from error
    if run.returncode:
        raise TableError(run.stderr.strip())
    return Table(json.loads(run.stdout))
