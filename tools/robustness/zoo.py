# SPDX-License-Identifier: MIT
"""Campaigns over the motors of the zoo: each run has another motor on another board.

host_sim/zoo/ draws them. Its classes take turns, so that a part of a campaign has as many of each.
"""

import re
from dataclasses import dataclass

from .axes import Axis, Ranked
from .distributions import Choice

VARIANTS = EXACT, USER = "exact", "user"
# What cannot be done with any number format: see check_speed() in host_sim/config/units/weakening_units.cpp.
PHYSICS = re.compile("the motor's EMF exceeds|the EMF charges the bus|shorts the motor|the rotor turns more than 0.7 rad in a PWM period")
REFUSAL = re.compile("does not fit the firmware")
FOR_PHYSICS, FOR_FORMAT = "physics", "number format"
# Nothing is broken in the zoo: wires are whole, sensors read what flows, no tick is late.
FALSE_FAULTS = {"CURRENT_OFFSET", "ADC_STUCK", "LOST_PHASE", "OVERTEMPERATURE", "LATE", "CONFIGURATION",
                "CURRENT_IMPLAUSIBLE"}


@dataclass(frozen=True)
class Zoo:
    variant: str    # the real motor is what its file says, or a user's
    classes: tuple  # of host_sim/zoo

    def values(self, seed, run):
        kind = self.classes[run % len(self.classes)]
        return {"motor": f"zoo:{kind}:{run}@{seed}"}

    def corners(self):
        return []

    def words(self, values):
        return [values["motor"] + (":user" if self.variant == USER else "")], {}

    def settings(self):
        return {"zoo": self.variant, "classes": ", ".join(self.classes)}

    def axes(self, rows):
        """The class, and the dimensionless numbers of the runs; a motor that is refused has none."""
        known = [row["metrics"]["dimensionless"] for row in rows if has_numbers(row)]
        axes = {"class": Axis(Choice(self.classes), class_of)} if len(self.classes) > 1 else {}
        for name in known[0] if known else ():
            ordered = tuple(sorted(numbers[name] for numbers in known))
            axes[name] = Axis(Ranked(ordered), lambda row, name=name: row["metrics"]["dimensionless"][name])
        return axes

    def refusal(self, message):
        """What a refused motor has for results; None where something else is wrong."""
        if not REFUSAL.search(message):
            return None
        return {"refused": message, "refused_for": FOR_PHYSICS if PHYSICS.search(message) else FOR_FORMAT}


def has_numbers(row):
    return "dimensionless" in row["metrics"]


def class_of(row):
    return row["values"]["motor"].split(":")[1]


def names_of_faults(row):
    return [text.split("@")[0] for text in row["metrics"].get("faults", ())]


def false_faults(row):
    """The faults of a run that name a broken part."""
    return sorted(set(names_of_faults(row)) & FALSE_FAULTS)
