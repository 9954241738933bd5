# SPDX-License-Identifier: MIT
"""The command line of the comparison."""

import argparse
import contextlib
import sys
from pathlib import Path

import user_text
from docs import generated
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from robustness.arguments import whole
from robustness.campaign import CampaignError

from . import runs, search, table

DONE, BAD_INPUT, INTERRUPTED = 0, 2, 130
PAGE = "docs/comparison.md"

HELP = """The drive's observer beside estimators of the literature. Each estimates in its place, all else is the drive:
start-up, measured R and L, dead-time compensation, loops and ramps (host_sim/peers/).

  tools/compare table                        S1 to S3 with each set, the worst of five seeds
  tools/compare table --with deadtime --scenario s1_robust --seeds 1
  tools/compare table --estimator kalman --estimator ./mine.toml
  tools/compare zoo --motors 50              motors of the zoo, as their files say and as users have them
  tools/compare page --write                 all tables of docs/comparison.md anew
  tools/compare tune kalman                  searches gains for S1 to S3, writes host_sim/peers/kalman.toml
  tools/compare tune all --goal zoo          then for the zoo, minutes for each estimator: host_sim/peers/kalman_zoo.toml
  build/host/motorsim run s1_robust --with imp --estimator kalman --trace x.csv
                                             one of these runs, every tick of it

A cell of S1 to S3 is the largest speed error in % of rated speed and the largest angle error in electrical degrees, transients
included. Of the zoo the shares of motors are shown that are locked, that swing, that end in a fault and that are lost without one,
and the median of the largest speed errors of the motors that all estimators of the table lock.
"""


@contextlib.contextmanager
def progress(name, total):
    """A function to call after each of so many steps."""
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=total)
        yield lambda: bar.advance(task)


def known(args):
    """The estimators of the simulator with their gains."""
    return runs.asked(args.motorsim, ["estimators"])


def rows_of(args, suffix=""):
    """All estimators with the gains of a goal, and the drive's own; or those that are asked for."""
    return getattr(args, "estimator", None) or [*(name + suffix for name in known(args)), None]


def show(title, heads, rows):
    shown = Table(*heads, title=title, title_justify="left")
    for row in rows:
        shown.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 132).print(shown)


def zoo(args, variant, count):
    estimators = rows_of(args, table.ZOO_GAINS)
    with progress(variant, count * len(estimators)) as told:
        return table.zoo_table(estimators, table.zoo_outcomes(args.motorsim, estimators, variant, count, told))


def table_command(args):
    for scenario in args.scenario or table.SCENARIOS:
        sets = args.sets or table.SETS
        show(scenario, table.heads(sets), table.rows(args.motorsim, rows_of(args), scenario, sets, args.seeds))
    return DONE


def zoo_command(args):
    for variant in table.VARIANTS:
        show(variant, *zoo(args, variant, args.motors))
    return DONE


def page_command(args):
    made = {scenario: generated.table(table.heads(table.SETS), table.rows(args.motorsim, rows_of(args), scenario))
            for scenario in table.SCENARIOS}
    made |= {variant: generated.table(*zoo(args, variant, table.MOTORS)) for variant in table.VARIANTS}
    generated.finish(PAGE, made, "the comparison", args.write)
    return DONE


def tune_command(args):
    peers = known(args)
    names = list(peers) if args.estimator == "all" else [args.estimator]
    if names[0] not in peers:
        raise runs.CompareError(f"{args.estimator}: no estimator; allowed: {', '.join(peers)}, all")
    evaluations = args.evaluations or search.GOALS[args.goal].evaluations
    for name in names:
        with progress(name, evaluations) as told:
            path, cost = search.tune(args.motorsim, name, peers[name]["gain"], args.goal, evaluations, args.seed, args.out, told)
        print(f"{path}: cost {cost:.3g}", flush=True)
    return DONE


def add(commands, name, function, text):
    parser = commands.add_parser(name, help=text)
    parser.set_defaults(function=function)
    parser.add_argument("--motorsim", type=Path, default=runs.MOTORSIM, metavar="FILE",
                        help="the simulator (build/host/motorsim)")
    return parser


def add_estimator(parser):
    parser.add_argument("--estimator", action="append", metavar="NAME", help="instead of all: a name or a file of gains")


def parsed(words):
    parser = user_text.Parser(prog="compare", description=HELP,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    shown = add(commands, "table", table_command, "run and show S1 to S3")
    shown.add_argument("--scenario", action="append", metavar="NAME", help=f"instead of {', '.join(table.SCENARIOS)}")
    shown.add_argument("--with", dest="sets", action="append", metavar="SET", help=f"instead of {', '.join(table.SETS)}")
    shown.add_argument("--seeds", type=whole(1), default=table.SEEDS, metavar="N", help=f"of the noise ({table.SEEDS})")
    add_estimator(shown)
    motors = add(commands, "zoo", zoo_command, "run and show motors of the zoo")
    motors.add_argument("--motors", type=whole(1), default=table.MOTORS, metavar="N", help=f"how many ({table.MOTORS})")
    add_estimator(motors)
    page = add(commands, "page", page_command, f"compare the tables of {PAGE} with what is measured now")
    page.add_argument("--write", action="store_true", help="write the tables anew")
    tune = add(commands, "tune", tune_command, "search for gains and write their file")
    tune.add_argument("estimator", help="a name of `motorsim estimators`, or all")
    tune.add_argument("--goal", choices=search.GOALS, default="scenarios", help="what the gains are for (scenarios)")
    tune.add_argument("--evaluations", type=whole(3), metavar="N",
                      help=f"trials ({', '.join(f'{name}: {goal.evaluations}' for name, goal in search.GOALS.items())})")
    tune.add_argument("--seed", type=whole(0), default=search.SEED, metavar="N", help=f"of the trials ({search.SEED})")
    tune.add_argument("--out", type=Path, default=runs.PEERS, metavar="DIR", help="folder of the file (host_sim/peers)")
    return parser.parse_args(words)


def main(words=None):
    try:
        args = parsed(words)
        return args.function(args)
    except (runs.CompareError, CampaignError, OSError) as error:
        user_text.tell("compare", error)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
