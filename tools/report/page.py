# SPDX-License-Identifier: MIT
"""The report as one HTML page: text, tables and inline figures, nothing from elsewhere."""

import html
from dataclasses import dataclass

from report import claim
from report.document import anchor, document
from report.panels import with_unit

TITLES = {
    "s1": "speed command 0 → 1000 → 1800 rpm without load",
    "s2": "load of 3 N·m from 0.5 s to 0.8 s at 1800 rpm",
    "s3": "position command 0 → 3π → −3π rad",
    "s4": "voltage drive with the sensor's angle, load of 3 N·m from 0.1 s on",
    "s5": "voltage drive with the estimated angle, load of 3 N·m from 0.1 s on",
}
METRICS = {     # key: name, unit
    "speed_error_max_rpm": ("speed error, largest", "rpm"),
    "speed_error_rms_rpm": ("speed error, rms", "rpm"),
    "speed_error_max_pct": ("speed error, largest", "% of rated"),
    "command_error_settled_pct": ("command error, settled", "%"),
    "angle_error_max_deg": ("angle error, largest", "° el."),
    "iq_error_max_a": ("q current error, largest", "A"),
    "settling_time_s": ("settling time", "s"),
    "overshoot_pct": ("overshoot", "%"),
    "speed_dip_rpm": ("speed dip", "rpm"),
    "recovery_time_s": ("recovery time", "s"),
    "position_error_final_rad": ("position error, final", "rad"),
    "id_settled_a": ("d current, settled", "A"),
    "locked": ("rotor kept", ""),
    "faults": ("faults", ""),
    "saturations": ("saturations", ""),
    "saturation_internal_count": ("saturations inside the arithmetic", ""),
}
HEADED = ("scenario", "with", "set", "seed", "accepted")   # shown in the heading of a run


@dataclass(frozen=True)
class Picture:
    """A figure of a run in the forms that the page and its reader need."""

    title: str
    caption: str
    wide: str       # <svg> elements
    narrow: str
    file: str       # a PNG beside the page


def page(entries, more=()):
    """The page of (run, pictures) pairs, and of (identifier, title, section) of what follows them."""
    runs = [run for run, _ in entries]
    sections = "\n".join([*(section(run, pictures) for run, pictures in entries),
                          *(text for _, _, text in more)])
    links = "".join([*map(link, runs), *(anchor(name, title) for name, title, _ in more)])
    header = f"""<h1>Sensorless drive: simulated runs</h1>
<p>{summary(runs)}</p>
<nav aria-label="Runs">{links}</nav>"""
    return document("neurofoc: simulated runs", header, f"{claims(runs)}\n{sections}")


def summary(runs):
    judged = [value for run in runs for value in claim.values(run) if value]
    within = sum(value.within for value in judged)
    kept = [kept for kept in (claim.accepted(run.metrics) for run in runs) if kept is not None]
    text = (f"{count(len(runs), 'run')}; {within} of {len(judged)} errors are within the "
            f"{claim.CLAIM_PERCENT:g} % that paper A claims.")
    if kept:
        text += f" {sum(kept)} of {len(kept)} runs with limits of their own kept them."
    return text


