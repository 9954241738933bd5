# SPDX-License-Identifier: MIT
"""evidence.fuzz: whatever bytes come in, nothing breaks.

The programs of tests/fuzz run under libFuzzer with the address and the undefined-behaviour sanitizer, beginning with their
committed corpus: frames into the drive, text into the configuration's loader, recordings, the console, the line of the link,
blocks of configuration, packed frames, commands of the stepper. What each asks for beyond that stands in its source. A crash, an alarm, a broken promise, an input that takes
ten seconds or a GB of memory is a finding; its input is kept, and the line that runs it again is printed. Each run begins
with the committed corpus alone: what the one before has kept in build/fuzz goes away.

Each program runs at least three times as long as its planted faults (tests/evidence/fuzz_can_fail.py) took when this was
measured: that of the configuration 5.3 to 13.8 s of a core, before an input that shows it came into the corpus, and that of the
recording 0.3 to 0.7 s, of four seeds each; those of the drive, the stepper and the console at most 0.6 s with the one seed
tried, as they are found while the corpus is read. The others have no planted fault: what they call is watched by the same
sanitizers.
The build has changed since: C without calls at comparisons, and counters. The test still asks for each fault within the
program's time. --seconds gives all of them another time.

A program that ends early, invents next to nothing or stays near its beginning has shown nothing: the whole time, a rate of
inputs and a number of edges of the code are asked for as well.
"""

import argparse
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import part
from part import ROOT

FOLDER = ROOT / "build/host-asan"
ARCHIVE = ROOT / "tests/fuzz/corpus.tar.xz"
CORPUS = FOLDER / "tests/fuzz/corpus"  # the same, as the build has unpacked it
KEPT = ROOT / "build/fuzz"


@dataclass(frozen=True)
class Program:
    """What it gets; the edges that it reaches at least, nine tenths of those of its corpus; the inputs that it invents
    a second, a tenth of what a busy PC does; how many seconds it runs."""

    gets: str
    edges: int
    rate: int
    seconds: int = 8


PROGRAMS = {
    "drive": Program("any frames, from every state of shipped motors", 800, 100),
    "config": Program("any motor, board, tuning, scenario, imperfection file", 4400, 15, 42),
    "recording": Program("any recording, read and run again", 4300, 30),
    "console": Program("any bytes to the console", 1020, 60),
    "stepper": Program("any commands of the stepper", 2400, 5),
    "link": Program("any bytes to the serial line, of a PC that is connected", 1600, 10),
    "block": Program("any block of configuration words", 295, 500),
    "frame_code": Program("any bytes as a packed frame", 135, 5000),
}
AT_ONCE = 2
SEED = 1
LENGTH_MAX = 4096  # bytes of an input
LIMITS = ["-timeout=10", "-rss_limit_mb=1024"]
SAID = re.compile(r"(runtime error|ERROR: |does not hold|outside)")
STATUS = re.compile(r"cov: (\d+) ft: (\d+) corp: (\d+)")
READ = re.compile(r"^#(\d+)\s+INITED", re.MULTILINE)
DONE = re.compile(r"Done (\d+) runs in (\d+) second")


@dataclass
class Outcome:
    name: str
    invented: int  # inputs beyond the corpus
    seconds: int
    edges: int
    corpus: int
    why: str  # empty: nothing was found
    kept: str  # the input that did it


def inputs(archive):
    """PROGRAM/NAME → its bytes, of all that the archive has."""
    with tarfile.open(archive) as tar:
        return {member.name: tar.extractfile(member).read() for member in tar if member.isfile()}


def write(archive, found):
    """The same inputs give the same bytes: sorted, without times and owners."""
    with tarfile.open(archive, "w:xz", format=tarfile.USTAR_FORMAT) as tar:
        for name, content in sorted(found.items()):
            member = tarfile.TarInfo(name)
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))


def keep(archive, program, path):
    """Adds an input to the corpus of a program, under the name that libFuzzer gives it; the exit status."""
    found, content = inputs(archive), path.read_bytes()
    programs = sorted({name.split("/")[0] for name in found})
    if program not in programs:
        print(f"--keep: {program} has no corpus; expected one of {', '.join(programs)}")
        return 2
    found[f"{program}/{hashlib.sha1(content).hexdigest()}"] = content
    write(archive, found)
    return 0


