# SPDX-License-Identifier: MIT
"""Every table and figure of the repository that is generated: compared with what it is made of, or written anew.

  tools/dev figures                      builds what it needs, says which is not what it is made of
  tools/dev figures --write              writes these anew
  tools/dev figures expected faults      of these alone; also with --write
  tools/dev figures --with comparison    all, and a dear one
  tools/dev figures --list               which there are, where they stand, and what each costs

After a change of the firmware: tools/dev figures --write; read git diff; say in the commit why the figures have moved. What
a test holds within a margin stays as it is while it is within. None of these figures is typed in.

A new one: a program prints the table, or a script of tools/docs makes it (generated.py helps); the page has `<!-- NAME -->`
and `<!-- end -->` where it is to stand; and there is a row in tools/docs/figures.py.

Exit status: 0 all are what they are made of, or are written; 1 one is not; 2 an argument is wrong, or a build fails.
"""
import argparse
import subprocess
import sys
import time
from dataclasses import dataclass

from generated import ROOT

PYTHON = (sys.executable, "-B")
HOST = "build/host"
COST = f"{HOST}/evidence/cost.json"
CORES = ("cortex-m0plus", "cortex-m3", "cortex-m4")


@dataclass(frozen=True)
class Figure:
    """A row of the list below. Commands run in the project's folder; one that fails says in its first line what differs."""

    name: str
    where: str
    core_seconds: float
    check: tuple
    write: tuple = ()  # the check with --write, unless it is another one
    host: tuple = ()   # targets of the preset host
    images: tuple = ()  # presets of targets
    of: str = ""        # the figure that leaves what this one is made of
    dear: bool = False  # only where it is asked for

    def command(self, write):
        return list(self.check if not write else self.write or (*self.check, "--write"))


def script(name, *words):
    return (*PYTHON, f"tools/docs/{name}.py", *words)


def printed(page, *tables, by):
    """Tables that a program prints. The option first: what follows -- is the program's."""
    words = (page, *tables, "--", *by)
    return {"where": page, "check": script("printed", *words), "write": script("printed", "--write", *words)}


BENCH = (*PYTHON, "tools/bench_target.py", "--json", COST)
FIGURES = (
    Figure("equations", "docs/equations.md", 2, script("equations")),
    Figure("hal", "docs/configuration.md", 1, script("hal_keys", f"{HOST}/nfconfig"), host=("nfconfig",)),
    Figure("image", "docs/board_bring_up.md", 2, script("image_size"), images=("stm32g4",)),
    Figure("budget", "tools/bench/budget.toml", 80, (*BENCH, "--check"), (*BENCH, "--write-budget"), host=("record",),
           images=CORES),
    Figure("cost", "docs/cost.md", 1, script("tick_cost", COST), of="budget"),
    Figure("expected", "tests/scenario/expected.toml, docs/results.md, docs/voltage_drive.md", 17,
           script("expected", f"{HOST}/motorsim", f"{HOST}/tests/scenario/results/runs.txt"), host=("motorsim",)),
    Figure("faults", core_seconds=8, host=("test_fault_table",),
           **printed("docs/protection.md", "faults", "faults of an angle sensor",
                     by=(f"{HOST}/tests/scenario/test_fault_table", "--measure"))),
    Figure("single_faults", core_seconds=2, host=("test_single_faults",),
           **printed("docs/protection.md", "single faults", by=(f"{HOST}/tests/scenario/test_single_faults", "--measure"))),
    Figure("dead_time", "docs/design.md", 6, script("dead_time", f"{HOST}/motorsim"), host=("motorsim",)),
    Figure("stream", core_seconds=1, host=("stream_size",),
           **printed("docs/live.md", "stream", by=(f"{HOST}/tests/live/stream_size",))),
    Figure("lines", core_seconds=4, host=("line_shares",),
           **printed("docs/live.md", "slow lines", "bad lines", by=(f"{HOST}/tests/live/line_shares",))),
    Figure("transcripts", "README.md, docs/*.md", 6, script("transcripts", HOST, "gdb"),
           host=("motorsim", "nfconfig", "gaindesign")),
    Figure("comparison", "docs/comparison.md", 1200, (*PYTHON, "tools/compare", "page"), host=("motorsim",), dear=True),
    Figure("identification", "docs/identification.md", 1200, (*PYTHON, "tools/measure_zoo", "--check"),
           (*PYTHON, "tools/measure_zoo", "--write"), host=("motorsim", "nfconfig"), dear=True),
)


