# SPDX-License-Identifier: MIT
"""The map of a campaign: which runs hold and where the others gather, for each pair of parameters.

On the diagonal, how the runs of each slice of a parameter's range ended. Below it, each run as a
point. Above it, the share of runs that do not hold in each cell of the plane.
"""

import itertools
import math

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from report.style import LIGHT, PRINT, settings

from . import distributions, summary
from .campaign import CampaignError
from .distributions import Choice
from .simulator import FAILED_SAFE, LOCKED, OFF_LIMITS, OUTCOMES, REFUSED, UNCONTROLLED

FILE = "map.png"
DPI = 170
SLICES_MAX = 12       # of the diagonal
SLICE_RUNS = 8        # on average, at least
CELL_RUNS = 16        # on average, that a share is shown of
CELLS_MAX = 10        # a side
DARKEST, SHADE_MIN = 4.0, 0.1   # times the share of all runs, and no less than this share
FOOT = ("How the runs of each slice of the range ended.",
        "Diagonal: how the runs of each slice ended.  Below: each run.  Above: share of the runs in "
        "a cell.  The parameter that matters most comes first.")
PANEL, GAP, SIDE_MIN, SCALE_WIDTH = 1.3, 0.12, 7.6, 1.7  # inches, as the next line
LEFT, BOTTOM, RIGHT, TOP = 0.75, 0.78, 0.75, 0.82
COLOURS = {LOCKED: LIGHT["actual"], REFUSED: LIGHT["muted"], OFF_LIMITS: LIGHT["difference"],
           FAILED_SAFE: LIGHT["third"], UNCONTROLLED: LIGHT["estimated"]}
MARKERS = {LOCKED: ".", REFUSED: "d", OFF_LIMITS: "^", FAILED_SAFE: "s", UNCONTROLLED: "x"}
SCALE = {LOCKED: 1.6, REFUSED: 0.9, OFF_LIMITS: 1.0, FAILED_SAFE: 0.9, UNCONTROLLED: 1.1}  # of about the same area
PALE = 0.35             # the locked part of a slice: it is the ground
POINTS_AREA = 9000      # of all markers of a panel
CHOICE_LETTERS = 10
EDGE = 0.08             # of an axis: nearer to its end a number would reach over it
ROUNDING = 1e-9         # of an end that is a round value itself
LOG_STEPS = (1, 2, 3, 5)
LOG_FROM = 2.5         # ends of a range this far apart hold two of these steps
SLOT = 0.7              # of its width that the points of a choice spread over
SHADES = LinearSegmentedColormap.from_list("not within the limits", (LIGHT["paper"], "#f6c9ae",
                                                          LIGHT["estimated"], "#6a2403"))
SHADES = SHADES.with_extremes(bad=LIGHT["grid"])    # a cell without runs
UNITS = {"deg": "°", "lsb": "LSB", "pct": "%", "rpm": "rpm", "nm": "N·m", "s": "s", "v": "V",
         "a": "A", "hz": "Hz", "ohm": "Ω", "h": "H", "wb": "Wb"}
HALF_TURN_DEG = 180


def label(key):
    """`scenario.initial_angle_el_deg` as `initial angle el, °`."""
    words = key.rpartition(".")[2].split("_")
    unit = UNITS.get(words[-1]) if len(words) > 1 else None
    return " ".join(words[:-1]) + f", {unit}" if unit else " ".join(words)


