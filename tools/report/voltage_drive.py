# SPDX-License-Identifier: MIT
"""What the phase compensator saves: the currents of runs without current regulators, side by side."""

import html
import math

import numpy as np

from report.runs import TIME

KEY = "voltage-drive"
SCENARIOS = ("s4", "s5")
SETTLED_S = 1.0     # the last second of a run
COLUMNS = ("lead of the voltage, ° el.", "d current, A", "q current, A", "amplitude, A", "torque, N·m", "copper loss, W")
HOW = ("Motor B at 1200 rpm under 3 N·m, means of the last second of each run; amplitude: rms of the current vector; copper "
       "loss: 1.5·R·|i|². With no d current it is within 0.5 % of the least, which saliency gives with −0.19 A.")


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


def row(run, name):
    shown = figures(run)
    if shown is None:
        faults = ", ".join(map(str, run.metrics.get("faults") or [])) or "not in RUN"
        cells = f'<td data-label="{COLUMNS[0]}" colspan={len(COLUMNS)}>{html.escape(faults)}</td>'
    else:
        cells = "".join(f'<td data-label="{label}">{f"{round(value, 2) + 0.0:.2f}".replace("-", "−")}</td>'
                        for label, value in zip(COLUMNS, shown))
    return f"<tr><th scope=row>{html.escape(name)}</th>{cells}</tr>"


def entries(runs, conditions):
    """For page(): none without such a run. conditions(run): under which it ran, as text."""
    mine = [run for run in runs if run.scenario in SCENARIOS]
    if not mine:
        return []
    heads = "".join(f"<th scope=col>{label}</th>" for label in COLUMNS)
    rows = "\n".join(row(run, f"{run.scenario.upper()}, {conditions(run)}") for run in mine)
    return [(KEY, "current for a torque", f"""<section id="{KEY}">
<h2>Current for the same torque, with the compensator and short of it</h2>
<table class="cards">
<caption>{HOW}</caption>
<thead><tr><th scope=col>Run</th>{heads}</tr></thead>
<tbody>
{rows}
</tbody>
</table>
</section>""")]
