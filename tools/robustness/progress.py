# SPDX-License-Identifier: MIT
"""How far a campaign is: a bar on a terminal, a line now and then elsewhere."""

import contextlib
import time
from collections import Counter

from rich.progress import (BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn,
                           TimeRemainingColumn)
from rich.table import Column
from rich.text import Text

from .simulator import OUTCOMES, REFUSED

LINES = 10     # of a whole campaign without a terminal
QUIET_S = 2.0  # between two of them at least; the last always comes
STYLES = dict(zip(OUTCOMES, ("blue", "cyan", "magenta", "yellow", "red")))


class RateColumn(ProgressColumn):
    def render(self, task):
        return Text("" if task.speed is None else f"{task.speed:.1f}/s")


def seen(counts):
    """The outcomes that are shown: only a motor of the zoo is ever refused."""
    return [outcome for outcome in OUTCOMES if outcome != REFUSED or counts[REFUSED]]


def counts_text(counts):
    return ", ".join(f"{counts[outcome]} {outcome}" for outcome in seen(counts))


def counts_markup(counts):
    return " ".join(f"[{STYLES[outcome]}]{counts[outcome]} {outcome}[/]" for outcome in seen(counts))


class Lines:
    """Plain lines: one at each tenth, fewer where those come fast."""

    def __init__(self, console, name, total, counts):
        self.console, self.name, self.total, self.counts = console, name, total, counts
        self.start, self.before = time.monotonic(), sum(counts.values())
        self.shown = self.start

    def __call__(self, row):
        self.counts[row["outcome"]] += 1
        done = sum(self.counts.values())
        now = time.monotonic()
        due = done * LINES // self.total > (done - 1) * LINES // self.total
        if done == self.total or (due and now - self.shown > QUIET_S):
            self.shown = now
            rate = (done - self.before) / max(now - self.start, 1e-3)
            self.console.print(f"{self.name}: {done} of {self.total} runs, {rate:.1f} runs/s, "
                               f"{(self.total - done) / rate:.0f} s left: "
                               f"{counts_text(self.counts)}", highlight=False, soft_wrap=True)


@contextlib.contextmanager
def shown(console, name, total, rows):
    """Yields what takes each new row; `rows` are those from before."""
    counts = Counter(row["outcome"] for row in rows)
    if not console.is_terminal:
        yield Lines(console, name, total, counts)
        return
    def whole():
        return Column(no_wrap=True)

    columns = (TextColumn("{task.description}", table_column=whole()), BarColumn(None),
               MofNCompleteColumn(table_column=whole()), RateColumn(table_column=whole()),
               TimeRemainingColumn(table_column=whole()),
               TextColumn("{task.fields[counts]}", table_column=whole()))
    with Progress(*columns, console=console, expand=True) as bar:
        task = bar.add_task(name, total=total, completed=len(rows), counts=counts_markup(counts))

        def add(row):
            counts[row["outcome"]] += 1
            bar.update(task, advance=1, counts=counts_markup(counts))

        yield add
