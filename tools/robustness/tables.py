# SPDX-License-Identifier: MIT
"""The summary of a campaign as tables of text."""

import math

from rich.table import Table
from rich.text import Text

from . import summary, zoo_tables
from .progress import STYLES
from .simulator import LOCKED
from .zoo import Zoo

SHOWN_FAILURES = 8


def table(title, left, right, caption=None):
    """An empty table: its columns aligned to the left, then those to the right."""
    made = Table(title=title, caption=caption, title_justify="left", caption_justify="left")
    for name in left:
        made.add_column(name, no_wrap=True)
    for name in right:
        made.add_column(name, justify="right", no_wrap=True)
    return made


def outcome_table(rows):
    made = table(None, ("outcome",), ("runs", "%", "95 % interval"))
    for count in summary.counts(rows):
        made.add_row(Text(count.outcome, style=STYLES[count.outcome]), str(count.runs),
                     f"{count.percent:.2f}", f"{count.low:.2f} – {count.high:.2f}")
    return made


def figure_table(rows):
    made = table("Figures of the locked runs", ("figure",),
                 (*(f"{q} %" if q != 50 else "median" for q in summary.QUANTILES), "worst", "run",
                  "worst of all", "run"))
    for figure in summary.figures(rows):
        held = [f"{value:.3g}" for value in figure.quantiles] or [""] * len(summary.QUANTILES)
        made.add_row(figure.name, *held, *worst_cells(figure.held), *worst_cells(figure.all))
    return made


def worst_cells(worst):
    return ("", "") if worst is None else (f"{worst.value:.3g}", str(worst.run))


def share_table(campaign, rows):
    """Where the runs gather that do not hold; what matters most comes first."""
    made = table("Not within the limits, % of the runs in each third of a parameter's range",
                 ("parameter", "range"), ("lowest", "middle", "highest"))
    axes = campaign.axes(rows)
    for key, found in summary.ranking(axes, rows).items():
        made.add_row(key, str(axes[key].distribution),
                     *("" if math.isnan(share) else f"{share:.1f}" for share in found))
    return made


def reason_table(rows):
    made = table("Broken limits and faults", ("what",), ("runs",))
    for name, count in summary.reasons(rows):
        made.add_row(name, str(count))
    return made


def demand_lines(campaign, rows):
    for demand in summary.demands(campaign, rows):
        verdict = ("ok", "green") if demand.holds else ("NOT MET", "bold red")
        yield Text.assemble(f"{demand.name} = {demand.found:.4g}, accepted: {demand.sign} "
                            f"{demand.limit:g}  ", verdict)


def failure_lines(campaign, rows, command_of):
    """The first runs that do not hold, with the command that makes each again."""
    failed = summary.failures(rows)
    for row in failed[:SHOWN_FAILURES]:
        yield Text.assemble(f"{command_of(row['run'])}  ",
                            (f"# {row['outcome']}: {summary.reason(row)}", STYLES[row["outcome"]]))
    if len(failed) > SHOWN_FAILURES:
        yield Text(f"… and {len(failed) - SHOWN_FAILURES} more")


def where_tables(campaign, rows):
    """Where the runs gather that do not hold."""
    if not isinstance(campaign.drawn, Zoo):
        return (share_table(campaign, rows),)
    return zoo_tables.class_table(campaign, rows), zoo_tables.number_table(campaign, rows)


def show(console, campaign, rows, command_of):
    part = f"{len(rows)} of " if len(rows) < campaign.runs else ""
    console.print(f"{campaign.name}: {campaign.title}\n{part}{campaign.runs} runs, seed "
                  f"{campaign.seed}", highlight=False, soft_wrap=True)
    console.print(outcome_table(rows))
    console.print(figure_table(rows))
    if any(row["outcome"] != LOCKED for row in rows):
        for one in where_tables(campaign, rows):
            console.print(one)
        console.print(reason_table(rows))
        for line in failure_lines(campaign, rows, command_of):
            console.print(line, soft_wrap=True)
    if isinstance(campaign.drawn, Zoo):
        for line in zoo_tables.lines(rows):
            console.print(line, highlight=False, soft_wrap=True)
    for line in demand_lines(campaign, rows):
        console.print(line, soft_wrap=True)
