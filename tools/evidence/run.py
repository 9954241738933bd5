# SPDX-License-Identifier: MIT
"""tools/dev evidence: how far the whole can be relied on, part by part; tools/evidence/parts.toml lists the parts.

A part is due until it has passed with what its inputs contain now. So a run that was stopped goes on where it was, and
what has not changed is left out. What counts is content, not time.
"""

import argparse
import fnmatch
import functools
import hashlib
import json
import os
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import ctest_run
import ctested
import page
import part

ROOT = part.ROOT
BUILD = ROOT / "build/host"
OUT = BUILD / "evidence"
STATE = OUT / "state.json"
PAGE = ROOT / "build/report/evidence.html"
PARTS = Path(__file__).with_name("parts.toml")
PACKAGES = ROOT / "tools/setup/packages.txt"
CORES = 2
SHOWN = 20
STOPPED = 130  # as a shell's


@functools.cache
def installed():
    """The versions of the tools, of which each figure is one as well."""
    names = [line.split()[0] for line in PACKAGES.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    asked = ["dpkg-query", "-W", "-f", "${Package} ${Version}\n", *names]
    return subprocess.run(asked, capture_output=True, check=False).stdout


@dataclass
class Part:
    """What parts.toml says of a part, and with `tests` of ctest the tests that its patterns name."""

    name: str
    says: str
    patterns: list
    inputs: list  # files and folders of the project
    core_minutes: float  # while nothing better is known
    figures: bool = False  # it writes NAME.json for the page
    programs: list = field(default_factory=list)  # that no other part needs
    tests: list = field(default_factory=list)

    def output(self):
        return OUT / f"{self.name}.json"

    def digest(self):
        """Of its inputs, those that git ignores left out, of the tools, and of what the part is."""
        listed = subprocess.run(["git", "ls-files", "-z", "-c", "-o", "--exclude-standard", "--", *self.inputs], cwd=ROOT,
                                capture_output=True, check=True).stdout.split(b"\0")
        digest = hashlib.sha256(repr((self.patterns, self.inputs)).encode() + installed())
        for path in sorted(filter(None, set(listed))):
            whole = ROOT / os.fsdecode(path)
            if whole.is_file():
                digest.update(path + b"\0" + hashlib.sha256(whole.read_bytes()).digest())
        return digest.hexdigest()


def parts_of(text):
    content = tomllib.loads(text)
    sets = content["inputs"]
    return [Part(**{**row, "inputs": [path for name in row["inputs"] for path in sets.get(name, [name])]})
            for row in content["part"]]


class State:
    """What is known of earlier runs: of each part the digest with which it passed, and the core-seconds of its tests."""

    def __init__(self, path=STATE):
        self.path = path
        try:
            self.known = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self.known = {"passed": {}, "core_seconds": {}}

    def keep(self):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        new = self.path.with_suffix(".new")
        new.write_text(json.dumps(self.known, indent=1) + "\n", encoding="utf-8")
        new.replace(self.path)  # a stop between two bytes leaves the old one whole

    def is_due(self, part_):
        return (self.known["passed"].get(part_.name) != part_.digest()
                or (part_.figures and not part_.output().is_file()))

    def core_minutes(self, part_):
        known = self.known["core_seconds"].get(part_.name)
        return sum(known.values()) / 60 if known else part_.core_minutes


def assign(parts, tests):
    """Gives each part its tests; says what is wrong: a test of the evidence belongs to one part."""
    for name, test in tests.items():
        if "evidence" in test.labels:
            of = [one for one in parts if any(fnmatch.fnmatchcase(name, pattern) for pattern in one.patterns)]
            if len(of) != 1:
                yield f"{PARTS.name}: {name} belongs to {len(of)} parts; expected one"
            for one in of[:1]:
                one.tests.append(name)
    for one in parts:
        for pattern in one.patterns:
            if not fnmatch.filter(one.tests, pattern):
                yield f"{PARTS.name}: {one.name}: no test of the label evidence matches {pattern}"


def minutes(seconds):
    return f"{seconds // 60:.0f} min {seconds % 60:02.0f} s"


class Progress:
    """Of a run: which tests are to come, which parts have ended how."""

    def __init__(self, due, state, digests):
        self.state, self.digests = state, digests
        self.left = {test: one for one in due for test in one.tests}
        self.took = {one.name: {} for one in due}
        self.failed, self.begin = {}, time.monotonic()
        self.needed = []  # tests of no part that failed: what a part needs

    def note(self, test):
        one = self.left.pop(test.name, None)
        if one is None:
            self.needed += [] if test.passed else [test.name]
            return
        self.took[one.name][test.name] = round(test.core_seconds, 1)
        if not test.passed:
            self.failed.setdefault(one.name, []).append(test.name)
            self.state.known["passed"].pop(one.name, None)  # it may have passed before
        if one not in self.left.values():
            self.state.known["core_seconds"][one.name] = self.took[one.name]
            if one.name not in self.failed:
                self.state.known["passed"][one.name] = self.digests[one.name]
            self.say(one)
        self.state.keep()

    def say(self, one):
        parts_left = {other.name: other for other in self.left.values()}
        rest = sum(self.state.core_minutes(other) for other in parts_left.values()) / CORES
        how = "FAILED" if one.name in self.failed else "passed"
        print(f"== evidence: {minutes(time.monotonic() - self.begin)}: {one.name} {how}; "
              f"{len(parts_left)} parts to come, some {rest:.0f} min", flush=True)


def make(due, parts, state, tests, digests):
    """Runs the tests of the parts that are due, and of what they need all but parts that have passed."""
    others = sorted(fixture for one in parts if one not in due and not state.is_due(one)
                    for test in one.tests for fixture in tests[test].sets_up)
    wanted = "^(" + "|".join(test.replace(".", "[.]") for one in due for test in one.tests) + ")$"
    run = ctest_run.Run(BUILD, [f"-j{CORES}", "--output-on-failure", "--no-tests=error", "-R", wanted,
                                *(["-FA", "^(" + "|".join(others) + ")$"] if others else [])],
                        {name: test.command for name, test in tests.items() if "evidence" in test.labels or test.sets_up})
    progress = Progress(due, state, digests)
    for test in run:
        progress.note(test)
    for test, one in progress.left.items():
        progress.failed.setdefault(one.name, []).append(f"{test} did not run")
    return progress


def summary(parts, due, progress, state):
    """The page's first part: what was made, left out, and failed."""
    failed = progress.failed
    took = state.known["core_seconds"]
    rows = [[one.name, one.says, "failed: " + ", ".join(failed[one.name]) if one.name in failed
             else "not made" if state.is_due(one) else "passed" if one in due else "unchanged since it passed",
             f"{sum(took.get(one.name, {}).values()) / 60:.1f}"] for one in parts]
    rows += [["what they need", name, "failed", ""] for name in progress.needed]
    seconds = sorted((pair for tests in took.values() for pair in tests.items()), key=lambda pair: -pair[1])[:SHOWN]
    held = [one for one in parts if not state.is_due(one)]
    return {"part": "run", "title": "All parts", "says": f"Of {commit()}.",
            "figures": [part.figure("parts that hold", f"{len(held)} of {len(parts)}", "all", len(held) == len(parts))],
            "tables": [part.table("Parts", ["part", "what", "result", "core-minutes"], rows),
                       part.table("The dearest tests", ["test", "core-seconds"], seconds)]}


def commit():
    def git(*words):
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()

    return git("rev-parse", "--short", "HEAD") + (" with changes that are not committed" if git("status", "--porcelain") else "")


def listing(names):
    return f" ({', '.join(names)})" if names else ""


def show(parts, state):
    for one in parts:
        print(f"{'due' if state.is_due(one) else 'passed':7} {state.core_minutes(one):6.1f}  {one.name:13} {one.says}")


def main():
    parser = argparse.ArgumentParser(prog="tools/dev evidence", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="these alone; --list names them")
    parser.add_argument("--list", action="store_true", help="say what is due and how many core-minutes it takes")
    parser.add_argument("--again", action="store_true", help="what has passed, too")
    parser.add_argument("--judge", action="store_true", help=argparse.SUPPRESS)  # the words alone: do nothing
    args = parser.parse_args()
    parts, state = parts_of(PARTS.read_text(encoding="utf-8")), State()
    unknown = sorted(set(args.parts) - {one.name for one in parts})
    if unknown:
        print(f"tools/dev evidence: found '{unknown[0]}'; allowed: {', '.join(one.name for one in parts)}", file=sys.stderr)
        return 2
    if args.list:
        show(parts, state)
        return 0
    if args.judge:
        return 0
    due = [one for one in parts if (not args.parts or one.name in args.parts) and (args.again or state.is_due(one))]
    try:
        return finish(parts, due, state)
    except KeyboardInterrupt:
        held = sum(not state.is_due(one) for one in parts)
        print(f"\nevidence: stopped; {held} of {len(parts)} parts hold; called again, it goes on")
        return STOPPED


def set_up(due):
    """Installs the programs that only these parts need. A part whose program cannot be had says so itself."""
    programs = sorted({program for one in due for program in one.programs})
    if programs:
        subprocess.run([ROOT / "tools/setup/apt", *programs], check=False)


def finish(parts, due, state):
    progress = Progress([], state, {})
    if due:
        set_up(due)
        digests = {one.name: one.digest() for one in due}  # before the build: what is edited from here on is due again
        built = subprocess.run([ROOT / "tools/dev", "build", "host"], check=False).returncode
        if built:
            return built
        tests = ctested.listed(BUILD, whole=False)
        wrong = list(assign(parts, tests))
        if wrong:
            sys.exit("\n".join(wrong))
        expected = sum(state.core_minutes(one) for one in due)
        print(f"== evidence: {len(due)} of {len(parts)} parts are due: {', '.join(one.name for one in due)}\n"
              f"== evidence: some {expected / CORES:.0f} min on {CORES} cores; stopped and called again, it goes on", flush=True)
        progress = make(due, parts, state, tests, digests)
    with_figures = [page.read(OUT, one.name) for one in parts if one.figures]
    whole = [summary(parts, due, progress, state), *with_figures]
    PAGE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page.page(whole), encoding="utf-8")
    missing = [one.name for one in parts if state.is_due(one) and one.name not in progress.failed]
    failures, needed = sorted(progress.failed), progress.needed
    print(f"evidence: {commit()}: {len(parts)} parts, {len(parts) - len(missing) - len(failures)} hold, "
          f"{len(failures)} failed{listing(failures)}, {len(missing)} not made{listing(missing)}"
          f"{'; what they need failed' if needed else ''}{listing(needed)}: {PAGE.relative_to(ROOT)}")
    return 1 if failures or needed else 0


if __name__ == "__main__":
    sys.exit(main())
