# SPDX-License-Identifier: MIT
"""The figures 3 to 6 of paper B from the JSON of `gaindesign design`: stable gains, and the linear drive's responses."""

import json
from dataclasses import dataclass

import matplotlib
from matplotlib.figure import Figure

from report import style
from report.picture import make_folder, save
from report.runs import PlotError, read_text
from report.style import LIGHT

HEIGHT = 2.9    # inches
ROOM_FOR_LEGEND = 0.52  # of the y range, for one column of it
# What the matrices are drawn with.
LOOKS = {
    "computed": {"color": LIGHT["actual"], "linewidth": 1.1, "zorder": 4},
    "printed": {"color": LIGHT["estimated"], "linewidth": 0.9, "linestyle": (0, (5, 1.5)),
                "zorder": 5},
}
NAMES = {"computed": "computed from the parameters", "printed": "as the paper prints them"}
STEPS = {"load": "a load step of 1 N·m", "speed": "a speed step of 1 rad/s"}
LABELS = {"speed_rad_s": "speed, rad/s", "i_d_a": "d current, A"}
@dataclass(frozen=True)
class Response:
    """A figure of the paper: what steps, with which gains, and what is drawn of it."""

    key: str
    scenario: str
    step: str
    pair: str
    signal: str

    def title(self, design):
        gains = pair_of(design["models"][0], self.pair)
        name = LABELS[self.signal].split(",")[0]
        return (f"{self.scenario}: {name} after {STEPS[self.step]}, K_p = {gains['kp']:g}, K_i = {gains['ki_per_s']:g} /s "
                f"(paper B, fig. {self.key[3:]})")


RESPONSES = (
    Response("fig4a", "S6", "load", "arbitrary", "speed_rad_s"),
    Response("fig4b", "S6", "load", "published", "speed_rad_s"),
    Response("fig5a", "S7", "speed", "arbitrary", "speed_rad_s"),
    Response("fig5b", "S7", "speed", "published", "speed_rad_s"),
    Response("fig6", "S8", "load", "published", "i_d_a"),
)
REGION = "fig3"
REGION_TITLE = "Stable gains (paper B, fig. 3)"


def read_design(path):
    text = read_text(path, "the output of `gaindesign design --json`")
    try:
        design = json.loads(text)
        design["models"][0]["stable_region"]["kp"]
        design["comparison"]
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise PlotError(f"{path}: {error!r}; expected the output of "
                        "`gaindesign design --json`") from error
    return design


def pair_of(model, name):
    return next(pair for pair in model["pairs"] if pair["name"] == name)


def number(value):
    return f"{value:.4g}".replace("-", "\N{MINUS SIGN}")


def mark(ax, gains, look, text=None, offset=(0, 0)):
    """A pair of gains; in the zoom, what it is."""
    place = (gains["kp"], gains["ki_per_s"])
    ax.plot(*place, linestyle="none", zorder=7, **look)
    if text:
        ax.annotate(f"{text}\n{number(place[0])}, {number(place[1])}", place, xytext=offset,
                    textcoords="offset points", color=look["color"], va="center",
                    fontsize=style.PRINT.font - 1.5, zorder=8)


def mark_gains(ax, design, words):
    """The paper's pairs, and what the search found for each set of matrices."""
    first = design["models"][0]
    ink = {"color": LIGHT["ink"], "markersize": 5}
    published = pair_of(first, "published")
    other = {"kp": published["kp"], "ki_per_s": -published["ki_per_s"]}
    mark(ax, pair_of(first, "arbitrary"), ink | {"marker": "s"},
         words and "paper, fig. 4a, 5a", (4, -13))
    mark(ax, published, ink | {"marker": "o"}, words and "paper, fig. 4b, 5b, 6", (-84, 5))
    mark(ax, other, ink | {"marker": "o", "markerfacecolor": LIGHT["paper"]},
         words and "other sign: unstable", (8, -2))
    for model, offset in zip(design["models"], ((-84, 32), (16, 5))):
        look = {"color": LOOKS[model["matrices"]]["color"], "marker": "*", "markersize": 9}
        mark(ax, model["optimum"], look, words and f"optimum, {model['matrices']}", offset)


