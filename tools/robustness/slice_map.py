# SPDX-License-Identifier: MIT
"""The picture of a campaign over the zoo: how the motors ended, by class and by each dimensionless number.

Each slice of a number's range holds as many motors as any other.
"""

import math

import numpy as np
from matplotlib.figure import Figure

from report.style import PRINT

from . import fail_map, zoo, zoo_summary
from .axes import Ranked

COLUMNS = 4
PANEL_WIDTH, PANEL_HEIGHT, GAP, HEAD, FOOT = 2.0, 1.25, 0.5, 0.75, 0.3  # inches
SLICES_MAX, SLICE_RUNS = 20, 12
TICKS = (0.0, 0.25, 0.5, 0.75, 1.0)


def figure(campaign, rows):
    rows = [row for row in rows if zoo.has_numbers(row)]
    axes = campaign.axes(rows)
    names = [name for name in axes if name == "class"] + [line.name for line in zoo_summary.gatherings(campaign, rows)]
    lines = math.ceil(len(names) / COLUMNS)
    width = COLUMNS * (PANEL_WIDTH + GAP) + GAP
    height = HEAD + lines * (PANEL_HEIGHT + GAP) + FOOT
    fig = Figure(figsize=(width, height))
    for number, name in enumerate(names):
        left = GAP + number % COLUMNS * (PANEL_WIDTH + GAP)
        top = height - HEAD - number // COLUMNS * (PANEL_HEIGHT + GAP)
        ax = fig.add_axes((left / width, (top - PANEL_HEIGHT) / height, PANEL_WIDTH / width, PANEL_HEIGHT / height))
        draw_panel(ax, name, axes[name], rows)
    add_head(fig, campaign, rows, width, height)
    return fig


def draw_panel(ax, name, axis, rows):
    places = np.array([axis.place(row) for row in rows])
    outcomes = np.array([row["outcome"] for row in rows])
    ranked = isinstance(axis.distribution, Ranked)
    slices = int(np.clip(len(rows) / SLICE_RUNS, 2, SLICES_MAX)) if ranked else len(axis.distribution.options)
    fail_map.draw_slices(ax, places, outcomes, np.linspace(0, 1, slices + 1))
    ax.set(xlim=(0, 1), ylim=(0, 1), title=name.replace("_", " "))
    ax.set_yticks((0, 0.5, 1), ("0", "50", "100"))
    if ranked:
        ax.set_xticks(TICKS, [f"{axis.distribution.at(tick):.2g}" for tick in TICKS])
    else:
        ax.set_xticks([axis.distribution.place(option) for option in axis.distribution.options],
                      [option[:6] for option in axis.distribution.options])


def add_head(fig, campaign, rows, width, height):
    fig.text(GAP / width, 1 - 0.1 / height, f"{campaign.name}: {campaign.title}", va="top", fontsize=PRINT.font + 2)
    fig.text(GAP / width, 0.08 / height, "% of the motors, by how they ended. What matters most comes first.",
             fontsize=PRINT.font - 1)
    handles = fail_map.legend_handles(rows)
    fig.legend(handles=handles, loc="upper left", ncols=len(handles), frameon=False, borderaxespad=0, borderpad=0,
               bbox_to_anchor=(GAP / width, 1 - 0.3 / height), handletextpad=0.2, columnspacing=1.4)


def write(folder, campaign, rows):
    """The path of the picture, or None where every motor was refused."""
    if not any(map(zoo.has_numbers, rows)):
        return None
    return fail_map.save(folder, lambda: figure(campaign, rows))
