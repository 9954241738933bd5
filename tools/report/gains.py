"""The figures 3 to 6 of paper B from the JSON of `gaindesign design`."""

import json

import matplotlib
from matplotlib.figure import Figure

from report import style
from report.assemble import save
from report.runs import PlotError, read_text
from report.style import LIGHT

HEIGHT = 2.9    # inches
# What the matrices are drawn with.
LOOKS = {
    "computed": {"color": LIGHT["actual"], "linewidth": 1.1, "zorder": 4},
    "printed": {"color": LIGHT["estimated"], "linewidth": 0.9, "linestyle": (0, (5, 1.5)),
                "zorder": 5},
}
NAMES = {"computed": "computed from the parameters", "printed": "as the paper prints them"}
STEPS = {"load": "a load step of 1 N·m", "speed": "a speed step of 1 rad/s"}
LABELS = {"speed_rad_s": "speed, rad/s", "i_d_a": "d current, A"}
# Key, title, step, pair, signal.
RESPONSES = (
    ("fig4a", "Speed after {step}, K_p = {kp:g}, K_i = {ki:g} /s (paper B, fig. 4a)",
     "load", "arbitrary", "speed_rad_s"),
    ("fig4b", "Speed after {step}, K_p = {kp:g}, K_i = {ki:g} /s (paper B, fig. 4b)",
     "load", "published", "speed_rad_s"),
    ("fig5a", "Speed after {step}, K_p = {kp:g}, K_i = {ki:g} /s (paper B, fig. 5a)",
     "speed", "arbitrary", "speed_rad_s"),
    ("fig5b", "Speed after {step}, K_p = {kp:g}, K_i = {ki:g} /s (paper B, fig. 5b)",
     "speed", "published", "speed_rad_s"),
    ("fig6", "d current after {step}, K_p = {kp:g}, K_i = {ki:g} /s (paper B, fig. 6)",
     "load", "published", "i_d_a"),
)


def read_design(path):
    text = read_text(path, "the output of `gaindesign design --json`")
    try:
        design = json.loads(text)
        design["models"][0]["stable_region"]["kp"]
    except (ValueError, LookupError, TypeError) as error:
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


def draw_region(design):
    fig = Figure(figsize=(style.PRINT.width, HEIGHT), layout="constrained")
    whole, near = fig.subplots(1, 2, width_ratios=(1, 1.25))
    for ax in (whole, near):
        draw_edges(ax, design)
        mark_gains(ax, design, words=ax is near)
    whole.set_title("Stable gains (paper B, fig. 3)")
    whole.set_ylabel("K_i, 1/s")
    whole.set_ylim(-0.15 * whole.get_ylim()[1], 1.35 * whole.get_ylim()[1])
    whole.set_xlim(right=1.05 * zoom(design)[0][1])
    whole.legend(loc="upper left", frameon=False)
    near.set_title("around the paper's gains")
    near.set_xlim(*zoom(design)[0])
    near.set_ylim(*zoom(design)[1])
    whole.indicate_inset_zoom(near, edgecolor=LIGHT["muted"])
    return fig


def axes(title, y_label):
    fig = Figure(figsize=(style.PRINT.width, HEIGHT), layout="constrained")
    ax = fig.add_subplot()
    ax.set_title(title)
    ax.set_xlabel("time, s")
    ax.set_ylabel(y_label)
    return fig, ax


def response_of(model, step, pair):
    return next(r for r in model["responses"] if r["step"] == step and r["pair"] == pair)


def draw_response(design, title, step, pair, signal):
    gains = pair_of(design["models"][0], pair)
    fig, ax = axes(title.format(step=STEPS[step], kp=gains["kp"], ki=gains["ki_per_s"]),
                   LABELS[signal])
    for model in design["models"]:
        response = response_of(model, step, pair)
        ax.plot(response["time_s"], response[signal], label=NAMES[model["matrices"]],
                **LOOKS[model["matrices"]])
        if signal == "i_d_a":
            ax.axhline(response["settled_i_d_a"], color=LOOKS[model["matrices"]]["color"],
                       linewidth=0.9, linestyle=(0, (1, 2)), zorder=3,
                       label=f"settles at {response['settled_i_d_a']:.3f} A")
    target = 1 if step == "speed" else 0
    ax.axhline(target, color=LIGHT["command"], linewidth=0.7, zorder=3)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.26 * (high - low))  # room for the legend
    ax.set_xlim(0, response["time_s"][-1])
    ax.legend(loc="upper right", frameon=False, ncols=2)
    return fig


def write_figures(path, folder):
    """The six figures as PNG files; returns their paths."""
    design = read_design(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(f"{folder}: {error.strerror}; expected a folder to write to") from error
    written = []
    with matplotlib.rc_context(style.settings(style.PRINT)):
        figures = [("fig3", draw_region(design))]
        figures += [(key, draw_response(design, *what)) for key, *what in RESPONSES]
    for key, figure in figures:
        written.append(folder / f"design_{key}.png")
        save(figure, style.PRINT, written[-1])
    return written
