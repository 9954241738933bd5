# SPDX-License-Identifier: MIT
"""The measured errors of a run beside what paper A claims: all within 2 %."""

import math
from dataclasses import dataclass

CLAIM_PERCENT = 2.0
FULL_TURN_DEG = 360.0


@dataclass(frozen=True)
class Rated:
    """What an error of 100 % is; the currents are amplitudes."""

    speed_rpm: float
    i_q_a: float


# Paper A, table 1: 1800 rpm, 7.8 N·m = 1.5 · 2 pole pairs · 0.387 Wb · i_q.
MOTOR_A = Rated(1800.0, 7.8 / (1.5 * 2 * 0.387))
# Paper B, section 4: 1200 rpm, nominal point.
MOTOR_B = Rated(1200.0, 4.197)
RATED = {"s1": MOTOR_A, "s2": MOTOR_A, "s3": MOTOR_A, "s4": MOTOR_B, "s5": MOTOR_B}


@dataclass(frozen=True)
class Measure:
    """A column of the table: its name and the sentence that says how it is measured."""

    name: str
    how: str


MEASURES = (
    Measure("Speed, estimated", "The largest |actual − estimated| mechanical speed in the "
            "evaluated part of the run, transients included, as a share of the rated speed."),
    Measure("Speed, settled", "The largest |command − actual| speed from 0.15 s after each step of "
            "the command or the load, and after the drive's own ramp, to the next step; as a share "
            "of the command, or of the rated speed where the command is 0."),
    Measure("q current", "The largest |actual − estimated| q current, transients included, as a "
            "share of the q current of the rated point (motor A: the 6.72 A that give the rated "
            "7.8 N·m; motor B: 4.2 A), in other scenarios of the largest of the run."),
    Measure("Angle", "The largest |actual − estimated| electrical angle, transients included, as "
            "a share of a turn of 360°."),
)


@dataclass(frozen=True)
class Value:
    percent: float
    detail: str = ""

    @property
    def within(self):
        return self.percent <= CLAIM_PERCENT

    @property
    def text(self):
        """What two digits would show as 0 is said to be less."""
        return "< 0.01 %" if 0 < self.percent < 0.005 else f"{self.percent:.2f} %"


def number(metrics, key):
    """A metric as a number, or None where it is absent, null or no number."""
    value = metrics.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return None
    return float(value)


def rated_speed(run):
    """From the two forms in which a run gives its speed error, or else from its motor."""
    rpm = number(run.metrics, "speed_error_max_rpm")
    percent = number(run.metrics, "speed_error_max_pct")
    if rpm and percent:
        return 100.0 * rpm / percent
    rated = RATED.get(run.scenario)
    return rated.speed_rpm if rated else None


def full_current(run):
    """The rated q current, or the largest one of a run of an unknown motor, with that word."""
    rated = RATED.get(run.scenario)
    if rated:
        return rated.i_q_a, ""
    if run.trace.has(["i_q_a"]):
        return float(abs(run.trace["i_q_a"]).max()) or None, "largest "
    return None, ""


def bases(run):
    """What 100 % of an error is, by Panel.base."""
    found = {"speed": rated_speed(run), "current": full_current(run)[0], "turn": FULL_TURN_DEG}
    return {name: value for name, value in found.items() if value}


def values(run):
    """One Value a Measure, None where it does not apply."""
    metrics = run.metrics
    return (speed_value(metrics), settled_value(metrics), current_value(run), angle_value(metrics))


def speed_value(metrics):
    percent = number(metrics, "speed_error_max_pct")
    rpm = number(metrics, "speed_error_max_rpm")
    if percent is None:
        return None
    return Value(percent, "" if rpm is None else f"{rpm:.3g} rpm")


def settled_value(metrics):
    percent = number(metrics, "command_error_settled_pct")
    return None if percent is None else Value(percent)


def current_value(run):
    amperes = number(run.metrics, "iq_error_max_a")
    full, which = full_current(run)
    if amperes is None or not full:
        return None
    return Value(100.0 * amperes / full, f"{amperes:.3g} A of {which}{full:.3g} A")


def angle_value(metrics):
    degrees = number(metrics, "angle_error_max_deg")
    if degrees is None:
        return None
    return Value(100.0 * degrees / FULL_TURN_DEG, f"{degrees:.3g}° el.")


def failed_limits(metrics):
    """The scenario's own limits that the run broke, as texts; None if it names none."""
    for key, value in metrics.items():
        if "fail" in key and isinstance(value, list):
            return [str(item) for item in value]
    return None


def accepted(metrics):
    """Whether the run kept the scenario's limits; None if the metrics do not say."""
    if isinstance(metrics.get("accepted"), bool):
        return metrics["accepted"]
    failed = failed_limits(metrics)
    return None if failed is None else not failed