def say(text):
    print(f"== figures: {text}", flush=True)


def run(command):
    """Exit status, and the lines that it says; progress, which goes to stderr, last."""
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=False)
    return done.returncode, f"{done.stdout}{done.stderr}".strip().splitlines()


def build(chosen):
    """What the figures are made of: programs of the host first, as images need nfconfig."""
    images = sorted({image for figure in chosen for image in figure.images})
    targets = sorted({target for figure in chosen for target in figure.host} | ({"nfconfig"} if images else set()))
    commands = [["cmake", "--preset", "host"]]
    commands += [["cmake", "--build", "--preset", "host", "--target", *targets]] if targets else []
    commands += [["tools/gates/preset", image, "build", f"-DNF_NFCONFIG={ROOT / HOST}/nfconfig"] for image in images]
    for command in commands:
        say(" ".join(command[:4]))
        status, said = run(command)
        if status:
            print(*said, f"tools/dev figures: failed: {' '.join(command)}", sep="\n", file=sys.stderr)
            return 2
    return 0


def make(figures, write):
    """Checks or writes each. The names of those that are stale, or could not be written."""
    stale = []
    for figure in figures:
        say(f"{figure.name}, {figure.where} (some {figure.core_seconds:g} core-seconds)")
        begun = time.monotonic()
        status, said = run(figure.command(False))
        if status and write:
            say(f"{figure.name} is written anew")
            status, said = run(figure.command(True))
        if status:
            stale.append(figure.name)
            print(f"stale: {figure.name}: {said[0] if said else f'exit status {status}'}", flush=True)
        else:
            say(f"{figure.name} holds, {time.monotonic() - begun:.0f} s")
    return stale


def listing():
    return "\n".join(f"{figure.name:15} {figure.core_seconds:5g} core-s  {figure.where}{'; --with' if figure.dear else ''}"
                     for figure in FIGURES)


def chosen_of(names):
    """In the order of the list, and what they are made of."""
    wanted = set(names) | {figure.of for figure in FIGURES if figure.name in names}
    return [figure for figure in FIGURES if figure.name in wanted]


def main(words=None):
    usual, dear = ([figure.name for figure in FIGURES if figure.dear == is_dear] for is_dear in (False, True))
    parser = argparse.ArgumentParser(prog="tools/dev figures", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"instead of all of {', '.join(usual)}")
    parser.add_argument("--with", dest="dear", action="append", choices=dear, default=[],
                        help="these and a dear one; may be repeated")
    parser.add_argument("--write", action="store_true", help="write anew what is not what it is made of")
    parser.add_argument("--list", action="store_true", help="say which there are")
    parser.add_argument("--judge", action="store_true", help=argparse.SUPPRESS)  # the words alone: do nothing
    args = parser.parse_args(words)
    for name in args.names:
        if name not in usual + dear:
            print(f"tools/dev figures: found '{name}'; allowed: {', '.join(usual + dear)}", file=sys.stderr)
            return 2
    if args.list:
        print(listing())
        return 0
    if args.judge:
        return 0
    chosen = chosen_of((args.names or usual) + args.dear)
    begun = time.monotonic()
    status = build(chosen)
    if status:
        return status
    stale = make(chosen, args.write)
    took = f"{time.monotonic() - begun:.0f} s"
    if not stale:
        say(f"all {len(chosen)} are what they are made of; {took}")
        return 0
    renew = "could not be written" if args.write else f"to renew: tools/dev figures --write {' '.join(stale)}"
    say(f"{len(stale)} of {len(chosen)} stale: {', '.join(stale)}; {renew}")
    return 1


if __name__ == "__main__":
    sys.exit(main())
