# SPDX-License-Identifier: MIT
"""The section of the report: figure and table."""

from deadtime import table
from deadtime.figure import KEY, TITLE, draw
from report.picture import picture
from report.render import render


def caption(measurement):
    worst = max(pair[0].thd_pct for pair in measurement.results)
    angle = max(pair[0].angle_max_deg for pair in measurement.results)
    lost = sum(not pair[1].held for pair in measurement.results)
    return (f"Given back: THD at most {worst:.2g} %, angle error at most {angle:.2g}° el. Not given back: the drive "
            f"sways at low speed and does not hold the rotor at {lost} of {len(measurement.results)} points.")


def entry(measurement, folder):
    """Identifier, title and HTML for page(); writes the PNG into the folder of the report."""
    words = caption(measurement), f"{TITLE}. {caption(measurement)}"
    drawn = picture(KEY, "Current and angle", words, lambda shape: draw(measurement, shape), folder)
    return KEY, "dead time", render("deadtime/section.jinja", key=KEY, title=TITLE, picture=drawn,
                                    columns=table.heads("Point"), rows=table.rows(measurement))
