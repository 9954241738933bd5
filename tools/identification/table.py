# SPDX-License-Identifier: MIT
"""What many identifications have in common, as lines of a Markdown table."""

import statistics
from dataclasses import dataclass

PER_CENT = 100
ABSOLUTE = {"ns": 1e9, "LSB": 1, "% points": 1}   # units of what is no share of its truth, in one of the JSON's


@dataclass(frozen=True)
class Value:
    key: str
    title: str
    goal: float | None  # of the 95th percentile, in `unit`
    unit: str = "%"     # % of the truth, or a key of ABSOLUTE

    @property
    def relative(self):
        return self.unit not in ABSOLUTE


VALUES = (
    Value("resistance_ohm", "R", 2),
    Value("inductance_d_h", "L_d", 3),
    Value("inductance_q_h", "L_q at the continuous current", 3),
    Value("flux_linkage_wb", "flux linkage", 1.5),
    Value("inertia_kg_m2", "J", 5),
    Value("lost_time_s", "lost by a leg at the continuous current", 30, "ns"),
    Value("knee_a", "knee of a leg", None),
    Value("gain_mismatch_pct", "gain of sensor a over b", None, "% points"),
    Value("current_noise_lsb", "noise of the sensors", None, "LSB"),
    Value("viscous_friction_nm_s", "viscous friction", None),
    Value("coulomb_friction_nm", "Coulomb friction", None),
)


def measured(results):
    return [result for result in results if result["refusal"] is None]


def errors(value, results):
    """|error| and bar of each, in the value's unit."""
    found = []
    for result in results:
        entry = result[value.key]
        if value.relative and not entry["truth"]:
            continue
        scale = PER_CENT / entry["truth"] if value.relative else ABSOLUTE[value.unit]
        found.append((abs(entry["value"] - entry["truth"]) * scale, entry["bar"] * scale))
    return found


def percentile_95(numbers):
    return sorted(numbers)[int(0.95 * len(numbers))]


def row(value, results):
    found = errors(value, results)
    unit = value.unit
    goal = "" if value.goal is None else f"{value.goal:g} {unit}"
    median = statistics.median(error for error, _ in found)
    last = percentile_95([error for error, _ in found])
    bar = statistics.median(bar for _, bar in found)
    inside = PER_CENT * sum(error <= bar for error, bar in found) / len(found)
    return (f"| {value.title} | {goal} | {last:.2g} {unit} | {median:.2g} {unit} | {bar:.2g} {unit} | {inside:.1f} % |")


def all_inside_pct(results):
    pairs = [pair for value in VALUES for pair in errors(value, results)]
    return PER_CENT * sum(error <= bar for error, bar in pairs) / len(pairs)


def lines(results):
    good = measured(results)
    heads = ["| | goal | 95 % are off by less than | median error | median bar | truth within the bar |", "| --- | --- | --- | --- | --- | --- |"]
    return [*heads, *(row(value, good) for value in VALUES)]


def summary(results):
    """Lines below the table."""
    good = measured(results)
    times = sorted(result["duration_s"] for result in good)
    text = [f"{len(good)} of {len(results)} motors measured; {all_inside_pct(good):.1f} % of all values within their bars; "
            f"time {statistics.median(times):.0f} s, 95 % below {percentile_95(times):.0f} s, longest {times[-1]:.1f} s"]
    runs = [result["run"] for result in good if "locked" in result.get("run", {})]
    if runs:
        locked = [run for run in runs if run["locked"]]
        close = [run for run in locked if run["speed_error_command_pct"] <= 5 and run["speed_error_load_pct"] <= 2]
        text.append(f"{len(locked)} of {len(runs)} locked when run with the result, {len(close)} within 5 % after a command and 2 % "
                    "after a load")
    text += [f"{result['motor']}: {result['refusal']}" for result in results if result["refusal"] is not None]
    return text
