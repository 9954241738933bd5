# SPDX-License-Identifier: MIT
"""The figure: phase current and angle error with and without compensation, spectrum, THD at all points."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from deadtime import harmonics
from report.frame import MARGIN, Frame, Row
from report.style import LIGHT, settings

LOOKS = ({"color": LIGHT["actual"], "zorder": 6}, {"color": LIGHT["estimated"], "zorder": 5})
NAMES = ("given back", "not given back")
KEY = "deadtime"    # of its files, and on a page
TITLE = "Dead time of 2 µs and device drop of 1.2 V on 310 V: given back or not"
SPECTRUM = range(2, harmonics.ORDERS + 1)
BAR = 0.38              # of the distance between two orders
GAP = 1                 # points left free between two sets
ROOM_FOR_SETS = 6       # factor on the logarithmic axis
# Inches.
HEAD, HEAD_TITLED = 0.26, 0.46
PANEL_TITLE, TIME_AXIS, POINT_AXIS, NO_AXIS = 0.22, 0.42, 0.62, 0.06


def draw(measurement, shape):
    with matplotlib.rc_context(settings(shape)):
        return Drawing(measurement, shape).figure()


class Drawing:
    def __init__(self, measurement, shape):
        self.measurement, self.shape = measurement, shape
        rows = [Row(shape.panel, PANEL_TITLE, below) for below in self.room_below()]
        head = MARGIN + (HEAD_TITLED if shape.titled else HEAD)
        self.frame = Frame(shape.width, head, rows, percent=False)

    def room_below(self):
        return [NO_AXIS, TIME_AXIS] * len(self.measurement.waves) + [TIME_AXIS, POINT_AXIS]

    def figure(self):
        fig = Figure(figsize=(self.shape.width, self.frame.height))
        axes = [fig.add_axes(box) for box in self.frame.boxes()]
        panels = iter(axes)
        for waves in self.measurement.waves:
            self.draw_waves(next(panels), next(panels), waves)
        self.draw_spectrum(next(panels), self.measurement.waves[-1])
        self.draw_points(next(panels))
        for letter, ax in zip("abcdefgh", axes):
            ax.set_title(f"({letter}) {ax.get_title(loc='left')}")
            ax.yaxis.set_label_coords(self.frame.label_place(), 0.5)
        fig.legend(handles=[Line2D([], [], label=name, **look) for name, look in zip(NAMES, LOOKS)],
                   ncols=2, title=TITLE if self.shape.titled else None, alignment="left",
                   title_fontproperties={"size": self.shape.font + 2}, loc="upper left",
                   bbox_to_anchor=(0.0, 1.0), borderaxespad=0.4, borderpad=0.2, frameon=False,
                   handlelength=1.8, columnspacing=1.3)
        return fig

    def draw_waves(self, currents, errors, waves):
        place = words(waves[0].point)
        for wave, look in zip(waves, LOOKS):
            time = 1e3 * (np.array(wave.time_s) - wave.time_s[0])
            currents.plot(time, wave.current_a, linewidth=0.9, **look)
            errors.plot(time, wave.angle_error_deg, linewidth=0.9, **look)
            for ax in (currents, errors):
                ax.set_xlim(0, min(time[-1], ax.get_xlim()[1]) if ax.lines[1:] else time[-1])
        currents.set_title(f"phase current, {place}")
        currents.set_ylabel("A", va="bottom")
        currents.tick_params(labelbottom=False)
        errors.set_title("actual − estimated angle")
        errors.set_ylabel("° el.", va="bottom")
        errors.set_xlabel("time, ms")

    def draw_spectrum(self, ax, waves):
        for wave, look, side in zip(waves, LOOKS, (-0.5, 0.5)):
            shares = np.array(wave.shares_pct)[list(SPECTRUM)]
            ax.bar(np.array(SPECTRUM) + side * BAR, shares, BAR, linewidth=0, **look)
        ax.set_title(f"harmonics of the phase current, {words(waves[0].point)}")
        ax.set_ylabel("% of order 1", va="bottom")
        ax.set_xlabel("order")
        ax.set_xticks([order for order in SPECTRUM if order % 6 in (1, 5)])
        ax.grid(axis="x", visible=False)

    def draw_points(self, ax):
        places, labels, sets = [], [], self.measurement.sets()
        for number, pair in enumerate(self.measurement.results):
            point = pair[0].point
            place = number + GAP * sets.index(point.imperfections)
            places.append(place)
            labels.append(f"{point.speed_rpm}, {point.load_nm}")
            for result, look in zip(pair, LOOKS):
                ax.plot(place, result.thd_pct, "o", markersize=4, **look,
                        markerfacecolor=look["color"] if result.held else "none")
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_locator(NullLocator())
        ax.set_title("THD of the phase current; hollow: rotor not held")
        ax.set_ylabel("%", va="bottom")
        ax.set_xticks(places, labels, rotation=90)
        ax.set_xlabel("rpm, N·m")
        ax.grid(axis="x", visible=False)
        self.name_sets(ax, places, sets)

    @staticmethod
    def name_sets(ax, places, sets):
        """Above the points of each set."""
        low, high = ax.get_ylim()
        ax.set_ylim(low, high * ROOM_FOR_SETS)
        count = len(places) // len(sets)
        for number, name in enumerate(sets):
            ax.text(np.mean(places[number * count:(number + 1) * count]), 0.97, name, ha="center",
                    va="top", transform=ax.get_xaxis_transform(), color=LIGHT["muted"])


def words(point):
    return f"{point.speed_rpm} rpm, {point.load_nm} N·m"