def draw_edges(ax, design):
    for model in design["models"]:
        name, region = model["matrices"], model["stable_region"]
        look = LOOKS[name]
        ax.plot(region["kp"], region["largest_ki_per_s"], label=NAMES[name], **look)
        ax.fill_between(region["kp"], 0, region["largest_ki_per_s"], color=look["color"],
                        alpha=0.08, linewidth=0)
    ax.axhline(0, color=LIGHT["muted"], linewidth=0.7, zorder=3)
    ax.set_xlabel("K_p")


def zoom(design):
    """x and y range around the paper's gains and the optima."""
    pairs = [pair_of(design["models"][0], name) for name in ("arbitrary", "published")]
    pairs += [model["optimum"] for model in design["models"]]
    kp = [pair["kp"] for pair in pairs]
    ki = max(abs(pair["ki_per_s"]) for pair in pairs)
    span = max(kp) - min(kp)
    return (min(kp) - 0.1 * span, max(kp) + 0.5 * span), (-2.4 * ki, 4 * ki)


def draw_region(design, shape):
    with matplotlib.rc_context(style.settings(shape)):
        side_by_side = shape.columns > 1
        fig = Figure(figsize=(shape.width, HEIGHT if side_by_side else 2 * HEIGHT), layout="constrained")
        whole, near = (fig.subplots(1, 2, width_ratios=(1, 1.25)) if side_by_side else fig.subplots(2, 1))
        for ax in (whole, near):
            draw_edges(ax, design)
            mark_gains(ax, design, words=ax is near)
        whole.set_title(REGION_TITLE if shape.titled else "all stable gains")
        whole.set_ylabel("K_i, 1/s")
        whole.set_ylim(-0.15 * whole.get_ylim()[1], 1.35 * whole.get_ylim()[1])
        whole.set_xlim(right=1.05 * zoom(design)[0][1])
        whole.legend(loc="upper left", frameon=False)
        near.set_title("around the paper's gains")
        near.set_xlim(*zoom(design)[0])
        near.set_ylim(*zoom(design)[1])
        whole.indicate_inset_zoom(near, edgecolor=LIGHT["muted"])
    return fig


def response_of(model, figure):
    return next(response for response in model["responses"]
                if (response["step"], response["pair"]) == (figure.step, figure.pair))


def draw_response(design, figure, shape):
    with matplotlib.rc_context(style.settings(shape)):
        fig = Figure(figsize=(shape.width, HEIGHT), layout="constrained")
        ax = fig.add_subplot()
        ax.set_xlabel("time, s")
        ax.set_ylabel(LABELS[figure.signal])
        if shape.titled:
            ax.set_title(figure.title(design))
        for model in design["models"]:
            draw_model(ax, model, figure)
        ax.axhline(1 if figure.step == "speed" else 0, color=LIGHT["command"], linewidth=0.7, zorder=3)
        columns = 2 if shape.columns > 1 else 1
        low, high = ax.get_ylim()
        ax.set_ylim(low, high + ROOM_FOR_LEGEND / columns * (high - low))
        ax.legend(loc="upper right", frameon=False, ncols=columns)
    return fig


def draw_model(ax, model, figure):
    response, look = response_of(model, figure), LOOKS[model["matrices"]]
    ax.plot(response["time_s"], response[figure.signal], label=NAMES[model["matrices"]], **look)
    ax.set_xlim(0, response["time_s"][-1])
    if figure.signal == "i_d_a":
        ax.axhline(response["settled_i_d_a"], color=look["color"], linewidth=0.9, linestyle=(0, (1, 2)), zorder=3,
                   label=f"settles at {response['settled_i_d_a']:.3f} A")


def figures(design):
    """(key, title, how to draw it in a Shape) of the six."""
    yield REGION, REGION_TITLE, lambda shape: draw_region(design, shape)
    for figure in RESPONSES:
        yield figure.key, figure.title(design), lambda shape, figure=figure: draw_response(design, figure, shape)


def write_figures(path, folder):
    """The six figures as PNG files; returns their paths."""
    design = read_design(path)
    make_folder(folder)
    written = []
    for key, _, draw in figures(design):
        written.append(folder / f"design_{key}.png")
        save(draw(style.PRINT), style.PRINT, written[-1])
    return written
