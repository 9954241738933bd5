#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a control tick costs on a Cortex-M: instructions, modelled cycles, stack, sizes.

  tools/bench_target.py                     the tables
  tools/bench_target.py --json cost.json    and all figures as JSON
  tools/bench_target.py --profile           where the instructions of a RUN tick go, by function
  tools/bench_target.py --check             compared with the budget, tools/bench/budget.toml
  tools/bench_target.py --write-budget      the budget from what is measured now

It needs the builds host, cortex-m0plus, cortex-m3 and cortex-m4 (tools/dev build PRESET). Their
images hal/mps2/replay_*.elf replay runs of the simulator in an emulator: S1 to S3 with the
published tuning and nothing imperfect, and with the robust tuning, every imperfection and a fault at
the end; S5, which the voltage drive runs, with real sensing. Each tick's results must be those of the PC, or there is
no figure.

Counted is a call of the control interrupt from its first instruction to its return: sampling
conversion, protection, state machine, observer, current loop, modulator, the decimated motion loops
and what they call of the compiler's library. hal_sample() and hal_apply() are in it, those of a board
that reads and writes memory; the exception's entry and the recording's reading and writing are not.
An instruction that an IT block skips counts, as the core fetches it. A tick belongs to the state
that it ends in. Cycles are a model; its assumptions are printed with it.
"""

import argparse
import contextlib
import json
import sys
from pathlib import Path

import own_python
import user_text

ROOT = Path(__file__).resolve().parents[1]
BUDGET = ROOT / "tools/bench/budget.toml"

EPILOG = """Exit status: 0 done; 1 with --check, a figure is outside the budget, each in one line; 2 an
image, a file or an argument is missing or wrong."""


def progress_on(console):
    """A bar on the terminal for each replay, or a line each where there is no terminal."""
    from rich.progress import Progress

    @contextlib.contextmanager
    def progress(title, total):
        if not console.is_terminal:
            console.print(f"{title} ...")
        with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task(title, total=total)
            yield lambda done: bar.update(task, advance=done)

    return progress


def show_profiles(console, benches, args):
    from bench.image import BenchError
    from bench.profile import profile
    from bench.tables import profile_table
    for bench in benches:
        if args.state not in bench.states:
            raise BenchError(f"--state: no tick of {bench.tuning} ends in {args.state}; "
                             f"expected one of {', '.join(bench.states)}")
        shares = profile(bench, args.state, args.lines, args.worst)
        console.print(profile_table(bench, args.state, shares, args.top))


def write(path, text):
    from bench.image import BenchError
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BenchError(f"{path}: {error.strerror}; expected a file that can be written") from error


def check(figures, path):
    """Compares with the budget; the exit status."""
    from bench import budget
    found = budget.findings(figures, budget.read(path))
    for line in found:
        print(line)
    count = sum(map(len, figures.values()))
    if found:
        print(f"{len(found)} of {count} figures outside {path.name}. If that is meant: "
              "tools/dev figures --write budget")
        return 1
    print(f"all {count} figures within {path.name}")
    return 0


def report_on(console, benches, args):
    """Tables, files and the comparison that the arguments ask for; the exit status."""
    from bench import budget, report, tables
    found = report.collect(benches)
    if args.json:
        write(args.json, json.dumps(found, indent=2) + "\n")
    figures = report.figures(found)
    if args.check:
        return check(figures, args.budget)
    for table in tables.all_tables(found):
        console.print(table)
    if args.write_budget:
        write(args.budget, budget.as_toml(figures))
        print(args.budget)
    return 0


def one_of(names):
    """A list of names separated by commas, each out of `names`."""
    def parse(text):
        chosen = text.split(",")
        for name in chosen:
            if name not in names:
                raise argparse.ArgumentTypeError(f"'{name}' is none of {', '.join(names)}")
        return chosen
    return parse


def add_profile(parser, states):
    group = parser.add_argument_group("profile")
    group.add_argument("--profile", action="store_true",
                       help="instructions by source function, inlined ones told apart, "
                       "instead of the tables")
    group.add_argument("--lines", action="store_true", help="by source line")
    group.add_argument("--worst", action="store_true",
                       help="sorted by the longest tick, not by the mean")
    group.add_argument("--state", default="RUN", choices=states, help="of which ticks (RUN)")
    group.add_argument("--top", type=int, default=25, metavar="N", help="how many rows (25)")


def add_budget(parser):
    group = parser.add_argument_group("budget")
    either = group.add_mutually_exclusive_group()
    either.add_argument("--check", action="store_true", help="compare, instead of the tables")
    either.add_argument("--write-budget", action="store_true",
                        help="write it, each figure with its margins")
    group.add_argument("--budget", type=Path, default=BUDGET, metavar="FILE",
                       help="the budget (tools/bench/budget.toml)")


def arguments_of(words):
    from bench.machine import CPU
    from bench.replay import RECORDINGS, state_names
    parser = user_text.Parser(
        prog="bench_target.py", description=__doc__, epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=ROOT / "build", metavar="DIR",
                        help="folder of the builds (build)")
    parser.add_argument("--cores", type=one_of(CPU), default=list(CPU), metavar="CORE,...",
                        help=f"out of {', '.join(CPU)} (all)")
    parser.add_argument("--tunings", type=one_of(RECORDINGS), default=list(RECORDINGS),
                        metavar="NAME,...", help=f"out of {', '.join(RECORDINGS)} (all)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    add_profile(parser, state_names())
    add_budget(parser)
    parser.add_argument("--judge", action="store_true", help=argparse.SUPPRESS)  # the words alone: do nothing
    args = parser.parse_args(words)
    if args.write_budget and (len(args.cores) < len(CPU) or len(args.tunings) < len(RECORDINGS)):
        parser.error("--write-budget: a budget of all cores and tunings is expected")
    return args


def main(words=None):
    problem = own_python.missing("capstone", "rich", "unicorn")
    if problem:
        print(f"bench_target.py: {problem}", file=sys.stderr)
        return 2
    from rich.console import Console

    from bench.image import BenchError
    from bench.replay import measure
    args = arguments_of(words)
    if args.judge:
        return 0
    console = Console()
    try:
        benches = measure(args.build, args.cores, args.tunings, progress_on(Console(stderr=True)))
        if args.profile:
            show_profiles(console, benches, args)
            return 0
        return report_on(console, benches, args)
    except BenchError as error:
        user_text.tell("bench_target.py", error)
        return 2


if __name__ == "__main__":
    sys.exit(main())
