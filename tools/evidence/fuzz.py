"""evidence.fuzz: whatever bytes come in, nothing breaks.

The programs of tests/fuzz run under libFuzzer with the address and the undefined-behaviour sanitizer, beginning with their
committed corpus: frames into the drive, text into the configuration's loader, recordings, the board's console, commands of
the stepper. What each asks for beyond that stands in its source. A crash, an alarm, a broken promise, an input that takes
ten seconds or a GB of memory is a finding; its input is kept, and the line that runs it again is printed.
"""

import argparse
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import part
from part import ROOT

FOLDER = ROOT / "build/host-fuzz"
CORPUS = ROOT / "tests/fuzz/corpus"
KEPT = ROOT / "build/fuzz"
PROGRAMS = {
    "drive": "any frames, from every state of shipped motors",
    "config": "any motor, board, tuning, scenario, imperfection file",
    "recording": "any recording, read and run again",
    "console": "any bytes to the board's console",
    "stepper": "any commands of the stepper",
}
AT_ONCE = 2
SEED = 1
LENGTH_MAX = 4096  # bytes of an input
LIMITS = ["-timeout=10", "-rss_limit_mb=1024"]
SAID = re.compile(r"(runtime error|ERROR: |does not hold|is outside)")
STATUS = re.compile(r"cov: (\d+) ft: (\d+) corp: (\d+)")
DONE = re.compile(r"Done (\d+) runs")


@dataclass
class Outcome:
    name: str
    runs: int
    edges: int
    corpus: int
    why: str  # empty: nothing was found
    kept: str  # the input that did it


def build():
    """The programs; the exit status of the tool that does not do it."""
    run = subprocess.run([ROOT / "tools/gates/preset", "host-fuzz", "build"], check=False,
                         capture_output=True, text=True)
    if run.returncode:
        print(run.stdout)
    return run.returncode


def fuzz(program, name, seconds, kept, seed=SEED):
    """Runs one program for a time."""
    found = kept / name
    found.mkdir(parents=True, exist_ok=True)
    run = subprocess.run(
        [program, f"-max_total_time={seconds}", f"-seed={seed}", f"-max_len={LENGTH_MAX}", *LIMITS,
         f"-artifact_prefix={found}/", found, CORPUS / name],
        capture_output=True, text=True, errors="replace", check=False)
    return outcome(name, run)


def outcome(name, run):
    """What libFuzzer said."""
    lines = run.stderr.splitlines()
    status = STATUS.findall(run.stderr)
    done = DONE.search(run.stderr)
    why = ""
    if run.returncode:
        why = next((line for line in lines if SAID.search(line)), f"ended with {run.returncode}").strip()
    kept = re.search(r"Test unit written to (\S+)", run.stderr)
    edges, _, corpus = map(int, status[-1]) if status else (0, 0, 0)
    return Outcome(name, int(done[1]) if done else 0, edges, corpus, why, kept[1] if kept else "")


def figures_of(outcomes):
    return [part.figure(one.name, one.why or f"{one.runs} inputs, nothing found", "nothing found",
                        not one.why and one.runs > 0) for one in outcomes]


def findings_of(outcomes):
    """A line for each that found something, with the command that shows it again."""
    return [f"tests/fuzz/corpus/{one.name}:1: {one.why}; again: {FOLDER}/tests/fuzz/fuzz_{one.name} {one.kept}"
            for one in outcomes if one.why]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=60, help="of each program (60)")
    parser.add_argument("--seed", type=int, default=SEED, help=f"of libFuzzer ({SEED})")
    parser.add_argument("--only", action="append", choices=PROGRAMS, help="this program; may be repeated")
    args = part.arguments(parser)
    if build():
        return 1
    with ThreadPoolExecutor(max_workers=AT_ONCE) as pool:
        outcomes = list(pool.map(
            lambda name: fuzz(FOLDER / f"tests/fuzz/fuzz_{name}", name, args.seconds, KEPT, args.seed),
            args.only or PROGRAMS))
    inputs = part.table("Programs", ["program", "gets", "inputs", "edges of the code reached", "inputs kept"],
                        [[one.name, PROGRAMS[one.name], one.runs, one.edges, one.corpus] for one in outcomes])
    return part.end(args.out, "fuzz", "Fuzzing",
                    f"libFuzzer with address and undefined-behaviour sanitizer invents inputs, {args.seconds} s for each "
                    "program. After each tick of the drive its state is within the proven ranges, its compare values "
                    "within the period, and the gates are on only where they may be.",
                    figures_of(outcomes), [inputs], findings_of(outcomes))


if __name__ == "__main__":
    sys.exit(main())
