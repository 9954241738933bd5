# SPDX-License-Identifier: MIT
"""The bench's results as tables of text."""

from rich.table import Table
from rich.text import Text

from . import cycles
from .report import CORE_LIMIT, GOALS, STATE_LIMIT
from .stack import EXCEPTION_BYTES


def table(title, left, right, caption=None):
    """An empty table: its columns aligned to the left, then those to the right."""
    made = Table(title=title, caption=caption, caption_justify="left", title_justify="left")
    for name in left:
        made.add_column(name)
    for name in right:
        made.add_column(name, justify="right")
    return made


def all_tables(report):
    return [tick_table(report), cycle_table(report), assumption_table(), stack_table(report),
            code_table(report), object_table(report)]


def tick_table(report):
    made = table("Instructions of a control tick", ("core", "tuning", "state"),
                 ("ticks", "mean", "max", "goal"),
                 "Over S1 to S3, voltage_phase over S5. Goal: mean/max of a RUN tick; with ! where it is missed.")
    for core, of_core in report.items():
        for tuning, states in of_core["ticks"].items():
            for state, of_state in states.items():
                made.add_row(core, tuning, state, *tick_cells(of_state),
                             goal_cell(core, of_state) if state == "RUN" else "")
        made.add_section()
    return made


def tick_cells(of_state):
    return str(of_state["ticks"]), f"{of_state['mean']:.1f}", str(of_state["max"])


def goal_cell(core, of_state):
    mean, most = GOALS[core]
    reached = of_state["mean"] <= mean and of_state["max"] <= most
    return Text(f"{mean}/{most}{'' if reached else ' !'}", style="green" if reached else "red")


def cycle_table(report):
    made = table("Modelled cycles of a RUN tick", ("core", "tuning"), ("mean", "max"),
                 "\n".join(cycles.NOTES))
    for of_core in report.values():
        for tuning, states in of_core["ticks"].items():
            for title, found in states["RUN"]["cycles"].items():
                made.add_row(title, tuning, span(found["mean"]), span(found["max"]))
    return made


def span(pair):
    low, high = (f"{value:.0f}" for value in pair)
    return low if low == high else f"{low}–{high}"


def assumption_table():
    made = table("Assumed cycles of a class", ("class",), [model.title for model in cycles.MODELS])
    made.add_column("what it is")
    for kind, meaning in cycles.MEANING.items():
        made.add_row(kind, *(cycles.as_text(model.costs[kind]) for model in cycles.MODELS), meaning)
    made.add_row("and where it jumps", *(f"+ {cycles.as_text(model.refill)}"
                                         for model in cycles.MODELS), "refill of the pipeline")
    return made


def stack_table(report):
    made = table("Stack of the control interrupt, bytes", ("core", "tuning"),
                 ("measured", "computed"),
                 f"On a board the exception's own frame of up to {EXCEPTION_BYTES} comes on top")
    made.add_column("deepest way")
    for core, of_core in report.items():
        for tuning, found in of_core["stack"].items():
            made.add_row(core, tuning, str(found["measured"]), str(found["computed"]),
                         " → ".join(found["deepest"]))
    return made


def code_table(report):
    made = table("Code by source file, bytes", ("file",), report,
                 "Inlined code counts to its own file. The library is what both core and replay use.")
    by_core = [of_core["sizes"]["code"] for of_core in report.values()]
    for file in sorted(set().union(*by_core)):
        made.add_row(Text(file), *(str(code.get(file, 0)) for code in by_core))
    return made


def object_table(report):
    made = table("Constants, variables, totals, bytes", ("object",), report,
                 f"core: firmware/, library and all constants, limit {CORE_LIMIT}; state: `app`, "
                 f"the drive and its frames, limit {STATE_LIMIT}")
    found = [of_core["sizes"] for of_core in report.values()]
    for kind in ("constants", "variables", "sections"):
        for name in dict.fromkeys(name for sizes in found for name in sizes[kind]):
            made.add_row(Text(name), *(str(sizes[kind].get(name, 0)) for sizes in found))
        made.add_section()
    for name in ("core", "state"):
        made.add_row(name, *(str(sizes[name]) for sizes in found))
    return made


def profile_table(bench, state, shares, top):
    """The shares of a tick, largest first; what does not fit into `top` rows as one."""
    made = table(f"{bench.core}, {bench.tuning}: instructions of a {state} tick", (),
                 ("mean", "longest"))
    made.add_column("function")
    made.add_column("source")
    for share in shares[:top]:
        made.add_row(f"{share.mean:.1f}", str(share.worst), share.function, Text(share.file))
    rest = shares[top:]
    if rest:
        made.add_row(*total(rest), f"({len(rest)} more)", "", style="dim")
    made.add_section()
    made.add_row(*total(shares), "all", "")
    return made


def total(shares):
    return (f"{sum(share.mean for share in shares):.1f}", str(sum(share.worst for share in shares)))
