# SPDX-License-Identifier: MIT
"""Words for a figure: the caption under it and the text in its place."""

import numpy as np

from report import signals
from report.panels import with_unit
from report.runs import TIME


def peak(trace, panel, base):
    """The largest value of an error panel, with its sign and its time."""
    values = panel.lines[0].values(trace)
    place = int(np.nanargmax(np.abs(values)))
    share = f" ({100 * abs(values[place]) / base:.2g} %)" if base else ""
    value = with_unit(f"{values[place]:.3g}", panel.unit)
    return f"{panel.title}: {value}{share} at {trace[TIME][place]:.3f} s"


def caption(trace, layout, bases):
    """The largest values of a figure of errors; of others, what its panels are."""
    errors = [panel for panel in layout.panels if panel.lines[0].role == "difference"]
    if not errors:
        return "The steps are marked by dotted lines."
    return "Largest values: " + "; ".join(
        peak(trace, panel, bases.get(panel.base)) for panel in errors) + "."


def alternative(trace, layout, bases):
    """What a reader who does not see the figure needs: panels, steps and largest values."""
    titles = "; ".join(panel.title for panel in layout.panels)
    text = f"{layout.title}. {len(layout.panels)} panels over time: {titles}."
    marked = [f"{event.text} at {event.time:.3g} s" for event in signals.events(trace)]
    if marked:
        text += f" Steps: {', '.join(marked)}."
    errors = caption(trace, layout, bases)
    return f"{text} {errors}" if errors.startswith("Largest") else text
