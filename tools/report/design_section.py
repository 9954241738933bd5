# SPDX-License-Identifier: MIT
"""The section of the report on paper B's gain design: its figures, and what of the paper follows from it."""

from report import gains
from report.picture import picture
from report.render import render

KEY = "gain-design"
UNITS = (("_kg_m2", "kg·m²"), ("_rad_s", "rad/s"), ("_per_s", "1/s"), ("_deg", "°"), ("_rad", "rad"), ("_a", "A"), ("_v", "V"),
         ("_s", "s"))
SYMBOLS = {"phi": "Φ", "theta": "Θ", "kp": "K_p", "ki": "K_i"}
SIGNALS = (("i_q", "i\0q"), ("i_d", "i\0d"))


def label(quantity):
    """`optimum_ki_per_s` as `optimum K_i, 1/s`."""
    ending, unit = next(((end, unit) for end, unit in UNITS if quantity.endswith(end)), ("", ""))
    text = quantity.removesuffix(ending)
    for name, kept in SIGNALS:
        text = text.replace(name, kept)
    words = " ".join(SYMBOLS.get(word, word) for word in text.split("_")).replace("\0", "_")
    return f"{words}, {unit}" if unit else words


def cell(value):
    return "–" if value is None else f"{value:.6g}".replace("-", "−")


def row(comparison):
    return (label(comparison["quantity"]), *(cell(comparison[key]) for key in ("paper", "printed", "computed")),
            comparison["remark"])


def caption(design, response):
    """Of a figure: the end points that it is drawn for."""
    texts = []
    for model in design["models"]:
        curve = gains.response_of(model, response)
        values = curve[response.signal]
        last = f"settles at {curve['settled_i_d_a']:.3g}" if response.signal == "i_d_a" else f"{values[-1]:.3g} at the end"
        texts.append(f"{model['matrices']}: {min(values):.3g} to {max(values):.3g}, {last}")
    return (f"{gains.LABELS[response.signal]}; " + "; ".join(texts) + ".").replace("-", "−")


def pictures(design, folder):
    responses = {response.key: response for response in gains.RESPONSES}
    for key, title, draw in gains.figures(design):
        text = caption(design, responses[key]) if key in responses else (
            "Stable are the pairs below each curve and above 0; marked: the paper's pairs and the optima.")
        yield picture(f"design_{key}", title, (text, f"{title}. {text}"), draw, folder)


def entry(path, folder):
    """Identifier, title and HTML for page(); writes the PNGs into the folder of the report."""
    design = gains.read_design(path)
    return KEY, "gain design", render("report/gain_design.jinja", key=KEY, pictures=list(pictures(design, folder)),
                                      rows=[row(comparison) for comparison in design["comparison"]])
