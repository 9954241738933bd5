# SPDX-License-Identifier: MIT
"""What many identifications have in common, as lines of a Markdown table and as sentences."""

import math
import statistics
import textwrap
from collections.abc import Callable
from dataclasses import dataclass

PER_CENT, NANO = 100, 1e9
RAD_S_PER_RPM = math.pi / 30
# What is asked for beside the errors of the values below.
INSIDE_PCT, BAR_OVER_ERROR, LONGEST_S, HELD_PCT = 95, 2, 20, 99
COMMAND_PCT, LOAD_PCT = 5, 2     # of the speed, in a run with the result
WIDTH = 132     # of a line of a page


def of_truth(result, key):
    truth = result[key]["truth"]
    return PER_CENT / truth if truth else None


def as_nanoseconds(_result, _key):
    return NANO


def as_it_is(_result, _key):
    return 1


def of_rated_torque(result, _key):
    return PER_CENT / result["rated_torque_nm"]


def torque_at_speed(result, key):
    """Of a friction that goes with the speed, at the highest one of the measurement."""
    return of_rated_torque(result, key) * result["speed_rpm"] * RAD_S_PER_RPM


@dataclass(frozen=True)
class Value:
    key: str
    title: str
    goal: float | None = None       # of the 95th percentile, in its unit
    scale: Callable = of_truth      # of a result's value, to its unit; None: such a result says nothing
    unit: str = "%"


VALUES = (
    Value("resistance_ohm", "R", 2),
    Value("inductance_d_h", "L_d", 3),
    Value("inductance_q_h", "L_q at the continuous current", 3),
    Value("flux_linkage_wb", "flux linkage", 1.5),
    Value("inertia_kg_m2", "J", 5),
    Value("lost_time_s", "lost by a leg at the continuous current", 30, as_nanoseconds, "ns"),
    Value("knee_a", "knee of a leg"),
    Value("gain_mismatch_pct", "gain of sensor a over b", None, as_it_is, "% points"),
    Value("current_noise_lsb", "noise of the sensors", None, as_it_is, "LSB"),
    Value("viscous_friction_nm_s", "viscous friction at the highest speed, of rated torque", None, torque_at_speed),
    Value("coulomb_friction_nm", "Coulomb friction, of rated torque", None, of_rated_torque),
)
FRICTION = VALUES[-2:]


def measured(results):
    return [result for result in results if result["refusal"] is None]


def errors(value, results):
    """|error| and bar of each, in the value's unit."""
    found = []
    for result in results:
        entry, scale = result[value.key], value.scale(result, value.key)
        if scale is not None:
            found.append((abs(entry["value"] - entry["truth"]) * scale, entry["bar"] * scale))
    return found


def percentile_95(numbers):
    return sorted(numbers)[int(0.95 * len(numbers))]


def share_pct(flags):
    """Of at least one."""
    flags = list(flags)
    return PER_CENT * sum(flags) / len(flags)


@dataclass(frozen=True)
class Statistics:
    """Of one value, with at least one result."""

    last: float         # 95 % are off by less
    median: float
    bar: float          # median
    inside_pct: float   # truths within their bars

    @property
    def ratio(self):
        return self.bar / self.median if self.median else math.inf


def statistics_of(value, results):
    found = errors(value, results)
    if not found:
        return None
    return Statistics(percentile_95([error for error, _ in found]), statistics.median(error for error, _ in found),
                      statistics.median(bar for _, bar in found), share_pct(error <= bar for error, bar in found))


def row(value, results):
    found = statistics_of(value, results)
    goal = "" if value.goal is None else f"{value.goal:g} {value.unit}"
    if found is None:
        return f"| {value.title} | {goal} | none measured | | | | |"
    unit = value.unit
    return (f"| {value.title} | {goal} | {found.last:.2g} {unit} | {found.median:.2g} {unit} | {found.bar:.2g} {unit} | "
            f"{found.ratio:.1f} | {found.inside_pct:.1f} % |")


def all_inside_pct(results):
    return share_pct(error <= bar for value in VALUES for error, bar in errors(value, results))


def lines(results):
    good = measured(results)
    heads = ["| | goal | 95 % are off by less than | median error | median bar | bar over error | truth within the bar |",
             f"| --- |{' --- |' * 6}"]
    return [*heads, *(row(value, good) for value in VALUES)]


