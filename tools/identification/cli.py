# SPDX-License-Identifier: MIT
"""The command line of identifications of many motors."""

import argparse
import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import user_text
from docs import generated
from rich.console import Console
from rich.progress import Progress
from whole_file import read_whole

from . import motor, table

ROOT = Path(__file__).resolve().parents[2]
DONE, BAD_INPUT, INTERRUPTED = 0, 2, 130
PAGE, RESULTS = "docs/identification.md", "results.json"

HELP = """Identifies motors of the zoo as users have them, with the dead time off by half and saturated iron, and says how far the
results are off, how often the truth lies within their bars, and which goal is not met. Then runs the drive with each result.

  tools/measure_zoo                      500 motors of seed 2026, some minutes
  tools/measure_zoo --motors 20 --seed 7
  tools/measure_zoo --no-run             only the identification
  tools/measure_zoo --write              500 motors, and their table in docs/identification.md anew
  tools/measure_zoo --results build/identified/2026/results.json --check
                                         of an earlier measurement: whether the page shows it; --write writes it

The motor files, the console's lines and the results stay in the folder.
"""


def whole(text):
    if not text.isdigit() or not 1 <= int(text) < 1_000_000:
        raise argparse.ArgumentTypeError(f"{text}: expected a whole number from 1 to 999999")
    return int(text)


def parser():
    found = user_text.Parser(prog="measure_zoo", description=HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("--seed", type=whole, default=2026, help="of the zoo; default 2026")
    found.add_argument("--motors", type=whole, default=500, help="so many, from number 0 on; default 500")
    found.add_argument("--no-run", action="store_true", help="do not run the drive with the results")
    found.add_argument("--motorsim", type=Path, default=ROOT / "build/host/motorsim", help="the program, with nfconfig beside it")
    found.add_argument("--out", type=Path, help="folder of the results; default build/identified/SEED")
    found.add_argument("--results", type=Path, metavar="JSON", help=f"measure nothing: {RESULTS} of an earlier measurement")
    found.add_argument("--check", action="store_true", help=f"compare {PAGE} with the results; exit status 1 if it shows others")
    found.add_argument("--write", action="store_true", help=f"write the results to {PAGE}")
    return found


def one(programs, tried, runs, folder):
    found = motor.identified(programs, tried, folder)
    if runs and found["refusal"] is None:
        found["run"] = motor.driven(programs, tried, found, folder)
    Path(folder, f"{tried.number}.json").write_text(json.dumps(found), encoding="utf-8")
    return found


def all_of(args, programs, folder):
    tried = [motor.Motor(args.seed, number) for number in range(args.motors)]
    with Progress(console=Console(stderr=True), transient=True) as bar, ThreadPoolExecutor(os.cpu_count()) as pool:
        task = bar.add_task("motors", total=len(tried))
        results = []
        for found in pool.map(lambda each: one(programs, each, not args.no_run, folder), tried):
            results.append(found)
            bar.advance(task)
    return results


def measured(args):
    """The results, or the status of a problem, which has been said."""
    programs = motor.Programs(args.motorsim.resolve(), args.motorsim.resolve().with_name("nfconfig"))
    for program in (programs.motorsim, programs.nfconfig):
        if not os.access(program, os.X_OK):
            print(f"measure_zoo: {program}: no program; run tools/dev build", file=sys.stderr)
            return BAD_INPUT
    folder = args.out or ROOT / "build/identified" / str(args.seed)
    folder.mkdir(parents=True, exist_ok=True)
    try:
        found = {"seed": args.seed, "motors": all_of(args, programs, folder)}
    except KeyboardInterrupt:
        return INTERRUPTED
    Path(folder, RESULTS).write_text(json.dumps(found), encoding="utf-8")
    return found


def read(path):
    try:
        found = json.loads(read_whole(path))
        return {"seed": found["seed"], "motors": list(found["motors"])}
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        user_text.tell("measure_zoo", f"{path}: no results of measure_zoo: {error}")
        return BAD_INPUT


def main(words=None):
    args = parser().parse_args(words)
    found = read(args.results) if args.results else measured(args)
    if isinstance(found, int):
        return found
    results = found["motors"]
    shown = [*table.lines(results), "", *table.summary(results, found["seed"])]
    print("\n".join([*shown, "", *table.refused(results)]))
    if args.check or args.write:
        generated.finish(PAGE, {"results": "\n".join([*shown, ""])}, "the measurement", args.write)
    return DONE
