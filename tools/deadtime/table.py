# SPDX-License-Identifier: MIT
"""The measurement as a table: text for the terminal, HTML for the report."""

import html

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
HOW = ("Each cell: given back, not given back. Motor A on the switched plant, constant speed and load, "
       "1.2 s after all has settled, robust tuning; phase current and angle are those of the motor. "
       "THD: orders 2 to 25 of phase a over whole electrical turns; distortion: all but mean and "
       "fundamental. Not held: the speed error exceeds 5 % of rated speed, rms over 0.1 s.")


def cells(pair):
    """The texts of a row: (with, without) in each of COLUMNS."""
    return [tuple(text(result) for result in pair) for _, _, text in COLUMNS]


def head(name, unit):
    return f"{name}, {unit}" if unit else name


def where(pair):
    point = pair[0].point
    return f"{point.imperfections}, {point.speed_rpm}{FIXED_SPACE}rpm, {point.load_nm}{FIXED_SPACE}N·m"


def text(measurement):
    heads = ["point", *(head(name, unit) for name, unit, _ in COLUMNS)]
    rows = [[where(pair), *(", ".join(both) for both in cells(pair))]
            for pair in measurement.results]
    widths = [max(map(len, column)) for column in zip(heads, *rows)]
    return "\n".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |"
                     for row in (heads, ["-" * width for width in widths], *rows))


def html_table(measurement):
    heads = "".join(f"<th scope=col>{html.escape(head(name, unit))}</th>"
                    for name, unit, _ in COLUMNS)
    rows = "\n".join(html_row(pair) for pair in measurement.results)
    return f"""<table class="cards">
<caption>{html.escape(HOW)}</caption>
<thead><tr><th scope=col>Point</th>{heads}</tr></thead>
<tbody>
{rows}
</tbody>
</table>"""


def html_row(pair):
    shown = "".join(
        f'<td data-label="{html.escape(head(name, unit))}">{html.escape(", ".join(both))}</td>'
        for (name, unit, _), both in zip(COLUMNS, cells(pair)))
    return f"<tr><th scope=row>{html.escape(where(pair))}</th>{shown}</tr>"
