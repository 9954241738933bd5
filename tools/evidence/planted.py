# SPDX-License-Identifier: MIT
"""evidence.planted: faults that someone could really make, each put in alone, are found by the tests that are named.

tests/evidence/planted.toml has a row a fault. It is put into a copy of the sources; what it reaches is built anew beside
the build; each test of its row has to pass without it and to fail with it.
"""

import argparse
import os
import queue
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.progress import track

import ctested
import part
import rebuilt

REGISTER = Path("tests/evidence/planted.toml")
IN_LOOP = "target.loop."  # programs of unittest, which take its options
KEYS = {"name", "class", "file", "old", "new", "tests"}
CLASSES = ("board", "drive", "config", "gate")
LIMIT_S, LIMIT_TIMES = 20, 5  # how long a test may go on with a fault: so long, and so many times as without


@dataclass(frozen=True)
class Fault:
    name: str
    kind: str
    file: str
    old: str
    new: str
    tests: tuple


@dataclass
class Verdict:
    """`wrong`: why the row does not hold; `found`: what each test says with the fault."""

    fault: Fault
    wrong: list = field(default_factory=list)
    found: list = field(default_factory=list)


def registered(path):
    """The faults, and what is wrong with the register itself."""
    faults, bad = [], []
    for row in tomllib.loads(path.read_text(encoding="utf-8")).get("fault", []):
        name = row.get("name", "a fault without name")
        if set(row) != KEYS or row["class"] not in CLASSES or not row["tests"]:
            bad.append(f"{REGISTER}: {name}: a fault has {', '.join(sorted(KEYS))}; class is one of {', '.join(CLASSES)}")
        elif name in {fault.name for fault in faults}:
            bad.append(f"{REGISTER}: {name}: stands there twice")
        else:
            faults.append(Fault(name, row["class"], row["file"], row["old"], row["new"], tuple(row["tests"])))
    return faults, bad


def chosen(faults, only):
    """Those whose name or class is asked for."""
    return [fault for fault in faults if not only or any(word == fault.kind or word in fault.name for word in only)]


