# SPDX-License-Identifier: MIT
"""evidence.mutation: the tests find nearly every small fault in what the drive computes.

Each mutant (mutants.py) of a file is compiled as the build compiles the file and put into the tests of its area; it is
killed when one of them fails, crashes or does not end. A mutant that the compiler refuses, that gives the object code of
the original or of an earlier mutant is none. What survives is tested once more with each shift checked: one by too many
bits is undefined, and what the PC makes of it another core does not.

Of control and math all mutants are made, and what survives has to stand in the register (survivors.toml) with its reason.
Of the other areas a sample is drawn by a fixed seed, the same mutants as long as their lines are, and a share is asked
for; the register holds those that change nothing. A registered mutant that is killed or is no longer there is a finding.
A sample says something of the tests only if none was written against it: whoever looks at its survivors to write tests
moves `looked_at` behind it, with what it came to before as the new `killed`.
"""

import argparse
import functools
import hashlib
import json
import math
import os
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import track

import mutants
import part

REGISTER = part.ROOT / "tests/evidence/survivors.toml"
KEYS = {"file", "function", "kind", "reason", "line", "mutants"}
TESTED_WITH = {"fx_plain": "fx", "fx_port": "fx", "fx_shift": "fx", "trig_table": "trig"}  # headers without own test
WRAPPING = "-fwrapv"  # an overflow that a mutant brings is that, and not whatever the optimiser makes of it
SHIFTS_CHECKED = ("-fsanitize=shift-exponent", "-fsanitize-undefined-trap-on-error")
SEED = "neurofoc"  # of the samples
FAILED = re.compile(r".*?:\d+:(\w+):FAIL")
KINDS = EQUIVALENT, HARMLESS = "equivalent", "harmless"


def module_of(path):
    stem = Path(path).stem
    return TESTED_WITH.get(stem, stem)


@dataclass(frozen=True)
class Area:
    """Files with tests in common.

    `killed`: so many of how many mutants are to be killed. Of a sample it is what was measured of it and of those drawn before,
    each before a test was written against it; the least is two standard deviations of a sample of that size below, which one
    in forty falls short of by chance alone.
    """

    name: str
    sources: tuple  # patterns
    folders: tuple  # of what they include
    killed: tuple
    tests: tuple = ()  # beside those of the module itself
    sample: int = 0  # mutants; 0: all
    looked_at: int = 0  # so many of the draw before the sample, when tests were written
    left_out: tuple = ()

    def paths(self, root):
        found = {str(path.relative_to(root)) for pattern in self.sources for path in root.glob(pattern)}
        return sorted(found - set(self.left_out))

    def mutants(self, root, only=None):
        """Those of its files, and those of these that are drawn."""
        paths = [path for path in self.paths(root) if not only or any(text in path for text in only)]
        made = [mutant for path in paths for mutant in mutants.mutants(root, path, self.folders)]
        if self.sample:
            return made, set(sorted(made, key=drawn)[self.looked_at:self.looked_at + self.sample])
        return made, set(made)

    def least(self, count):
        """The least share killed of so many mutants, in per cent."""
        of_all = self.killed[0] / self.killed[1]
        return 100 * (of_all - (2 * math.sqrt(of_all * (1 - of_all) / count) if self.sample else 0))


def drawn(mutant):
    """The place of a mutant in the draw: its own, whatever else is in the file."""
    return hashlib.sha256(f"{SEED} {key(mutant)}".encode()).digest()


CORE = ("firmware/control", "firmware/math", "firmware/math/port/generic", "firmware/math/port")
DRIVE = ("firmware/drive", *CORE)
APP = ("firmware/app", "hal", *DRIVE)
AREAS = (
    Area("control and math", ("firmware/control/*.[ch]", "firmware/math/*.[ch]", "firmware/math/port/*.h",
                              "firmware/math/port/generic/*.h"), CORE, (95, 100),
         left_out=("firmware/math/port/fx_armv7.h",  # of other cores
                   "firmware/math/barrier.h")),  # computes nothing
    Area("drive", ("firmware/drive/*.c",), DRIVE, (137, 154), sample=60, looked_at=180,
         tests=("test_drive_steps", "test_drive", "test_voltage_drive", "test_low_speed")),
    Area("app", ("firmware/app/*.c",), APP, (37, 40), sample=52, looked_at=60, tests=("test_control_isr",)),
    Area("board", tuple(f"hal/stm32g431/{name}.c" for name in ("codes", "console", "led", "temperature", "text")),
         ("hal/stm32g431", "hal/cortex_m", *APP), (47, 48), sample=60, looked_at=60, tests=("test_console",)),
    Area("configuration", tuple(f"host_sim/config/{name}.cpp" for name in ("low_speed_units", "numbers", "per_unit")),
         ("host_sim/config", *DRIVE), (83, 90), sample=24, looked_at=166,
         tests=("test_per_unit", "test_rules", "test_refusals")),
)


