# SPDX-License-Identifier: MIT
"""What a run has measured, as names and texts."""

from report.panels import with_unit

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
    "torque_error_settled_pct": ("torque error, settled", "% of rated"),
    "locked": ("rotor kept", ""),
    "locked_coarse": ("rotor kept, against rated speed", ""),
    "limit_cycle": ("swings", ""),
    "reached": ("commands reached", ""),
    "state_final": ("state at the end", ""),
    "gates_enabled_final": ("gates on at the end", ""),
    "faults": ("faults", ""),
    "saturations": ("saturations", ""),
    "saturation_internal_count": ("saturations inside the arithmetic", ""),
}
HEADED = ("scenario", "with", "set", "seed", "accepted")   # shown in the heading of a run
UNITS = {"_ohm": "Ω", "_h": "H", "_wb": "Wb", "_kg_m2": "kg·m²", "_rpm": "rpm", "_a": "A"}  # by the end of a key


def known_first(run):
    return [key for key in METRICS if key in run.metrics] + [key for key in run.metrics if key not in METRICS and key not in HEADED]


def is_table(key, value):
    return isinstance(value, dict) and key not in METRICS


def figures(run):
    """(name, text) of each that applies."""
    return [figure(key, run.metrics[key]) for key in known_first(run)
            if run.metrics[key] is not None and not is_table(key, run.metrics[key])]


def without(run):
    """Names of those that do not apply to the run."""
    return [name_of(key) for key in known_first(run) if run.metrics[key] is None]


def tables(run):
    """(title, columns, rows) of what has members: the machine, its parameters, its dimensionless numbers."""
    return [table(key, value) for key, value in run.metrics.items() if is_table(key, value) and value]


def table(title, members):
    columns = list(dict.fromkeys(name for value in members.values() if isinstance(value, dict) for name in value)) or ["value"]
    rows = [[head(key), *cells(value, columns)] for key, value in members.items()]
    return spoken(title), ["", *columns], rows


def cells(value, columns):
    return [text_of(value.get(name)) for name in columns] if isinstance(value, dict) else [text_of(value)]


def ending(key):
    return next((end for end in UNITS if key.endswith(end)), "")


def head(key):
    unit = UNITS.get(ending(key))
    return f"{spoken(key)}, {unit}" if unit else spoken(key)


def spoken(key):
    return key.removesuffix(ending(key)).replace("_", " ")


def name_of(key):
    return METRICS.get(key, (key.replace("_", " "),))[0]


def with_its_unit(key, text):
    unit = METRICS.get(key, ("", ""))[1]
    return with_unit(text, unit) if unit else text


def figure(key, value):
    return name_of(key), with_its_unit(key, text_of(value))


def limit_text(limit):
    """A limit that was broken, as the run names it, with the metric's name and unit."""
    key, equals, rest = limit.partition(" = ")
    value, comma, bound = rest.partition(", ")
    return f"{name_of(key)}{equals}{with_its_unit(key, value)}{comma}{bound}"


def text_of(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}".replace("-", "−")
    if isinstance(value, dict):
        counted = [f"{key}: {text_of(item)}" for key, item in value.items() if item != 0]
        return ", ".join(counted) or "none"
    if isinstance(value, list):
        return ", ".join(map(text_of, value)) or "none"
    return str(value)
