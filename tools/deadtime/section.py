"""The section of the report: figure and table."""

from deadtime import table
from deadtime.figure import TITLE, draw
from report import style
from report.assemble import save
from report.page import Picture, figure
from report.svg import svg

KEY = "deadtime"


def caption(measurement):
    worst = max(pair[0].thd_pct for pair in measurement.results)
    angle = max(pair[0].angle_max_deg for pair in measurement.results)
    lost = sum(not pair[1].held for pair in measurement.results)
    return (f"Given back: THD at most {worst:.2g} %, angle error at most {angle:.2g}° el. Not given back: the drive "
            f"sways at low speed and does not hold the rotor at {lost} of {len(measurement.results)} points.")


def picture(measurement, folder):
    name = f"{KEY}.png"
    save(draw(measurement, style.PRINT), style.PRINT, folder / name)
    words = f"{TITLE}. {caption(measurement)}"
    wide, narrow = (svg(draw(measurement, shape), shape, f"{KEY}-{suffix}", words)
                    for shape, suffix in ((style.WIDE, "w"), (style.NARROW, "n")))
    return Picture("Current and angle", caption(measurement), wide, narrow, name)


def entry(measurement, folder):
    """Identifier, title and HTML for page(); writes the PNG into the folder of the report."""
    return KEY, "dead time", f"""<section class="run" id="{KEY}">
<h2>{TITLE}</h2>
{figure(picture(measurement, folder))}
<h3>All points</h3>
{table.html_table(measurement)}
</section>"""
