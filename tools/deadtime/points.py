# SPDX-License-Identifier: MIT
"""Where the effect of the dead time is measured: constant speeds under constant loads, with and without."""

import itertools
from dataclasses import dataclass

SCENARIO = "steady"
SETS = ("deadtime", "imp", "all")
SPEEDS_RPM = (200, 400, 900)    # 10 % of the rated speed, where the network takes over, is 180
LOADS_NM = (0, 1, 3)
UNKNOWN = ("model.dead_time_s=0", "model.device_drop_v=0")


@dataclass(frozen=True)
class Point:
    imperfections: str
    speed_rpm: int
    load_nm: int
    given_back: bool = True

    def arguments(self):
        """Of `motorsim`, but for its outputs."""
        settings = [f"scenario.command=[{{time_s=-1.4, speed_rpm={self.speed_rpm}}}]",
                    f"scenario.load=[{{time_s=-0.7, torque_nm={self.load_nm}}}]"]
        settings += [] if self.given_back else UNKNOWN
        return ["run", SCENARIO, "--with", self.imperfections,
                *(word for setting in settings for word in ("--set", setting))]


def pairs(sets=SETS):
    """All points of these sets as (with, without) compensation."""
    return [tuple(Point(*where, given_back) for given_back in (True, False))
            for where in itertools.product(sets, SPEEDS_RPM, LOADS_NM)]


# Those that are drawn: the lowest speed, and one at which the drive without compensation is at rest as well.
SHOWN = (("deadtime", 200, 3), ("deadtime", 900, 3))
