#!/usr/bin/env python3
"""What a control tick costs on a Cortex-M: instructions, modelled cycles, stack, sizes.

  tools/bench_target.py                     the tables
  tools/bench_target.py --profile           where the instructions of a RUN tick go, by function

The images hal/mps2/replay_*.elf replay runs of the simulator in an emulator, S1 to S3 with the
published tuning and nothing imperfect, and with the robust tuning and every imperfection. Each
tick's results must be those of the PC, or there is no figure.

Counted is a call of the control interrupt from its first instruction to its return: sampling
conversion, protection, state machine, observer, current loop, modulator, the decimated motion loops
and what they call of the compiler's library. In it hal_sample() and hal_apply() of a board that
reads and writes memory; the exception's entry and the reading and writing of the recording are not.
An instruction that an IT block skips counts, as it is fetched. A tick belongs to the state that it
ends in.

Exit status: 0 done, 2 an image, a file or an argument is missing or wrong.
"""

import argparse
import contextlib
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".cache" / "venv"
CORES = ("cortex-m0plus", "cortex-m3", "cortex-m4")
TUNINGS = ("published", "robust")


def needed_packages():
    """unicorn, capstone, rich; without them start again in the project's own environment."""
    try:
        import capstone  # noqa: F401
        import rich  # noqa: F401
        import unicorn  # noqa: F401
    except ImportError as error:
        python = VENV / "bin" / "python"
        if python.exists() and Path(sys.prefix) != VENV:
            os.execv(python, [str(python), *sys.argv])
        sys.exit(f"bench_target.py: {error}; expected the packages of tools/requirements.txt: "
                 "run tools/dev setup")


def progress_on(console):
    """A bar on the terminal for each replay; nothing where there is no terminal."""
    from rich.progress import Progress

    @contextlib.contextmanager
    def progress(title, total):
        with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task(title, total=total)
            yield lambda done: bar.update(task, advance=done)

    return progress


def show_profiles(console, benches, args):
    from bench.profile import profile
    from bench.tables import profile_table
    for bench in benches:
        if args.state in bench.states:
            shares = profile(bench, args.state, args.lines, args.worst)
            console.print(profile_table(bench, args.state, shares, args.top))


def one_of(names):
    """A list of names separated by commas, each out of `names`."""
    def parse(text):
        chosen = text.split(",")
        unknown = [name for name in chosen if name not in names]
        if unknown:
            raise argparse.ArgumentTypeError(
                f"'{unknown[0]}' is none of {', '.join(names)}")
        return chosen
    return parse


def arguments_of(words):
    parser = argparse.ArgumentParser(
        prog="bench_target.py", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=ROOT / "build", metavar="DIR",
                        help="builds of the presets host, cortex-m0plus ... (default: build)")
    parser.add_argument("--cores", type=one_of(CORES), default=CORES, metavar="CORE,...",
                        help=f"out of {', '.join(CORES)} (default: all)")
    parser.add_argument("--tunings", type=one_of(TUNINGS), default=TUNINGS, metavar="NAME,...",
                        help=f"out of {', '.join(TUNINGS)} (default: both)")
    parser.add_argument("--profile", action="store_true",
                        help="instructions by source function, inlined ones told apart")
    parser.add_argument("--lines", action="store_true", help="with --profile: by source line")
    parser.add_argument("--worst", action="store_true",
                        help="with --profile: sorted by the longest tick, not by the mean")
    parser.add_argument("--state", default="RUN", help="with --profile: of which ticks (RUN)")
    parser.add_argument("--top", type=int, default=25, metavar="N",
                        help="with --profile: how many (25)")
    return parser.parse_args(words)


def main(words=None):
    needed_packages()
    from rich.console import Console

    from bench.image import BenchError
    from bench.replay import measure
    args = arguments_of(words)
    console = Console()
    try:
        benches = measure(args.build, args.cores, args.tunings, progress_on(Console(stderr=True)))
        show_profiles(console, benches, args)
    except BenchError as error:
        print(f"bench_target.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
