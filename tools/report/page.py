# SPDX-License-Identifier: MIT
"""The report as one HTML page: text, tables and inline figures, nothing from elsewhere."""

from report import claim
from report.panels import with_unit
from report.render import render

TITLES = {
    "s1": "speed command 0 → 1000 → 1800 rpm without load",
    "s2": "load of 3 N·m from 0.5 s to 0.8 s at 1800 rpm",
    "s3": "position command 0 → 3π → −3π rad",
    "s4": "voltage drive with the sensor's angle, load of 3 N·m from 0.1 s on",
    "s5": "voltage drive with the estimated angle, load of 3 N·m from 0.1 s on",
    "s_weakening": "2600 rpm both ways with a weakened field, load of 3 N·m at 2600 rpm",
    "s_weakening_compressor": "6500 rpm both ways with a weakened field, salient compressor motor, load of 0.8 N·m at 6500 rpm",
}
METRICS = {     # key: name, unit
    "speed_error_max_rpm": ("speed error, largest", "rpm"),
    "speed_error_rms_rpm": ("speed error, rms", "rpm"),
    "speed_error_max_pct": ("speed error, largest", "% of rated"),
    "command_error_settled_pct": ("command error, settled", "%"),
    "angle_error_max_deg": ("angle error, largest", "° el."),
    "iq_error_max_a": ("q current error, largest", "A"),
    "settling_time_s": ("settling time", "s"),
    "overshoot_pct": ("overshoot", "%"),
    "speed_dip_rpm": ("speed dip", "rpm"),
    "recovery_time_s": ("recovery time", "s"),
    "position_error_final_rad": ("position error, final", "rad"),
    "id_settled_a": ("d current, settled", "A"),
    "angle_error_rms_deg": ("angle error, rms", "° el."),
    "speed_error_command_pct": ("speed error after command steps, largest", "% of rated"),
    "speed_error_load_pct": ("speed error after load steps, largest", "% of rated"),
    "ripple_speed_pct": ("ripple of speed that the rotor's turning forces", "% of rated"),
    "ripple_current_pct": ("ripple of torque current, likewise", "% of rated"),
    "swing_speed_pct": ("sustained swing of speed", "% of rated"),
    "swing_current_pct": ("sustained swing of torque current", "% of rated"),
    "swing_hz": ("its frequency", "Hz"),
    "lost_time_s": ("rotor lost at", "s"),
    "locked": ("rotor kept", ""),
    "locked_coarse": ("rotor kept, against rated speed", ""),
    "limit_cycle": ("swings", ""),
    "reached": ("commands reached", ""),
    "faults": ("faults", ""),
    "saturations": ("saturations", ""),
    "saturation_internal_count": ("saturations inside the arithmetic", ""),
}
HEADED = ("scenario", "with", "set", "seed", "accepted")   # shown in the heading of a run


def page(entries, more=()):
    """The page of (run, pictures) pairs, and of (identifier, title, section) of what follows them."""
    runs = [run for run, _ in entries]
    links = [*((run.name, heading(run)) for run in runs), *((name, title) for name, title, _ in more)]
    return render("report/page.jinja", summary=summary(runs), links=links, measures=claim.MEASURES,
                  claimed=f"{claim.CLAIM_PERCENT:g} %", runs=[shown(run, pictures) for run, pictures in entries],
                  sections=[section for _, _, section in more])


def shown(run, pictures):
    """A run as the template needs it."""
    return {"name": run.name, "heading": heading(run), "title": TITLES.get(run.scenario), "conditions": conditions(run),
            "errors": claim.values(run), "kept": claim.accepted(run.metrics),
            "failed": "; ".join(claim.failed_limits(run.metrics) or []), "pictures": pictures, "metrics": metrics(run)}


def summary(runs):
    judged = [value for run in runs for value in claim.values(run) if value]
    within = sum(value.within for value in judged)
    kept = [kept for kept in (claim.accepted(run.metrics) for run in runs) if kept is not None]
    text = (f"{count(len(runs), 'run')}; {within} of {len(judged)} errors are within the "
            f"{claim.CLAIM_PERCENT:g} % that paper A claims.")
    if kept:
        text += f" {sum(kept)} of {len(kept)} runs with limits of their own kept them."
    return text


def count(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


def heading(run):
    name = run.scenario.upper() if run.scenario in TITLES else run.scenario
    return name if run.name.lower() == run.scenario else f"{name} ({run.name})"


def conditions(run):
    imperfections = run.metrics.get("with") or []
    if isinstance(imperfections, str):
        imperfections = [imperfections]
    text = ", ".join(map(str, imperfections)) or "ideal"
    settings = run.metrics.get("set") or []
    if settings:
        text += f"; {', '.join(map(str, settings))}"
    return text if run.metrics.get("seed") is None else f"{text}, seed {run.metrics['seed']}"


def metrics(run):
    """Names and values as texts."""
    known = [key for key in METRICS if key in run.metrics]
    other = [key for key in run.metrics if key not in METRICS and key not in HEADED]
    return [metric(key, run.metrics[key]) for key in known + other]


def metric(key, value):
    name, unit = METRICS.get(key, (key.replace("_", " "), ""))
    text = metric_text(value)
    return name, with_unit(text, unit) if unit and value is not None else text


def metric_text(value):
    if value is None:
        return "does not apply"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}".replace("-", "−")
    if isinstance(value, dict):
        counted = [f"{key}: {metric_text(item)}" for key, item in value.items() if item != 0]
        return ", ".join(counted) or "none"
    if isinstance(value, list):
        return ", ".join(map(metric_text, value)) or "none"
    return str(value)