# ---- what is said below the table ----


def runs_of(results):
    """Those that a result was run in."""
    return [result["run"] for result in measured(results) if "locked" in result.get("run", {})]


def is_close(run):
    return run["locked"] and run["speed_error_command_pct"] <= COMMAND_PCT and run["speed_error_load_pct"] <= LOAD_PCT


def friction_off(results):
    """Error of both frictions together at the highest speed, in % of rated torque."""
    return [abs(sum((result[value.key]["value"] - result[value.key]["truth"]) * value.scale(result, value.key) for value in FRICTION))
            for result in results]


def said_of_identifications(results, seed):
    good = measured(results)
    if not good:
        return f"{len(results)} motors of seed {seed}. None measured."
    times = sorted(result["duration_s"] for result in good)
    friction = friction_off(good)
    return (f"{len(results)} motors of seed {seed}. {len(good)} were measured, in {statistics.median(times):.1f} s at the median, "
            f"{percentile_95(times):.1f} s for 95 %, {times[-1]:.1f} s for the slowest. "
            f"{share_pct(time > LONGEST_S for time in times):.1f} % took more than {LONGEST_S} s. "
            f"{all_inside_pct(good):.1f} % of all values lie within their bars. The friction torque at the highest speed is off by "
            f"{statistics.median(friction):.2g} % of rated torque at the median, by less than {percentile_95(friction):.2g} % in 95 %.")


def said_of_runs(results):
    runs = runs_of(results)
    if not runs:
        return "The drive ran with none of the results."
    return (f"The drive ran with {len(runs)} of the results, in the scenario of the zoo. "
            f"It locked {share_pct(run['locked'] for run in runs):.1f} %; {share_pct(map(is_close, runs)):.1f} % were locked and within "
            f"{COMMAND_PCT} % after a command and {LOAD_PCT} % after a load.")


def missed_by(value, results):
    """By the figures as they are shown: nobody sees that 2.0 is more than 2."""
    found = statistics_of(value, results)
    if found is None or value.goal is None:
        return []
    missed = []
    if float(f"{found.last:.2g}") > value.goal:
        missed.append(f"95 % are off by less than {found.last:.2g} {value.unit}, in place of {value.goal:g} {value.unit}")
    if round(found.inside_pct, 1) < INSIDE_PCT:
        missed.append(f"{found.inside_pct:.1f} % of the truths lie within their bars, in place of {INSIDE_PCT} %")
    if round(found.ratio, 1) > BAR_OVER_ERROR:
        missed.append(f"the median bar is {found.ratio:.1f} times the median error, in place of {BAR_OVER_ERROR}")
    return [f"{value.title}: {text}." for text in missed]


def missed(results):
    """A sentence for each goal that is not met."""
    good, runs = measured(results), runs_of(results)
    found = [text for value in VALUES for text in missed_by(value, good)]
    late_pct = share_pct(result["duration_s"] > LONGEST_S for result in good) if good else 0
    if late_pct > 0:
        found.append(f"Time: {late_pct:.1f} % took more than {LONGEST_S} s.")
    for title, held in (("Locked", [run["locked"] for run in runs]), ("Locked and close", list(map(is_close, runs)))):
        if held and share_pct(held) < HELD_PCT:
            found.append(f"{title}: {share_pct(held):.1f} % of the runs, in place of {HELD_PCT} %.")
    return found


def refused(results):
    """What was not measured, or not run."""
    texts = [f"{result['motor']}: {result['refusal']}" for result in results if result["refusal"] is not None]
    runs = [(result["motor"], result.get("run", {}).get("refusal")) for result in measured(results)]
    return texts + [f"{motor}, run with the result: {refusal}" for motor, refusal in runs if refusal is not None]


def summary(results, seed):
    """Lines below the table."""
    goals = missed(results)
    bullets = ["Goals that are not met:", "", *(f"- {text}" for text in goals)] if goals else ["All goals are met."]
    said = [textwrap.fill(text, WIDTH) for text in (said_of_identifications(results, seed), said_of_runs(results))]
    return [said[0], "", said[1], "", *bullets]