@dataclass
class Test:
    """A test program: how it is linked, and how long it may run."""

    name: str
    link: list
    seconds: int = 0

    def linked(self, build, extra, replaced, program):
        """Links it with the object `extra` before all libraries; `replaced`: the end of that one's name for which it stands."""
        command = [word for word in self.link if not word.endswith(replaced)]
        first = next(at for at, word in enumerate(command) if word.endswith(".o") or word.endswith(".a"))
        command[first:first] = ["-fno-use-linker-plugin", str(extra)]  # nothing here has link-time optimisation
        command[command.index("-o") + 1] = str(program)
        return subprocess.run(command, cwd=build, capture_output=True, check=False).returncode == 0

    def run(self, program):
        """What fails in it first, None when all is well."""
        limit = ["prlimit", f"--cpu={self.seconds}"] if self.seconds else []
        # By lines, not by blocks: the rest of it need not run.
        with subprocess.Popen(["stdbuf", "-oL", *limit, program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True, errors="replace") as run:
            for line in run.stdout:
                failed = FAILED.match(line)
                if failed:
                    run.kill()
                    return f"{self.name}: {failed[1]}"
        return f"{self.name}: ended with {run.returncode}" if run.returncode else None


class Build:
    """What the CMake build says: how a file is compiled, how a test is linked."""

    def __init__(self, root, folder):
        self.root, self.folder = root, folder
        listed = json.loads((folder / "compile_commands.json").read_text(encoding="utf-8"))
        self.commands = {}
        for entry in listed:
            if Path(entry["file"]).is_relative_to(root):
                path = str(Path(entry["file"]).relative_to(root))
                self.commands.setdefault(path, []).append(shlex.split(entry["command"]))

    def compile_command(self, path, tests=()):
        """Without debug information, which would tell mutants from the original, and without in- and output.

        Of a file that is compiled into several programs the command for one of the tests.
        """
        commands = self.commands[path]
        of_a_test = [command for command in commands for test in tests
                     if f"/{test.name}.dir/" in command[command.index("-o") + 1]]
        command = (of_a_test or commands)[0]
        return [*(word for word in command[:command.index("-o")] if not word.startswith("-g")), WRAPPING]

    @functools.cache
    def test(self, name):
        """The test program of that name, None if there is none."""
        program = next((path for path in self.folder.glob(f"tests/*/{name}") if path.is_file()), None)
        if not program:
            return None
        steps = subprocess.run(["ninja", "-t", "commands", str(program.relative_to(self.folder))],
                               cwd=self.folder, check=True, capture_output=True, text=True).stdout
        link = shlex.split(steps.strip().splitlines()[-1])
        link = link[link.index("&&") + 1:]
        found = Test(name, link[:link.index("&&")])
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        failed = found.run(program)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if failed:
            raise SystemExit(f"{failed}; expected a test that passes without a mutant")
        found.seconds = 2 + math.ceil(3 * (after.ru_utime - before.ru_utime))
        return found


@dataclass
class Subject:
    """A file to be mutated: what is compiled for it, and the tests of its module."""

    path: str
    compile: list
    tests: list
    is_header: bool
    replaced: str


def subject(build, path, others=()):
    """A header's functions are in the object of its module's unit test, a source's in its own. `others`: more tests."""
    module = module_of(path)
    is_header = path.endswith(".h")
    names = [f"test_{module}", *(() if is_header else (f"reference_{module}",)), *others]
    tests = [test for test in map(build.test, dict.fromkeys(names)) if test]
    if not tests:
        raise SystemExit(f"{path}: none of the tests {', '.join(names)} is built")
    compiled = f"tests/unit/test_{module}.c" if is_header else path
    return Subject(path, build.compile_command(compiled, tests), tests, is_header, f"/{Path(compiled).name}.o")


@dataclass
class Candidate:
    mutant: mutants.Mutant
    subject: Subject
    object: Path
    code: bytes = b""
    killed_by: str = None


def compiled(build, subject_, text, object_, options=()):
    """The object code of the file with this text, None if the compiler refuses it."""
    folder = object_.with_suffix("")
    folder.mkdir()
    source = folder / Path(subject_.path).name
    source.write_bytes(text)
    if subject_.is_header:
        unit = build.root / "tests/unit" / f"test_{module_of(subject_.path)}.c"
        command = [*subject_.compile, *options, "-include", str(source), "-o", str(object_), "-c", str(unit)]
    else:
        # By its bare name: the object holds the name it was compiled by.
        command = [*subject_.compile, *options, "-o", str(object_), "-c", source.name]
    run = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    return object_.read_bytes() if run.returncode == 0 else None


def killer(build, candidate, object_):
    """Which test of the subject fails with this object, None if all pass."""
    program, found = object_.with_suffix(".test"), None
    for test in candidate.subject.tests:
        if not test.linked(build.folder, object_, candidate.subject.replaced, program):
            raise SystemExit(f"{candidate.mutant.path}:{candidate.mutant.line}: {test.name} cannot be linked with it")
        found = test.run(program)
        if found:
            break
    program.unlink(missing_ok=True)
    return found


def judge(build, candidate):
    """Which test kills it, as the build compiles it or with each shift checked."""
    candidate.killed_by = killer(build, candidate, candidate.object)
    if not candidate.killed_by:
        checked = candidate.object.with_name(f"checked_{candidate.object.name}")
        text = candidate.mutant.applied((build.root / candidate.mutant.path).read_bytes())
        compiled(build, candidate.subject, text, checked, SHIFTS_CHECKED)
        candidate.killed_by = killer(build, candidate, checked)


def each(pool, do, items, what):
    """do() for all items, in their order, with a line of progress on a terminal."""
    console = Console(stderr=True)
    return list(track(pool.map(do, items), total=len(items), description=what, console=console,
                      disable=not console.is_terminal, transient=True))


def examined(build, subjects, made, folder, jobs):
    """Of the mutants made of the subjects those that are ones, judged."""
    originals = {}
    for subject_ in subjects:
        text = (build.root / subject_.path).read_bytes()
        original = compiled(build, subject_, text, folder / f"original_{len(originals)}.o")
        if original is None:
            raise SystemExit(f"{subject_.path}: does not compile")
        originals[subject_.path] = original
    of_path = {subject_.path: subject_ for subject_ in subjects}
    candidates = [Candidate(mutant, of_path[mutant.path], folder / f"{at}.o") for at, mutant in enumerate(made)]

    def compile_it(candidate):
        source = (build.root / candidate.mutant.path).read_bytes()
        candidate.code = compiled(build, candidate.subject, candidate.mutant.applied(source), candidate.object)

    with ThreadPoolExecutor(jobs) as pool:
        each(pool, compile_it, candidates, "compiling mutants")
        seen = {(path, code) for path, code in originals.items()}
        real = []
        for candidate in candidates:
            key = (candidate.mutant.path, candidate.code)
            if candidate.code is not None and key not in seen:
                seen.add(key)
                real.append(candidate)
        each(pool, lambda candidate: judge(build, candidate), real, "testing mutants")
    return real


def registered(path):
    """(path, function, before, after) → (kind, reason), and what is wrong with the register itself."""
    entries, bad = {}, []
    for entry in tomllib.loads(path.read_text(encoding="utf-8")).get("survivor", []):
        if set(entry) != KEYS or entry["kind"] not in KINDS or not entry["reason"].strip() or not entry["mutants"]:
            bad.append(f"{path.name}: {entry}: an entry has {', '.join(sorted(KEYS))}; kind is {' or '.join(KINDS)}")
            continue
        for mutant in entry["mutants"]:
            place = (entry["file"], entry["function"], entry["line"], mutant)
            if place in entries:
                bad.append(f"{path.name}: {entry['file']} ({entry['function']}): '{mutant}' stands there twice")
            entries[place] = (entry["kind"], entry["reason"])
    return entries, bad


def key(mutant):
    return mutant.path, mutant.function, mutant.before, mutant.after


def findings(real, register, made, all_registered=True):
    """What is not in the register, and what is there without need. `made`: all mutants, also those that are none."""
    survivors = {key(candidate.mutant): candidate.mutant for candidate in real if not candidate.killed_by}
    killed = {key(candidate.mutant) for candidate in real} - set(survivors)
    for place, mutant in survivors.items():
        if all_registered and place not in register:
            yield f"{mutant.path}:{mutant.line}: ({mutant.function}) survives: {mutant.before} → {mutant.after}"
    # What this compiler proves to be none may survive with another one.
    there, paths = set(map(key, made)) - killed, {mutant.path for mutant in made}
    for place in register:
        if place[0] in paths and place not in there:
            yield f"{place[0]}:1: ({place[1]}) registered, but killed or not there: {place[2]} → {place[3]}"


def idle(real, made):
    """Functions of which no mutant changes the object code: inline ones that their test does not call."""
    changed = {(candidate.mutant.path, candidate.mutant.function) for candidate in real}
    lines = {(mutant.path, mutant.function): mutant.line for mutant in made}
    for (path, function), line in lines.items():
        if (path, function) not in changed:
            yield f"{path}:{line}: ({function}) no mutant changes the code of the test; expected a test that calls it"


def share(killed, total):
    return 100.0 * killed / total if total else 0.0


def tables(real, register):
    by_file = {}
    for candidate in real:
        row = by_file.setdefault(candidate.mutant.path, [0, 0, 0])
        row[0] += 1
        row[1] += bool(candidate.killed_by)
        row[2] += register.get(key(candidate.mutant), ("",))[0] == EQUIVALENT
    rows = [[path, total, killed, equivalent, f"{share(killed, total - equivalent):.1f} %"]
            for path, (total, killed, equivalent) in by_file.items()]
    survivors = [[f"{c.mutant.path}: {c.mutant.function}", c.mutant.before, c.mutant.after,
                  *register.get(key(c.mutant), ("", "not in the register"))] for c in real if not c.killed_by]
    killed = sum(row[2] for row in rows)
    of_all = f"{killed} of {len(real)} are killed, {share(killed, len(real)):.1f} %, with the equivalent ones among them."
    return [part.table("Mutants by file", ["File", "Mutants", "Killed", "Equivalent", "Killed of the others"], rows,
                       of_all),
            part.table("Survivors", ["Function", "Line", "Mutant", "Kind", "Reason"], survivors)]


def rate(area, real, register):
    """The share killed of those that change something."""
    killed = sum(1 for candidate in real if candidate.killed_by)
    equivalent = sum(register.get(key(candidate.mutant), ("",))[0] == EQUIVALENT for candidate in real)
    count = len(real) - equivalent
    value, least = share(killed, count), area.least(max(count, 1))
    of = f"a sample of {len(real)}" if area.sample else "all"
    return part.figure(f"{area.name}: mutants killed, of {of} that change what is computed", f"{value:.1f} %",
                       f"at least {least:.1f} %", bool(real) and least <= value)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=part.ROOT / "build/host", help="folder of the CMake build")
    parser.add_argument("--only", action="append", metavar="TEXT", help="only files with TEXT in their path")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument("--kills", action="store_true", help="print for each mutant which test kills it")
    args = part.arguments(parser)
    build = Build(part.ROOT, args.build.resolve())
    register, found = registered(REGISTER)
    rates, everything = [], []
    for area in AREAS:
        made, sample = area.mutants(part.ROOT, args.only)
        if not made:
            continue
        subjects = [subject(build, path, area.tests) for path in sorted({mutant.path for mutant in sample})]
        with tempfile.TemporaryDirectory() as folder:
            real = examined(build, subjects, [mutant for mutant in made if mutant in sample], Path(folder), args.jobs)
        rates.append(rate(area, real, register))
        found += findings(real, register, made, area.sample == 0)
        found += idle(real, made) if area.sample == 0 else ()
        everything += real
    if args.kills:
        for candidate in everything:
            mutant = candidate.mutant
            print(f"{mutant.path}:{mutant.line}: ({mutant.function}) {mutant.before} → {mutant.after}: "
                  f"{candidate.killed_by or 'survives'}")
    figures = [*rates, part.figure("survivors without a registered reason, entries that are wrong or in vain, functions not "
                                   "called", len(found), "0", not found)]
    return part.end(args.out, "mutation", "Mutation",
                    "Small faults (an operator, a constant, a sign, a term, a saturation) are put one at a time into what the "
                    "drive computes with; unit tests, and comparisons with the reference, find them. Of control and math these "
                    "are all there are, of the others a sample. Faults that the compiler proves to be none are left out.",
                    figures, tables(everything, register), found)


if __name__ == "__main__":
    os.environ["LC_ALL"] = "C.UTF-8"
    sys.exit(main())
