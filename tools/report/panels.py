# SPDX-License-Identifier: MIT
"""The panels that a figure can be made of. Differences are the first name minus the second."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Line:
    column: str
    role: str               # what it is, hence its colour: see style.ROLES
    minus: str | None = None

    def columns(self):
        return [self.column] if self.minus is None else [self.column, self.minus]

    def values(self, trace):
        values = trace[self.column]
        return values if self.minus is None else values - trace[self.minus]


@dataclass(frozen=True)
class Panel:
    title: str
    unit: str
    lines: tuple
    kind: str = "lines"     # lines, angle (wraps at 360°), zoom (an angle in windows), state
    base: str | None = None  # an error: what its percentage refers to, a key of claim.bases()

    def columns(self):
        return [name for line in self.lines for name in line.columns()]


def with_unit(number, unit):
    """`3 A`, but `3° el.`; with a true minus sign."""
    return f"{number}{'' if unit.startswith('°') else ' '}{unit}".replace("-", "−")


def speed(*roles):
    columns = {"command": "speed_command_rpm", "reference": "speed_reference_rpm",
               "actual": "speed_rpm", "estimated": "speed_estimated_rpm"}
    return tuple(Line(columns[role], role) for role in roles)


def difference(column, minus=None):
    return (Line(column, "difference", minus),)


ANGLES = (Line("angle_el_deg", "actual"), Line("angle_estimated_el_deg", "estimated"))
I_D = Line("i_d_a", "actual")
I_Q = Line("i_q_a", "actual")
I_Q_ESTIMATED = Line("i_q_estimated_a", "estimated")

# The panels that `tools/plot.py trace --panels` knows by name.
CATALOGUE = {
    "state": Panel("state of the drive", "", (Line("state", "actual"),), "state"),
    "speed": Panel("speed", "rpm", speed("command", "reference", "actual", "estimated")),
    "speed-error": Panel("actual − estimated speed", "rpm",
                         difference("speed_rpm", "speed_estimated_rpm"), base="speed"),
    "command-error": Panel("command − estimated speed", "rpm",
                           difference("speed_command_rpm", "speed_estimated_rpm"), base="speed"),
    "position": Panel("position (mechanical)", "rad", (
        Line("position_command_rad", "command"), Line("position_rad", "actual"),
        Line("position_estimated_rad", "estimated"))),
    "position-error": Panel("actual − estimated position", "rad",
                            difference("position_rad", "position_estimated_rad")),
    "angle": Panel("electrical angle", "° el.", ANGLES, "angle"),
    "angle-zoom": Panel("electrical angle at the steps and the end", "° el.", ANGLES, "zoom"),
    "angle-error": Panel("actual − estimated angle", "° el.",
                         difference("angle_error_el_deg"), base="turn"),
    "iq": Panel("q current", "A",
                (Line("i_q_reference_a", "reference"), I_Q, I_Q_ESTIMATED)),
    "iq-error": Panel("actual − estimated q current", "A",
                      difference("i_q_a", "i_q_estimated_a"), base="current"),
    "id": Panel("d current", "A", (I_D, Line("i_d_estimated_a", "estimated"))),
    "phases": Panel("phase currents", "A", (
        Line("i_a_a", "a"), Line("i_b_a", "b"), Line("i_c_a", "c"))),
    "voltage": Panel("voltage", "V", (Line("v_d_v", "d"), Line("v_q_v", "q"))),
    "duty": Panel("duty", "1", (Line("duty_a", "a"), Line("duty_b", "b"), Line("duty_c", "c"))),
    "bus": Panel("DC link", "V", (Line("bus_v", "actual"),)),
    "torque-command": Panel("torque asked for", "N·m", (Line("torque_command_nm", "command"),
                                                        Line("torque_nm", "actual"))),
    "torque": Panel("torque", "N·m", (Line("load_torque_nm", "load"),
                                      Line("torque_nm", "actual"))),
}
