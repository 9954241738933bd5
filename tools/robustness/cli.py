# SPDX-License-Identifier: MIT
"""The command line of robustness campaigns.

Dask and matplotlib take seconds to load: only what runs or draws does.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import user_text
from rich.console import Console

from . import campaign as campaigns
from . import files, progress, results, simulator, summary, tables, zoo_summary
from .arguments import whole
from .campaign import ROOT, CampaignError
from .zoo import Zoo

HOLDS, NOT_MET, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
RUNS = ROOT / "build" / "campaigns"

HELP = """Robustness campaigns: thousands of runs of the simulator, each with other parameters of
the motor, another load, another rotor angle, other noise.

  tools/campaign list                           the campaigns that there are
  tools/campaign run robust                     all its runs, on all cores; what is there is kept
  tools/campaign run robust --runs 200          the first 200; without --runs, the rest later
  tools/campaign run ./mine.toml --jobs 4       a campaign of your own, four runs at once
  tools/campaign run zoo --runs 300             another motor on another board in each run
  tools/campaign run zoo_user --seed 2 --classes servo,hub
                                                such that differ from their files, of these classes
  tools/campaign run zoo --set current_loop.bandwidth_hz=300
                                                what a setting does to all of them
  tools/campaign run robust --scheduler tcp://node1:8786
                                                on a Dask cluster (`dask scheduler`, `dask worker`)
  tools/campaign report robust                  tables and map again, from the results
  tools/campaign rerun robust --run 1234 --trace x.csv
                                                one run again, every tick of it as CSV

Each run is one `motorsim run`. It is `locked` when the scenario's limits hold, `failed safe` when
it ended in a latched fault with the gates open, `held, off limits` when the rotor was held to the
end and a limit of accuracy is missed, else `uncontrolled`. The values of run 1234 depend on the
campaign's seed and on 1234 alone: it is the same on every machine and in any order.

A motor of the zoo may be `refused` too: by physics, or by the firmware's number formats.

In build/campaigns/NAME:  runs.jsonl  results, a line a run, written as they come
                          runs.csv    the same as a table
                          map.png     which runs hold, by pairs of parameters
                          failures.txt  a command for each run that does not hold
                          summary.json  of a zoo: the tables of its classes and numbers
"""
EPILOG = """Exit status: 0 the campaign's [accept] holds; 1 it does not; 2 a file, a value or an
argument is wrong, in one line; 130 after Ctrl-C. The same command goes on where it was stopped."""
FILE_HELP = """A campaign file:

  title = "resistance and load"
  scenario = "campaign"            # of motorsim; a path is relative to this file
  with = ["deadtime"]              # imperfection sets, if any
  runs = 500
  seed = 1

  [set]                            # the same in all runs; keys: build/host/nfconfig keys
  plant.adc_noise_lsb = 1

  [vary]
  plant.resistance_scale = { uniform = [0.7, 1.3] }
  plant.inertia_scale = { log_uniform = [0.5, 3.0] }
  scenario.load_scale = { choice = [0.0, 0.25, 0.5] }
  scenario.seed = { integer = [0, 4294967295] }

  [accept]                         # exit status 1 unless
  locked_pct = 99.5                # at least so many are locked
  uncontrolled = 0                 # at most so many are uncontrolled
  unnamed_pct = 0.1                # at most so many are held off limits or uncontrolled
  false_faults = 0                 # of a zoo: at most so many faults name a part that is whole
  refused_formats = 0              # of a zoo: at most so many motors do not fit a number format

One over the zoo has zoo and classes in place of scenario, with and [vary]:

  zoo = "exact"                    # each motor is as its file says; "user": off it as a user's is
  classes = ["servo", "hub"]       # build/host/nfconfig list names them