def ticks(key, distribution):
    """Round values within a range, or the names of a choice: places and texts."""
    if isinstance(distribution, Choice):
        values = [text[:CHOICE_LETTERS] for text in distribution.options]
        return [distribution.place(option) for option in distribution.options], values
    low, high = distribution.low, distribution.high
    if distribution.log and high / low > LOG_FROM:
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        values = [step * 10.0**decade for decade in decades for step in LOG_STEPS]
    elif key.endswith("_deg") and high - low >= HALF_TURN_DEG:
        values = MultipleLocator(HALF_TURN_DEG).tick_values(low, high)
    else:
        values = MaxNLocator(3, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    places = [(distribution.place(value), value) for value in values if value > 0 or not
              distribution.log]
    inside = [(place, value) for place, value in places if -ROUNDING < place < 1 + ROUNDING]
    return [place for place, _ in inside], [f"{value:g}".replace("-", "−") for _, value in inside]


def keep_inside(axis, sides, align):
    """Numbers at the ends of an axis stay off those of the next panel."""
    for tick in axis.get_major_ticks():
        place = tick.get_loc() / axis.get_view_interval()[1]
        side = sides[0] if place < EDGE else sides[2] if place > 1 - EDGE else sides[1]
        for text in (tick.label1, tick.label2):
            getattr(text, align)(side)


def draw_slices(ax, places, outcomes, edges):
    """How the runs of each slice of an axis ended, on top of each other."""
    total = np.histogram(places, edges)[0]
    base = np.zeros(len(total))
    for outcome in reversed(OUTCOMES):
        found = np.histogram(places[outcomes == outcome], edges)[0]
        top = base + np.divide(found, total, out=np.zeros(len(total)), where=total > 0)
        ax.stairs(top, edges, baseline=base, fill=True, color=COLOURS[outcome],
                  alpha=PALE if outcome == LOCKED else 1.0, linewidth=0)
        base = top
    ax.grid(False)


def legend_handles(rows):
    return [Line2D([], [], linestyle="none", marker=MARKERS[count.outcome],
                   color=COLOURS[count.outcome], markersize=6,
                   label=f"{count.outcome}: {count.runs} ({count.percent:.1f} %)")
            for count in summary.counts(rows)]


class Map:
    def __init__(self, campaign, rows):
        self.campaign, self.rows = campaign, rows
        self.axes = campaign.axes(rows)
        self.keys = list(summary.ranking(self.axes, rows))
        self.panel = max(PANEL, SIDE_MIN / len(self.keys))
        self.outcomes = np.array([row["outcome"] for row in rows])
        self.places = {key: self.places_of(key) for key in self.keys}
        failed = np.mean(self.outcomes != LOCKED)
        self.darkest = float(np.clip(DARKEST * failed, SHADE_MIN, 1.0))
        self.slices = int(np.clip(len(rows) / SLICE_RUNS, 2, SLICES_MAX))
        self.cells = int(np.clip(np.sqrt(len(rows) / CELL_RUNS), 2, CELLS_MAX))

    def places_of(self, key):
        """Where the runs lie on the axis; those of one choice spread over its slot."""
        distribution = self.axes[key].distribution
        places = np.array([self.axes[key].place(row) for row in self.rows])
        if isinstance(distribution, Choice):
            spread = [distributions.share(self.campaign.seed, row["run"], f"{key} within its slot")
                      for row in self.rows]
            places += (np.array(spread) - 0.5) * SLOT / len(distribution.options)
        return places

    def figure(self):
        count = len(self.keys)
        side = count * self.panel + (count - 1) * GAP
        width, height = LEFT + side + RIGHT, BOTTOM + side + TOP
        fig = Figure(figsize=(width, height))
        for row, column in itertools.product(range(count), repeat=2):
            left = LEFT + column * (self.panel + GAP)
            bottom = BOTTOM + (count - 1 - row) * (self.panel + GAP)
            ax = fig.add_axes((left / width, bottom / height, self.panel / width,
                               self.panel / height))
            self.draw_panel(ax, row, column)
        self.add_head(fig, width, height)
        return fig

    def draw_panel(self, ax, row, column):
        key_x, key_y = self.keys[column], self.keys[row]
        ax.set(xlim=(0, 1), ylim=(0, 1))
        if row == column:
            draw_slices(ax, self.places[key_x], self.outcomes, self.edges(key_x, self.slices))
        elif row > column:
            self.draw_points(ax, key_x, key_y)
        else:
            self.draw_shares(ax, key_x, key_y)
        self.name_x(ax, row, column)
        self.name_y(ax, row, column)

    def edges(self, key, count):
        """Of `count` equal parts of an axis; of a choice, one part for each option."""
        distribution = self.axes[key].distribution
        if isinstance(distribution, Choice):
            count = len(distribution.options)
        return np.linspace(0, 1, count + 1)

    def draw_points(self, ax, key_x, key_y):
        """The rarer an outcome, the later it is drawn and the more it shows."""
        found = {outcome: self.outcomes == outcome for outcome in OUTCOMES}
        size = float(np.clip(POINTS_AREA / len(self.rows), 0.6, 9.0))
        for outcome in sorted(OUTCOMES, key=lambda outcome: -np.count_nonzero(found[outcome])):
            ax.plot(self.places[key_x][found[outcome]], self.places[key_y][found[outcome]],
                    linestyle="none", color=COLOURS[outcome], markeredgewidth=0.6,
                    marker=MARKERS[outcome], markersize=math.sqrt(size) * SCALE[outcome],
                    alpha=0.55 if outcome == LOCKED else 0.9)

    def draw_shares(self, ax, key_x, key_y):
        edges = self.edges(key_x, self.cells), self.edges(key_y, self.cells)
        x, y, failed = self.places[key_x], self.places[key_y], self.outcomes != LOCKED
        total = np.histogram2d(x, y, edges)[0].T
        hits = np.histogram2d(x[failed], y[failed], edges)[0].T
        share = np.divide(hits, total, out=np.full(total.shape, np.nan), where=total > 0)
        ax.pcolormesh(*edges, share, cmap=SHADES, vmin=0, vmax=self.darkest,
                      linewidth=0)
        ax.grid(False)

    def name_x(self, ax, row, column):
        key = self.keys[column]
        ax.set_xticks(*ticks(key, self.axes[key].distribution))
        last = row == len(self.keys) - 1
        ax.tick_params(labelbottom=last, bottom=last)
        if last:
            ax.set_xlabel(label(key))
            keep_inside(ax.xaxis, ("left", "center", "right"), "set_ha")

    def name_y(self, ax, row, column):
        """Names of the points' rows on the left, of the shares' rows on the right."""
        key, last = self.keys[row], len(self.keys) - 1
        if row == column:
            ax.set_yticks((0, 0.5, 1), ("0", "50", "100"))
            ax.tick_params(labelleft=row == 0, left=row == 0)
            if row == 0:
                ax.set_ylabel("% of runs", labelpad=2)
            return
        ax.set_yticks(*ticks(key, self.axes[key].distribution))
        right = row < column
        if right:
            ax.yaxis.tick_right()
            ax.yaxis.set_label_position("right")
            ax.spines[["left", "right"]].set_visible((False, True))
        outer = column == (last if right else 0)
        ax.tick_params(labelleft=outer and not right, left=outer and not right,
                       labelright=outer and right, right=outer and right)
        if outer:
            ax.set_ylabel(label(key), rotation=270 if right else 90,
                          va="bottom" if right else "baseline", labelpad=3)
            keep_inside(ax.yaxis, ("bottom", "center", "top"), "set_va")

    def add_head(self, fig, width, height):
        fig.text(LEFT / width, 1 - 0.12 / height, f"{self.campaign.name}: {self.campaign.title}",
                 va="top", fontsize=PRINT.font + 2)
        fig.text(LEFT / width, 0.08 / height, FOOT[len(self.keys) > 1], color=LIGHT["muted"],
                 fontsize=PRINT.font - 1)
        handles = legend_handles(self.rows)
        fig.legend(handles=handles, loc="upper left", ncols=len(handles), frameon=False,
                   bbox_to_anchor=(LEFT / width, 1 - 0.32 / height), borderaxespad=0,
                   handletextpad=0.2, columnspacing=1.4, borderpad=0)
        if len(self.keys) > 1:
            self.add_scale(fig, width, height)

    def add_scale(self, fig, width, height):
        left = width - RIGHT - SCALE_WIDTH
        ax = fig.add_axes((left / width, 1 - 0.5 / height, SCALE_WIDTH / width, 0.09 / height))
        most = 100 * self.darkest
        ax.pcolormesh(np.linspace(0, most, 65), (0, 1), np.linspace(0, 1, 64)[None, :], cmap=SHADES)
        ax.set_title("not within the limits, %", fontsize=PRINT.font - 1)
        ax.set(yticks=())
        ax.set_xticks((0, most), ("0", f"{most:.3g}{'' if self.darkest == 1.0 else ' or more'}"))
        keep_inside(ax.xaxis, ("left", "center", "right"), "set_ha")
        ax.grid(False)


def write(folder, campaign, rows):
    """The path of the picture, or None where nothing but the seed varies."""
    if not summary.ranking(campaign.axes(rows), rows):
        return None
    return save(folder, lambda: Map(campaign, rows).figure())


def save(folder, draw):
    """The path of the picture that `draw` makes."""
    path = folder / FILE
    with matplotlib.rc_context(settings(PRINT)):
        try:
            draw().savefig(path, dpi=DPI, metadata={"Software": None})
        except OSError as error:
            raise CampaignError(f"{path}: {error.strerror}; "
                                "expected a place to write to") from error
    return path