def copy_of(root, folder):
    """The project's files as git has or would have them, in a repository of their own."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root, check=True,
                            capture_output=True, text=True).stdout
    for name in filter(None, listed.split("\0")):
        source = root / name
        if source.is_file() and name != ".cache":
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(source.read_bytes())
            (folder / name).chmod(source.stat().st_mode)
    subprocess.run(["git", "init", "-q", folder], check=True)
    return folder


class Planted:
    """The fault in the copy, as long as the block runs."""

    def __init__(self, copy, fault):
        self.path, self.fault = copy / fault.file, fault

    def __enter__(self):
        self.before = self.path.read_text(encoding="utf-8") if self.path.is_file() else None
        text = self.before or ""
        if self.fault.old == "" and self.before is not None:
            raise ValueError(f"{self.fault.file}: is there already; a fault with an empty `old` is a new file")
        if self.fault.old and text.count(self.fault.old) != 1:
            raise ValueError(f"{self.fault.file}: `old` stands there {text.count(self.fault.old)} times; expected once")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        changed = text.replace(self.fault.old, self.fault.new) if self.fault.old else self.fault.new
        self.path.write_text(changed, encoding="utf-8")

    def __exit__(self, *_):
        if self.before is None:
            self.path.unlink()
        else:
            self.path.write_text(self.before, encoding="utf-8")


class Runner:
    """Runs tests in a copy of the sources, with what was built of these."""

    def __init__(self, root, build):
        self.root, self.listed, self.good = root, ctested.listed(build, whole=False), {}

    def command(self, test, copy, change, folder):
        """The test's command and folder with the change in all that it runs and reads; None if it does neither."""
        words, reached = [], False
        for word in test.command:
            path = Path(word)
            made = change.output(path) if change and path.is_absolute() else None
            words.append(str(made) if made else rebuilt.copied(word, self.root, copy))
            reached = reached or words[-1] != word
        for at, word in enumerate(words[:-1]):
            if word == "--out":  # what others read
                words[at + 1] = str(folder / "out")
        place = rebuilt.copied(str(test.folder), self.root, copy)
        return words, place, reached or place != str(test.folder)

    def run(self, test, copy, words, place, limit=None):
        """What it says last and whether it passes; `limit`: seconds after which it does not."""
        environment = {**os.environ, rebuilt.DATA: str(copy / "host_sim"),
                       **{name: rebuilt.copied(value, self.root, copy) for name, value in test.environment.items()}}
        try:
            run = subprocess.run(words, cwd=place, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 stdin=subprocess.DEVNULL, text=True, errors="replace", timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            return False, f"not at its end after {limit:.0f} s"
        return test.passes(run.returncode, run.stdout), first_finding(run.stdout, run.returncode)

    def without(self, test, copy, folder):
        """Seconds that it takes without a fault, None if it does not pass."""
        if test.title not in self.good:
            words, place, _ = self.command(test, copy, None, folder)
            began = time.monotonic()
            passed, _ = self.run(test, copy, words, place)
            self.good[test.title] = time.monotonic() - began if passed else None
        return self.good[test.title]

    def judge(self, fault, copy, folder):
        verdict = Verdict(fault)
        tests = []
        for title in fault.tests:
            name, *arguments = title.split(" ")
            if name in self.listed:
                tests.append(self.listed[name].with_arguments(title, arguments))
            else:
                verdict.wrong.append(f"ctest runs no test {name}, or it is not built")
        seconds = {test.title: self.without(test, copy, folder) for test in tests}
        try:
            with Planted(copy, fault):
                change = rebuilt.Rebuilt(self.root, copy, fault.file, folder)
                for test in tests:
                    self.judge_test(verdict, test, copy, change, seconds[test.title])
        except ValueError as error:
            verdict.wrong.append(str(error))
        except rebuilt.CannotBuild as error:
            verdict.wrong.append(f"cannot be built with it: {error}")
        return verdict

    def judge_test(self, verdict, test, copy, change, seconds):
        if seconds is None:
            verdict.wrong.append(f"{test.title} fails without the fault too")
            return
        words, place, reached = self.command(test, copy, change, change.folder)
        if not reached:
            verdict.wrong.append(f"{test.title} runs nothing of {verdict.fault.file}")
            return
        if test.title.startswith(IN_LOOP):
            words.append("--failfast")
        passed, said = self.run(test, copy, words, place, LIMIT_S + LIMIT_TIMES * seconds)
        if passed:
            verdict.wrong.append(f"{test.title} passes with the fault in")
        else:
            verdict.found.append(f"{test.title}: {said}")


FAILED = re.compile(r":(\w+):FAIL|^(?:FAIL|ERROR): (\w+)", re.MULTILINE)


def first_finding(said, status):
    """The first test of a program that fails; of another one its last line."""
    failed = FAILED.search(said)
    if failed:
        return failed[1] or failed[2]
    lines = [line for line in said.splitlines() if line.strip()]
    return re.sub(r"\S*/tmp/\S*?/", "", lines[-1]) if lines else f"ended with {status}"


def judged(runner, faults, root, jobs):
    """All faults, each worker in a copy of its own."""
    console = Console(stderr=True)
    with tempfile.TemporaryDirectory(prefix="planted.") as folder:
        copies = queue.SimpleQueue()
        for number in range(jobs):
            copies.put(copy_of(root, Path(folder) / f"copy{number}"))

        def one(numbered):
            number, fault = numbered
            copy = copies.get()
            try:
                return runner.judge(fault, copy, Path(folder) / f"built{number}")
            finally:
                copies.put(copy)

        with ThreadPoolExecutor(jobs) as pool:
            return list(track(pool.map(one, enumerate(faults)), total=len(faults), description="planting faults",
                              console=console, disable=not console.is_terminal, transient=True))


def findings(verdicts):
    return [f"{REGISTER}: {verdict.fault.name}: {wrong}" for verdict in verdicts for wrong in verdict.wrong]


def result(verdicts, bad):
    """Figures and tables."""
    found = sum(not verdict.wrong for verdict in verdicts)
    rows = [[verdict.fault.name, verdict.fault.kind, verdict.fault.file, "\n".join(verdict.found or verdict.wrong)]
            for verdict in verdicts]
    return ([part.figure("planted faults found by the tests that are named", f"{found} of {len(verdicts)}", "all",
                         0 < found == len(verdicts)),
             part.figure("rows that are wrong", len(bad), 0, not bad)],
            [part.table("Planted faults", ["Fault", "Class", "File", "Found by"], rows)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=part.ROOT / "build/host", help="folder of the CMake build")
    parser.add_argument("--only", action="append", metavar="TEXT", help="only faults of this class, or with TEXT in their name")
    parser.add_argument("--jobs", type=int, default=2, help="faults at a time")
    args = part.arguments(parser)
    faults, bad = registered(part.ROOT / REGISTER)
    verdicts = judged(Runner(part.ROOT, args.build.resolve()), chosen(faults, args.only), part.ROOT, args.jobs)
    return part.end(args.out, "planted", "Planted faults",
                    "Faults that someone could make, in drive, board, configuration and gates: each is put in alone, and the "
                    "tests named beside it, which pass without it, fail.",
                    *result(verdicts, bad), [*bad, *findings(verdicts)])


if __name__ == "__main__":
    sys.exit(main())