"""


def classes(text):
    return tuple(text.split(","))


def load(args):
    """The campaign, with what the command line changes of it."""
    return campaigns.changed(campaigns.load(args.campaign), args.seed, args.classes, args.set)


def folder_of(args, campaign):
    return args.out or RUNS / campaign.name


def command_of(args):
    """The command that makes a run again, as text to copy."""
    words = [str(ROOT / "tools" / "campaign"), "rerun", args.campaign]
    if args.motorsim != simulator.MOTORSIM:
        words += ["--motorsim", str(args.motorsim)]
    if args.seed is not None:
        words += ["--seed", str(args.seed)]
    if args.classes:
        words += ["--classes", ",".join(args.classes)]
    words += [word for text in args.set for word in ("--set", text)]
    return lambda run: simulator.as_shell([*words, "--run", str(run)])


def finish(args, campaign, rows):
    """Tables, files and map of these rows; the exit status."""
    from . import fail_map, slice_map
    is_zoo = isinstance(campaign.drawn, Zoo)
    picture = slice_map if is_zoo else fail_map
    console = Console(width=None if sys.stdout.isatty() else 132)
    folder, command = folder_of(args, campaign), command_of(args)
    tables.show(console, campaign, rows, command)
    paths = [*files.write(folder, campaign, rows, command), picture.write(folder, campaign, rows)]
    paths += [zoo_summary.write(folder, campaign, rows)] if is_zoo else []
    for path in paths:
        if path is not None:
            print(path)
    return HOLDS if all(demand.holds for demand in summary.demands(campaign, rows)) else NOT_MET


def run_command(args):
    campaign = load(args)
    program = simulator.find(args.motorsim)
    simulator.try_out(program, campaign)
    wanted = range(min(args.runs or campaign.runs, campaign.runs))
    head = results.head_of(campaign, simulator.fingerprint(program, campaign))
    with results.Store(folder_of(args, campaign), head, args.fresh) as store:
        try:
            run_missing(args, campaign, program, wanted, store)
        except KeyboardInterrupt:
            print(f"campaign: stopped after {len(of_these(store, wanted))} of {len(wanted)} runs; "
                  "the same command goes on", file=sys.stderr)
            return INTERRUPTED
        rows = sorted(store.rows, key=lambda row: row["run"])
    return finish(args, campaign, rows)


def of_these(store, wanted):
    """The rows of those runs. An earlier command may have asked for more."""
    return [row for row in store.rows if row["run"] in wanted]


def run_missing(args, campaign, program, wanted, store):
    before = of_these(store, wanted)
    done = {row["run"] for row in before}
    missing = [run for run in wanted if run not in done]
    if not missing:
        return
    from . import execute
    with progress.shown(Console(stderr=True), campaign.name, len(wanted), before) as add:
        execute.execute(campaign, program, missing, store, args.scheduler, args.jobs, add)


def report_command(args):
    campaign = load(args)
    folder = folder_of(args, campaign)
    head, rows = results.read(folder)
    differs = results.changed_setting(head, campaign.settings())
    if differs:
        raise CampaignError(f"{folder / results.FILE}: {differs}; expected the campaign that it is "
                            "of")
    if not rows:
        raise CampaignError(f"{folder / results.FILE}: holds no runs; expected at least one")
    return finish(args, campaign, rows)


def rerun_command(args):
    campaign = load(args)
    if args.run >= campaign.runs:
        raise CampaignError(f"--run {args.run}: {campaign.path} has fewer; allowed: 0 to "
                            f"{campaign.runs - 1}")
    extra = [word for name in ("trace", "json") if (path := getattr(args, name)) is not None
             for word in (f"--{name}", path)]
    command = simulator.find(args.motorsim).rerun(campaign, args.run, extra)
    print(simulator.as_shell(command), file=sys.stderr, flush=True)
    return subprocess.run(command, check=False).returncode


def list_command(_):
    for name in campaigns.names():
        campaign = campaigns.load(name)
        print(f"{name:<12} {campaign.runs:>6} runs  {campaign.title}")
    return HOLDS


def add_common(parser, function):
    parser.set_defaults(function=function)
    parser.add_argument("campaign", help="name (see `tools/campaign list`) or path of a .toml")
    parser.add_argument("--seed", type=whole(0), metavar="N", help="another one than the file's")
    parser.add_argument("--classes", type=classes, metavar="A,B", help="of a zoo: these alone")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="a setting of all runs; may be repeated")
    parser.add_argument("--motorsim", type=Path, default=simulator.MOTORSIM, metavar="FILE",
                        help="the simulator (build/host/motorsim)")


def add_out(parser):
    parser.add_argument("--out", type=Path, metavar="DIR",
                        help="folder of the results (build/campaigns/NAME)")


def add_run(commands):
    parser = commands.add_parser("run", help="run a campaign, or go on with it",
                                 description=FILE_HELP, epilog=EPILOG,
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
    add_common(parser, run_command)
    add_out(parser)
    parser.add_argument("--runs", type=whole(1), metavar="N", help="only the first N (all)")
    parser.add_argument("--fresh", action="store_true", help="drop the results that are there")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--jobs", type=whole(1), metavar="N", help="so many at once (the cores)")
    where.add_argument("--scheduler", metavar="ADDRESS",
                       help="of a Dask cluster; its machines need this folder with its build, under "
                       "the same path")


def add_others(commands):
    parser = commands.add_parser("report", help="tables, files and map from the results")
    add_common(parser, report_command)
    add_out(parser)
    parser = commands.add_parser("rerun", help="one run again, exactly as it was")
    add_common(parser, rerun_command)
    parser.add_argument("--run", type=whole(0), required=True, metavar="N", help="its number")
    parser.add_argument("--trace", metavar="FILE", help="write every tick as CSV")
    parser.add_argument("--json", metavar="FILE", help="write the metrics as JSON; - is standard "
                        "output")
    commands.add_parser("list", help="the campaigns that there are").set_defaults(
        function=list_command)


def main(words=None):
    parser = user_text.Parser(prog="campaign", description=HELP, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    add_run(commands)
    add_others(commands)
    args = parser.parse_args(words)
    try:
        return args.function(args)
    except CampaignError as error:
        user_text.tell("campaign", error)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
