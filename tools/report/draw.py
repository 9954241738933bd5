# SPDX-License-Identifier: MIT
"""Draw a layout of panels from a trace as a matplotlib figure."""

import math

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from report import signals
from report.frame import MARGIN, Frame, Row
from report.runs import TIME
from report.style import LIGHT, ROLES, STEP_LOOK, WIDTH_BELOW, settings

BUCKETS_PER_INCH = 150
CLAIM_SHARE = 0.02      # paper A: errors within 2 %
TICK_STEPS = [1, 2, 3, 4, 5, 6, 10]
# Inches.
TITLE = 0.2
LEGEND_LINE = 0.18
EVENTS = 0.2
PANEL_TITLE = 0.22
TIME_AXIS = 0.42
NO_AXIS = 0.06
STATE = 0.22


def draw(trace, layout, shape, bases=None):
    """The figure of `layout`; `bases` gives what 100 % of an error is, by Panel.base."""
    with matplotlib.rc_context(settings(shape)):
        return Drawing(trace, layout, shape, bases or {}).figure()


class Drawing:
    def __init__(self, trace, layout, shape, bases):
        self.trace, self.layout, self.shape, self.bases = trace, layout, shape, bases
        self.timed = [panel for panel in layout.panels if panel.kind != "zoom"]
        self.claimed = any(panel.base in bases for panel in layout.panels)
        self.events = signals.events(trace)
        zoomed = len(self.timed) < len(layout.panels)
        self.windows = signals.zoom_windows(trace, self.events) if zoomed else []
        self.columns = min(len(self.windows), shape.columns) or 1
        self.handles = self.legend_handles()
        self.frame = Frame(shape.width, self.head(), self.rows(), self.claimed)

    def head(self):
        lines = math.ceil(len(self.handles) / self.shape.legend_columns)
        return MARGIN + TITLE * self.shape.titled + LEGEND_LINE * lines

    def rows(self):
        rows = [Row(EVENTS if self.events else NO_AXIS, 0.0, 0.0)]
        for panel in self.layout.panels:
            if panel.kind == "zoom":
                rows += self.zoom_rows()
            else:
                height = STATE if panel.kind == "state" else self.shape.panel
                below = TIME_AXIS if panel is self.timed[-1] else NO_AXIS
                rows.append(Row(height, PANEL_TITLE, below))
        return rows

    def zoom_rows(self):
        count = math.ceil(len(self.windows) / self.columns)
        return [Row(self.shape.panel, PANEL_TITLE if number == 0 else NO_AXIS, TIME_AXIS,
                    self.columns) for number in range(count)]

    def figure(self):
        fig = Figure(figsize=(self.shape.width, self.frame.height))
        boxes = self.frame.boxes()
        strip = fig.add_axes(next(boxes))
        axes = {}
        for panel in self.layout.panels:
            if panel.kind == "zoom":
                self.draw_zoom(fig, boxes, panel)
            else:
                axes[panel] = fig.add_axes(next(boxes), sharex=strip)
                self.draw_panel(axes[panel], panel)
        strip.set_xlim(self.trace[TIME][0], signals.end(self.trace[TIME]))
        self.share_ranges(axes)
        self.mark_events(strip, axes.values())
        self.add_legend(fig)
        return fig

    def draw_panel(self, ax, panel):
        ax.set_title(panel.title)
        ax.tick_params(labelbottom=panel is self.timed[-1])
        if panel is self.timed[-1]:
            ax.set_xlabel("time, s")
        for window in self.windows:
            ax.axvspan(window.start, window.end, color=LIGHT["window"], linewidth=0, zorder=0)
        if panel.kind == "state":
            self.draw_states(ax)
            return
        self.name_axis(ax, panel)
        if panel.kind == "angle":
            self.draw_angles(ax, panel, self.trace)
        else:
            self.draw_lines(ax, panel)

    def name_axis(self, ax, panel, columns=1):
        ax.set_ylabel(panel.unit, va="bottom")
        ax.yaxis.set_label_coords(self.frame.label_place(columns), 0.5)

    def draw_lines(self, ax, panel):
        series = [line.values(self.trace) for line in panel.lines]
        for line, values in zip(panel.lines, series):
            self.plot(ax, panel, line, self.trace[TIME], values)
        low = min(np.nanmin(values) for values in series)
        high = max(np.nanmax(values) for values in series)
        base = self.bases.get(panel.base)
        if base:
            high = max(-low, high, CLAIM_SHARE * base)
            low = -high
            self.show_claim(ax, base)
        air = 0.08 * (high - low) or max(0.5, 0.05 * abs(high))
        ax.set_ylim(low - air, high + air)
        ax.yaxis.set_major_locator(ticks())

    def show_claim(self, ax, base):
        """A second axis in per cent, and the paper's claim as a band."""
        ax.axhspan(-CLAIM_SHARE * base, CLAIM_SHARE * base, color=LIGHT["claim"], linewidth=0,
                   zorder=0)
        percent = ax.secondary_yaxis(
            "right", functions=(lambda value: 100 * value / base, lambda share: share * base / 100))
        percent.set_ylabel("%", labelpad=1)
        percent.yaxis.set_major_locator(ticks())

    def plot(self, ax, panel, line, time, values):
        buckets = int(self.shape.width * BUCKETS_PER_INCH)
        ax.plot(*signals.envelope(time, values, buckets), **look(line.role, panel.lines))

    def draw_angles(self, ax, panel, trace):
        for line in panel.lines:
            for time, degrees in signals.pieces(trace[TIME], line.values(trace)):
                self.plot(ax, panel, line, time, degrees)
        ax.set_ylim(-190, 190)
        ax.set_yticks([-180, -90, 0, 90, 180])

    def draw_zoom(self, fig, boxes, panel):
        for number, window in enumerate(self.windows):
            ax = fig.add_axes(next(boxes))
            self.draw_angles(ax, panel, self.trace.cut(window.start, window.end))
            self.mark_lines(ax, window.start, window.end)
            ax.set_xlim(window.start, window.end)
            ax.set_facecolor(LIGHT["window"])
            ax.grid(color=LIGHT["paper"])
            ax.xaxis.set_major_locator(ticks(4))
            ax.set_title(panel.title if number == 0 else "")
            ax.set_xlabel(f"time, s ({window.text})")
            if number % self.columns == 0:
                self.name_axis(ax, panel, self.columns)
            else:
                ax.tick_params(labelleft=False)
        for _ in range(-len(self.windows) % self.columns):
            next(boxes)

    def draw_states(self, ax):
        time, state = self.trace[TIME], self.trace["state"]
        starts = np.concatenate([[0], np.flatnonzero(state[1:] != state[:-1]) + 1])
        ends = np.append(time[starts[1:]], signals.end(time))
        shades = (LIGHT["grid"], LIGHT["window"])
        for number, (start, end) in enumerate(zip(starts, ends)):
            ax.axvspan(time[start], end, color=shades[number % 2], linewidth=0)
            if end - time[start] > 0.016 * len(state[start]) * (time[-1] - time[0]):
                ax.text((time[start] + end) / 2, 0.5, state[start], ha="center", va="center",
                        fontsize=self.shape.font - 2)
        ax.set_ylim(0, 1)
        ax.set_yticks([])
        ax.grid(False)

    def share_ranges(self, axes):
        shared = [axes[self.layout.panels[index]] for index in self.layout.same_range]
        for ax in shared:
            ax.set_ylim(min(one.get_ylim()[0] for one in shared),
                        max(one.get_ylim()[1] for one in shared))

    def mark_events(self, strip, axes):
        strip.axis("off")
        strip.set_ylim(0, 1)
        start, end = strip.get_xlim()
        for event in self.events if axes else ():
            place = (event.time - start) / (end - start)
            side = "left" if place < 0.06 else "right" if place > 0.94 else "center"
            strip.text(event.time, 0.4, event.text, ha=side, va="center",
                       fontsize=self.shape.font - 1, color=LIGHT["muted"])
        for ax in axes:
            self.mark_lines(ax, start, end)

    def mark_lines(self, ax, start, end):
        for event in self.events:
            if start < event.time < end:
                ax.axvline(event.time, **STEP_LOOK)

    def add_legend(self, fig):
        title = self.layout.title if self.shape.titled else None
        fig.legend(handles=self.handles, ncols=self.shape.legend_columns, title=title,
                   title_fontproperties={"size": self.shape.font + 2}, alignment="left",
                   loc="upper left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.4, borderpad=0.2,
                   frameon=False, handlelength=1.8, columnspacing=1.3)

    def legend_handles(self):
        lines = [line for panel in self.layout.panels if panel.kind != "state"
                 for line in panel.lines]
        handles = [Line2D([], [], label=role, **look(role, lines))
                   for role in dict.fromkeys(line.role for line in lines)]
        if self.events:
            handles.append(Line2D([], [], label="step", **STEP_LOOK))
        if self.claimed:
            handles.append(Patch(color=LIGHT["claim"], label="±2 %"))
        if self.windows and self.timed:
            handles.append(Patch(color=LIGHT["window"], label="zoomed"))
        return handles


def ticks(most=5):
    return MaxNLocator(most, steps=TICK_STEPS)


def look(role, lines):
    """How a line is drawn; the actual value is wide where the estimate lies on top of it."""
    color, width, dashes, order = ROLES[role]
    if role == "actual" and any(line.role == "estimated" for line in lines):
        width = WIDTH_BELOW
    return {"color": LIGHT[color], "linewidth": width, "linestyle": dashes, "zorder": order}
