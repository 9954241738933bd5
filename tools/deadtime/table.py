# SPDX-License-Identifier: MIT
"""The measurement as a table: its heads and rows, and as text for the terminal."""

MOST = 100      # %; beyond it the current is no sine with harmonics
FIXED_SPACE = "\N{NO-BREAK SPACE}"


def percent(value):
    return f">{FIXED_SPACE}{MOST}" if value > MOST else f"{value:.1f}"


def signed(value):
    """No sign before a zero."""
    return f"{round(value, 1) + 0.0:.1f}".replace("-", "−")


COLUMNS = (     # name, unit, text of a Result
    ("THD", "%", lambda result: percent(result.thd_pct)),
    ("distortion", "%", lambda result: percent(result.distortion_pct)),
    ("q current, ripple", "A rms", lambda result: f"{result.iq_ripple_a:.2f}"),
    ("speed, ripple", "rpm rms", lambda result: f"{result.speed_ripple_rpm:.1f}"),
    ("angle, mean", "° el.", lambda result: signed(result.angle_mean_deg)),
    ("angle, largest", "° el.", lambda result: f"{result.angle_max_deg:.1f}"),
    ("rotor", "", lambda result: "held" if result.held else "not held"),
)


def cells(pair):
    """The texts of a row: (with, without) in each of COLUMNS."""
    return [tuple(text(result) for result in pair) for _, _, text in COLUMNS]


def heads(first):
    """The names of all columns, of which `first` is the point."""
    return [first, *(f"{name}, {unit}" if unit else name for name, unit, _ in COLUMNS)]


def where(pair):
    point = pair[0].point
    return f"{point.imperfections}, {point.speed_rpm}{FIXED_SPACE}rpm, {point.load_nm}{FIXED_SPACE}N·m"


def rows(measurement):
    """The texts of all rows, as heads() names them."""
    return [[where(pair), *(", ".join(both) for both in cells(pair))] for pair in measurement.results]


def text(measurement):
    lines = [heads("point"), *rows(measurement)]
    widths = [max(map(len, column)) for column in zip(*lines)]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths)) + " |" for line in lines)