def build():
    """The programs; the exit status of the tool that does not do it."""
    for command in (["cmake", "--preset", "host-asan", "-DNF_TEST_FOLDERS=", "-UNF_NFCONFIG"], ["cmake", "--build", "--preset", "fuzz"]):
        run = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
        if run.returncode:
            print(run.stdout, run.stderr)
            return run.returncode
    return 0


def fuzz(program, name, seconds, kept, seed=SEED):
    """Runs one program for a time, from its corpus on."""
    found = kept / name
    shutil.rmtree(found, ignore_errors=True)
    found.mkdir(parents=True)
    run = subprocess.run(
        [program, f"-max_total_time={seconds}", f"-seed={seed}", f"-max_len={LENGTH_MAX}", *LIMITS,
         f"-artifact_prefix={found}/", found, CORPUS / name],
        capture_output=True, text=True, errors="replace", check=False,
        env={**os.environ, "LLVM_PROFILE_FILE": os.devnull})  # the build counts for evidence.coverage, not here
    return outcome(name, run.returncode, run.stderr)


def outcome(name, status, said):
    """What libFuzzer said."""
    progress, read, done = STATUS.findall(said), READ.search(said), DONE.search(said)
    why = ""
    if status:
        why = next((line for line in said.splitlines() if SAID.search(line)), f"ended with {status}").strip()
    kept = re.search(r"Test unit written to (\S+)", said)
    edges, _, corpus = map(int, progress[-1]) if progress else (0, 0, 0)
    runs, seconds = map(int, done.groups()) if done else (0, 0)
    return Outcome(name, runs - int(read[1]) if read and done else 0, seconds, edges, corpus, why, kept[1] if kept else "")


def figures_of(outcomes, given=None):
    """Of each program: whether it found something, and whether it was fuzzed for its time; `given`: the seconds of --seconds."""
    for one in outcomes:
        yield part.figure(f"{one.name}: findings", one.why or "none", "none", not one.why)
        asked = PROGRAMS[one.name]
        seconds = given or asked.seconds
        least = asked.rate * seconds
        yield part.figure(f"{one.name}: fuzzed",
                          f"{one.seconds} s, {one.invented} inputs beyond the corpus, {one.edges} edges",
                          f"at least {seconds} s, {least} inputs, {asked.edges} edges",
                          one.seconds >= seconds and one.invented >= least and one.edges >= asked.edges)


def findings_of(outcomes):
    """A line for each that found something, with the command that shows it again."""
    return [f"{ARCHIVE.relative_to(ROOT)}:1: {one.name}: {one.why}; again: {FOLDER}/tests/fuzz/fuzz_{one.name} {one.kept}"
            for one in outcomes if one.why]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, help="of each program, in place of its own")
    parser.add_argument("--seed", type=int, default=SEED, help=f"of libFuzzer ({SEED})")
    parser.add_argument("--only", action="append", choices=PROGRAMS, help="this program; may be repeated")
    parser.add_argument("--keep", nargs=2, metavar=("PROGRAM", "FILE"), help="only add this file to the corpus of a program")
    args = part.arguments(parser)
    if args.keep:
        return keep(ARCHIVE, args.keep[0], Path(args.keep[1]))
    if build():
        return 1
    with ThreadPoolExecutor(max_workers=AT_ONCE) as pool:
        outcomes = list(pool.map(
            lambda name: fuzz(FOLDER / f"tests/fuzz/fuzz_{name}", name, args.seconds or PROGRAMS[name].seconds, KEPT,
                              args.seed),
            args.only or PROGRAMS))
    programs = part.table("Programs", ["program", "gets", "inputs beyond the corpus", "edges of the code reached",
                                       "inputs that reach something of their own"],
                          [[one.name, PROGRAMS[one.name].gets, one.invented, one.edges, one.corpus] for one in outcomes],
                          "How far it comes in its time depends on the machine: these numbers change from run to run.")
    return part.end(args.out, "fuzz", "Fuzzing",
                    "libFuzzer with address and undefined-behaviour sanitizer invents inputs. "
                    "After each tick of the drive its state is within the proven ranges, its compare values "
                    "within the period, and the gates are on only where they may be.",
                    list(figures_of(outcomes, args.seconds)), [programs], findings_of(outcomes))


if __name__ == "__main__":
    sys.exit(main())
