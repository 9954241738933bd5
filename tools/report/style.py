# SPDX-License-Identifier: MIT
"""Colours, line widths and sizes of all figures."""

from dataclasses import dataclass

# Each colour by its meaning: on light paper, and in the dark mode of the page.
# Actual and estimated stay apart for colour-blind readers and, by width, in grey print.
PALETTE = {
    "paper": ("#fefefe", "#15181d"),
    "ink": ("#21252b", "#dfe3e8"),
    "muted": ("#5c636e", "#9aa3af"),
    "grid": ("#e3e6ea", "#2c323b"),
    "command": ("#3b3f46", "#c3c9d1"),
    "actual": ("#2f7fc1", "#5ea8e6"),
    "estimated": ("#c8480a", "#ff9152"),
    "difference": ("#6b3fa0", "#b795e8"),
    "third": ("#1d8a6b", "#4cc4a0"),
    "claim": ("#dff0e4", "#1d3327"),
    "window": ("#eef1f5", "#20262e"),
    "good": ("#1a6b3c", "#6fd19a"),
    "bad": ("#a8260f", "#ff8a73"),
}
LIGHT = {name: light for name, (light, dark) in PALETTE.items()}
DARK = {name: dark for name, (light, dark) in PALETTE.items()}

# What a line is: colour, width, dashes, order (the last lies on top).
ROLES = {
    "command": ("command", 1.0, (0, (4, 2)), 4),
    "reference": ("muted", 0.9, (0, (1, 1.2)), 3),
    "actual": ("actual", 0.9, "-", 5),
    "estimated": ("estimated", 0.9, "-", 6),
    "difference": ("difference", 0.8, "-", 5),
    "load": ("command", 1.0, (0, (4, 2)), 4),
    "a": ("actual", 0.8, "-", 5),
    "b": ("estimated", 0.8, "-", 5),
    "c": ("third", 0.8, "-", 5),
    "d": ("actual", 0.8, "-", 5),
    "q": ("estimated", 0.8, "-", 5),
}
STEP_LOOK = {"color": LIGHT["muted"], "linewidth": 0.7, "linestyle": (0, (1, 2)), "zorder": 1}
WIDTH_BELOW = 1.9   # of the actual value with the estimated one on top


@dataclass(frozen=True)
class Shape:
    """The format a figure is drawn for; sizes in inches and points."""

    width: float
    panel: float
    font: float
    columns: int    # zoomed windows side by side
    legend_columns: int
    titled: bool


PRINT = Shape(width=7.2, panel=1.25, font=8.5, columns=3, legend_columns=8, titled=True)
WIDE = Shape(width=7.6, panel=1.25, font=8.5, columns=3, legend_columns=8, titled=False)
NARROW = Shape(width=3.9, panel=1.2, font=8.5, columns=1, legend_columns=3, titled=False)


def settings(shape):
    """The matplotlib settings of a shape."""
    return {
        "font.family": "DejaVu Sans", "font.size": shape.font,
        "axes.titlesize": shape.font, "axes.labelsize": shape.font - 0.5,
        "xtick.labelsize": shape.font - 1, "ytick.labelsize": shape.font - 1,
        "legend.fontsize": shape.font - 0.5, "figure.titlesize": shape.font + 2,
        "figure.facecolor": LIGHT["paper"], "axes.facecolor": "none",
        "text.color": LIGHT["ink"], "axes.labelcolor": LIGHT["muted"],
        "axes.titlecolor": LIGHT["ink"],
        "axes.edgecolor": LIGHT["muted"], "xtick.color": LIGHT["muted"],
        "ytick.color": LIGHT["muted"], "grid.color": LIGHT["grid"],
        "axes.linewidth": 0.6, "grid.linewidth": 0.5,
        "xtick.major.width": 0.6, "ytick.major.width": 0.6,
        "xtick.major.size": 2.5, "ytick.major.size": 2.5,
        "axes.spines.top": False, "axes.spines.right": False,
        "axes.grid": True, "axes.axisbelow": True,
        "axes.titlelocation": "left", "axes.titlepad": 3.0,
        "axes.unicode_minus": True, "axes.formatter.useoffset": False,
        "lines.solid_joinstyle": "round",
        "svg.fonttype": "none", "svg.hashsalt": "neurofoc",
    }