def count(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


def link(run):
    return anchor(run.name, heading(run))


def heading(run):
    name = run.scenario.upper() if run.scenario in TITLES else run.scenario
    return name if run.name.lower() == run.scenario else f"{name} ({run.name})"


def claims(runs):
    heads = "".join(f"<th scope=col>{measure.name}</th>" for measure in claim.MEASURES)
    limit = f"<td>≤ {claim.CLAIM_PERCENT:g} %</td>".replace("<td>", '<td data-label="{}">')
    limits = "".join(limit.format(measure.name) for measure in claim.MEASURES)
    rows = "\n".join(claim_row(run) for run in runs)
    how = "".join(f"<dt>{measure.name}</dt><dd>{measure.how}</dd>" for measure in claim.MEASURES)
    return f"""<section>
<h2>Errors beside the paper's claim</h2>
<p>Paper A shows its errors for the step of the load (fig. 8) and concludes that they stay within
2 %; it does not say of what. Here the 2 % are the measure of every error of every run.</p>
<table class="cards">
<thead><tr><th scope=col>Run</th>{heads}<th scope=col>Limits of the scenario</th></tr></thead>
<tbody>
<tr><th scope=row>Paper A</th>{limits}<td data-label="Limits"></td></tr>
{rows}
</tbody>
</table>
<h3>How each error is measured</h3>
<dl>{how}</dl>
</section>"""


def claim_row(run):
    cells = "".join(claim_cell(measure, value)
                    for measure, value in zip(claim.MEASURES, claim.values(run)))
    return (f"<tr><th scope=row>{link(run)}<small>{html.escape(conditions(run))}</small></th>"
            f'{cells}<td data-label="Limits">{limits(run)}</td></tr>')


def claim_cell(measure, value):
    if value is None:
        return f'<td data-label="{measure.name}" class=muted><span>does not apply</span></td>'
    mark, word = ("good", "within") if value.within else ("bad", "above")
    percent = "< 0.01" if 0 < value.percent < 0.005 else f"{value.percent:.2f}"
    return (f'<td data-label="{measure.name}"><span><span class="verdict {mark}">{percent} % '
            f"{word}</span><small>{html.escape(value.detail)}</small></span></td>")


def limits(run):
    kept = claim.accepted(run.metrics)
    if kept is None:
        return "<span class=muted>not judged</span>"
    failed = html.escape("; ".join(claim.failed_limits(run.metrics) or []))
    mark, word = ("good", "kept") if kept else ("bad", "broken")
    return f'<span><span class="verdict {mark}">{word}</span><small>{failed}</small></span>'


def conditions(run):
    imperfections = run.metrics.get("with") or []
    if isinstance(imperfections, str):
        imperfections = [imperfections]
    text = ", ".join(map(str, imperfections)) or "ideal"
    settings = run.metrics.get("set") or []
    if settings:
        text += f"; {', '.join(map(str, settings))}"
    return text if run.metrics.get("seed") is None else f"{text}, seed {run.metrics['seed']}"


def section(run, pictures):
    title = TITLES.get(run.scenario)
    headline = heading(run) + (f": {title}" if title else "")
    figures = "\n".join(figure(picture) for picture in pictures)
    return f"""<section class="run" id="{html.escape(run.name)}">
<h2>{html.escape(headline)}</h2>
<p>Imperfections: {html.escape(conditions(run))}. Limits of the scenario: {limits(run)}</p>
{figures}
<h3>Metrics</h3>
<dl class="metrics">{metrics(run)}</dl>
</section>"""


def figure(picture):
    return f"""<h3>{html.escape(picture.title)}</h3>
<figure>
<div class="wide">{picture.wide}</div>
<div class="narrow">{picture.narrow}</div>
<figcaption>{html.escape(picture.caption)}
<span class="files"><a href="{html.escape(picture.file)}">PNG</a></span></figcaption>
</figure>"""


def metrics(run):
    known = [key for key in METRICS if key in run.metrics]
    other = [key for key in run.metrics if key not in METRICS and key not in HEADED]
    return "".join(metric(key, run.metrics[key]) for key in known + other)


def metric(key, value):
    name, unit = METRICS.get(key, (key.replace("_", " "), ""))
    shown = metric_text(value)
    if unit and value is not None:
        shown = with_unit(shown, unit)
    return f"<div><dt>{html.escape(name)}</dt><dd>{html.escape(shown)}</dd></div>"


def metric_text(value):
    if value is None:
        return "does not apply"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}".replace("-", "−")
    if isinstance(value, dict):
        counted = [f"{key}: {metric_text(item)}" for key, item in value.items() if item != 0]
        return ", ".join(counted) or "none"
    if isinstance(value, list):
        return ", ".join(map(metric_text, value)) or "none"
    return str(value)
