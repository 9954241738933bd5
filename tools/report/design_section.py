# SPDX-License-Identifier: MIT
"""The section of the report on paper B's gain design: its figures, and what of the paper follows from it."""

import html

from report import gains
from report.assemble import picture
from report.page import figure

KEY = "gain-design"
TITLE = "Gain design of the voltage drive: paper B, section 4"
INTRO = ("S6 to S8 are the linear drive of paper B, (48), with the gains that it calls arbitrary and optimal. The matrices that "
         "the paper prints do not follow from the parameters that it prints, so each figure has both.")
HOW = ("Each figure of the paper beside what its printed matrices and what its parameters give. Where they differ "
       "the last column says why, as far as it can be told.")
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
    values = "".join(f'<td data-label="{head}">{cell(comparison[key])}</td>'
                     for key, head in (("paper", "paper"), ("printed", "printed matrices"), ("computed", "computed")))
    return (f"<tr><th scope=row>{html.escape(label(comparison['quantity']))}</th>{values}"
            f'<td data-label="remark">{html.escape(comparison["remark"])}</td></tr>')


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
    shown = "\n".join(figure(one) for one in pictures(design, folder))
    rows = "\n".join(row(comparison) for comparison in design["comparison"])
    return KEY, "gain design", f"""<section class="run" id="{KEY}">
<h2>{TITLE}</h2>
<p>{INTRO}</p>
{shown}
<h3>What can be reproduced, and what cannot</h3>
<table class="cards">
<caption>{HOW}</caption>
<thead><tr><th scope=col>Figure</th><th scope=col>paper</th><th scope=col>printed matrices</th>
<th scope=col>computed</th><th scope=col>remark</th></tr></thead>
<tbody>
{rows}
</tbody>
</table>
</section>"""
