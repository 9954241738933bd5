# SPDX-License-Identifier: MIT
"""What the phase compensator saves: the currents of runs without current regulators, side by side."""

import math

import numpy as np

from report.render import render
from report.runs import TIME

KEY = "voltage-drive"
SCENARIOS = ("s4", "s5")
SETTLED_S = 1.0     # the last second of a run
COLUMNS = ("lead of the voltage, ° el.", "d current, A", "q current, A", "amplitude, A", "torque, N·m", "copper loss, W")


def side(values):
    return np.where(values < 0, -1.0, 1.0)


def lead_deg(trace):
    """Mean lead of the voltage on the rotor's q axis, in the direction of rotation."""
    forwards = side(trace["v_q_v"])
    in_frame = np.degrees(np.arctan2(-trace["v_d_v"] * forwards, trace["v_q_v"] * forwards))
    return float(np.mean(in_frame - trace["angle_error_el_deg"]))


def figures(run):
    """The numbers of COLUMNS; None where the run ended otherwise than in RUN."""
    trace = run.trace.cut(start=run.trace[TIME][-1] - SETTLED_S)
    if (trace["state"] != "RUN").any():
        return None
    square = float(np.mean(trace["i_d_a"] ** 2 + trace["i_q_a"] ** 2))
    resistance = run.metrics["parameters"]["resistance_ohm"]["actual"]
    return (lead_deg(trace), float(np.mean(trace["i_d_a"])), float(np.mean(trace["i_q_a"])), math.sqrt(square),
            float(np.mean(trace["torque_nm"])), 1.5 * resistance * square)


def row(run):
    """The texts of COLUMNS, or what happened in place of them."""
    shown = figures(run)
    if shown is None:
        return [", ".join(map(str, run.metrics.get("faults") or [])) or "not in RUN"]
    return [f"{round(value, 2) + 0.0:.2f}".replace("-", "−") for value in shown]


def entries(runs, conditions):
    """For page(): none without such a run. conditions(run): under which it ran, as text."""
    rows = [(f"{run.scenario.upper()}, {conditions(run)}", *row(run)) for run in runs if run.scenario in SCENARIOS]
    if not rows:
        return []
    return [(KEY, "current for a torque",
             render("report/voltage_drive.jinja", key=KEY, columns=["Run", *COLUMNS], rows=rows))]
