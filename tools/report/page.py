# SPDX-License-Identifier: MIT
"""The report as one HTML page: text, tables and inline figures, nothing from elsewhere."""

from report import claim, metrics
from report.render import render

TITLES = {
    "s1": "speed command 0 → 1000 → 1800 rpm without load",
    "s2": "load of 3 N·m from 0.5 s to 0.8 s at 1800 rpm",
    "s3": "position command 0 → 3π → −3π rad",
    "s4": "voltage drive with the sensor's angle, load of 3 N·m from 0.1 s on",
    "s5": "voltage drive with the estimated angle, load of 3 N·m from 0.1 s on",
    "s_weakening": "2600 rpm both ways with a weakened field, load of 3 N·m at 2600 rpm",
    "s_weakening_compressor": "6500 rpm both ways with a weakened field, salient compressor motor, load of 0.8 N·m at 6500 rpm",
}


def page(entries, more=()):
    """The page of (run, pictures) pairs, and of (identifier, title, section) of what follows them."""
    runs = [run for run, _ in entries]
    links = [*((run.name, heading(run)) for run in runs), *((name, title) for name, title, _ in more)]
    return render("report/page.jinja", summary=summary(runs), links=links, measures=claim.MEASURES,
                  claimed=f"{claim.CLAIM_PERCENT:g} %", runs=[shown(run, pictures) for run, pictures in entries],
                  sections=[section for _, _, section in more])


def shown(run, pictures):
    """A run as the template needs it."""
    return {"name": run.name, "heading": heading(run), "title": TITLES.get(run.scenario), "conditions": conditions(run),
            "errors": claim.values(run), "kept": claim.accepted(run.metrics),
            "failed": "; ".join(map(metrics.limit_text, claim.failed_limits(run.metrics) or [])), "pictures": pictures,
            "metrics": metrics.figures(run), "without": metrics.without(run), "tables": metrics.tables(run)}


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


def heading(run):
    name = run.scenario.upper() if run.scenario in TITLES else run.scenario
    return name if run.name.lower() == run.scenario else f"{name} ({run.name})"


def conditions(run):
    imperfections = run.metrics.get("with") or []
    if isinstance(imperfections, str):
        imperfections = [imperfections]
    text = ", ".join(map(str, imperfections)) or "ideal"
    settings = run.metrics.get("set") or []
    if settings:
        text += f"; {', '.join(map(str, settings))}"
    return text if run.metrics.get("seed") is None else f"{text}, seed {run.metrics['seed']}"
