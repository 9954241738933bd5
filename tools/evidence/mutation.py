# SPDX-License-Identifier: MIT
"""evidence.mutation: the tests find nearly every small fault in what the drive computes.

Each mutant (mutants.py) is compiled with the options of the build and put into the tests of its area: those of a C file
all in one object (schemata.py), of a C++ file each alone. It is killed when one of them fails, crashes or does not end. A
mutant is discarded when the compiler refuses it, or makes the code of the original or of an earlier mutant of it; the others
are distinct. What survives in
the firmware is tested once more with each shift checked: one by too many bits is undefined, and what the PC makes of it
another core does not.

Of control, math and the cross-checks all mutants are made, and what survives has to stand in the register (survivors.toml)
with its reason.
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
import threading
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import track

import mutants
import part
import schemata

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
DRIVE = ("firmware/record", "firmware/drive", "firmware/config", "firmware/protect", *CORE)
# Modules of lower rooms of which a sample is drawn, as of the drive.
SAMPLED = ("firmware/control/align.c", "firmware/control/flying_start.c", "firmware/control/model.c", "firmware/math/crc32.c")
# Modules of which all mutants are made.
CROSS_CHECKED = ("firmware/protect/current_sum.c", "firmware/app/cross_check.c")
APP = ("firmware/app", "hal", *DRIVE)
# Numbers of the configuration that other tests than its area's are for.
TESTED_ELSEWHERE = tuple(f"host_sim/config/units/{name}.cpp"
                         for name in ("safe_state_units", "speed_margin", "torque_filter_units", "torque_loop_units"))
AREAS = (
    Area("control and math", ("firmware/control/*.[ch]", "firmware/math/*.[ch]", "firmware/math/port/*.h",
                              "firmware/math/port/generic/*.h"), CORE, (95, 100),
         left_out=(*SAMPLED,
                   "firmware/math/port/fx_armv7.h",  # of other cores
                   "firmware/math/barrier.h")),  # computes nothing
    Area("drive", (*(f"{room}/*.c" for room in DRIVE[:4]), *SAMPLED), DRIVE, (137, 154), sample=60, looked_at=180,
         tests=("test_drive_steps", "test_open_loop", "test_run", "test_monitor", "test_drive", "test_voltage_drive",
                                         "test_low_speed"), left_out=CROSS_CHECKED),
    Area("cross-checks", CROSS_CHECKED, APP, (95, 100)),
    Area("app", tuple(f"firmware/app/{name}.c" for name in ("command_mailbox", "control_isr", "units")), APP, (72, 84),
         sample=52, looked_at=112, tests=("test_control_isr",)),
    Area("console", tuple(f"firmware/app/{name}.c" for name in ("commander", "console", "status", "temperature", "text")), APP,
         (44, 45), sample=60, tests=("test_console", "test_link")),
    Area("store", tuple(f"firmware/app/{name}.c" for name in ("store", "stored_config")), APP, (86, 99), sample=60, looked_at=120),
    # `killed` is of all there were before the first look at them.
    Area("identification", ("firmware/app/identify*.c",), APP, (1581, 1729), sample=60),
    Area("board", ("hal/stm32g4/led.c",), ("hal/stm32g4", *APP), (47, 50), sample=60),
    Area("configuration", ("host_sim/config/per_unit.cpp", "host_sim/config/units/*.cpp"),
         ("host_sim/config/units", "host_sim/config", *DRIVE), (83, 90), sample=24,
         tests=("test_per_unit", "test_rules", "test_refusals"), left_out=TESTED_ELSEWHERE),
)


@dataclass
class Test:
    """A test program: how it is linked, and how long it may run."""

    name: str
    link: list
    seconds: int = 0

    def linked(self, build, extra, replaced, program):
        """Links it with the objects `extra` before all libraries; `replaced`: the end of the name for which they stand."""
        command = [word for word in self.link if not word.endswith(replaced)]
        first = next(at for at, word in enumerate(command) if word.endswith(".o") or word.endswith(".a"))
        # Nothing here has link-time optimisation.
        command[first:first] = ["-fno-use-linker-plugin", "-Wl,--strip-debug", *map(str, extra)]
        command[command.index("-o") + 1] = str(program)
        return subprocess.run(command, cwd=build, capture_output=True, check=False).returncode == 0

    def run(self, program, chosen=0):
        """What fails in it first with the mutant of that number, None when all is well."""
        environment = {**os.environ, "NF_MUTANT": str(chosen), "NF_SECONDS": str(self.seconds)}
        with subprocess.Popen([program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors="replace",
                              env=environment) as run:
            for line in run.stdout:
                failed = FAILED.match(line)
                if failed:
                    run.kill()  # the rest of it need not run
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
    unit: str  # the source whose object it is in


def subject(build, path, others=()):
    """A header's functions are in the object of its module's unit test, a source's in its own. `others`: more tests."""
    module = module_of(path)
    is_header = path.endswith(".h")
    names = [f"test_{module}", *(() if is_header else (f"reference_{module}",)), *others]
    tests = [test for test in map(build.test, dict.fromkeys(names)) if test]
    if not tests:
        raise SystemExit(f"{path}: none of the tests {', '.join(names)} is built")
    compiled = f"tests/unit/test_{module}.c" if is_header else path
    return Subject(path, build.compile_command(compiled, tests), tests, is_header, compiled)


@dataclass
class Candidate:
    mutant: mutants.Mutant
    killed_by: str = None


def compiled(build, subject_, text, object_, options=()):
    """The object code of the file with this text, None if the compiler refuses it."""
    folder = object_.with_suffix("")
    folder.mkdir()
    source = folder / Path(subject_.path).name
    source.write_bytes(text)
    if subject_.is_header:
        unit = build.root / subject_.unit
        command = [*subject_.compile, *options, "-include", str(source), "-o", str(object_), "-c", str(unit)]
    else:
        # By its bare name: the object holds the name it was compiled by.
        command = [*subject_.compile, *options, "-o", str(object_), "-c", source.name]
    run = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    return object_.read_bytes() if run.returncode == 0 else None


class Programs:
    """The tests of a subject, linked with an object that stands for its own."""

    def __init__(self, build, subject_, object_, chooser):
        self.build, self.subject = build, subject_
        self.extra = [object_, chooser]
        self.programs = {}
        self.linking = threading.Lock()

    def program(self, test):
        with self.linking:
            if test.name not in self.programs:
                program = self.extra[0].with_name(f"{self.extra[0].stem}.{test.name}")
                if not test.linked(self.build.folder, self.extra, f"/{Path(self.subject.unit).name}.o", program):
                    raise SystemExit(f"{self.subject.path}: {test.name} cannot be linked with its mutants")
                self.programs[test.name] = program
            return self.programs[test.name]

    def killer(self, chosen=0):
        """Which test of the subject fails with that mutant, None if all pass."""
        return next(filter(None, (test.run(self.program(test), chosen) for test in self.subject.tests)), None)


def chooser(folder):
    """The object that says which mutant runs."""
    object_ = folder / "chosen_mutant.o"
    subprocess.run(["gcc", "-O1", "-o", object_, "-c", schemata.CHOICE], check=True)
    return object_


def each(pool, do, items, what):
    """do() for all items, in their order, with a line of progress on a terminal."""
    console = Console(stderr=True)
    return list(track(pool.map(do, items), total=len(items), description=what, console=console,
                      disable=not console.is_terminal, transient=True))


def same_alone(build, subject_, numbered, folder, pool):
    """Those of the mutants whose file the compiler refuses, or makes the same of as of the original or of an earlier one."""
    def code(number):
        return compiled(build, subject_, numbered[number].applied(source), folder / f"{number}.o")

    source = (build.root / subject_.path).read_bytes()
    original = compiled(build, subject_, source, folder / "original.o")
    if original is None:
        raise SystemExit(f"{subject_.path}: does not compile")
    seen, same = {original, None}, set()
    for number, made in zip(numbered, pool.map(code, numbered)):
        same |= {number} if made in seen else set()
        seen.add(made)
    return same


class Alone:
    """The mutants of a C++ file, each compiled and linked alone."""

    def __init__(self, build, subject_, numbered, folder, choice, pool):
        folder.mkdir()
        self.build, self.subject, self.folder, self.choice = build, subject_, folder, choice
        self.numbered = numbered
        same = same_alone(build, subject_, numbered, folder, pool)
        self.different = [number for number in numbered if number not in same]

    def killer(self, number):
        return Programs(self.build, self.subject, self.folder / f"{number}.o", self.choice).killer()

    def survive(self, numbers, _):
        """A PC alone computes it: no shift to be checked."""
        return dict.fromkeys(numbers)


class Together:
    """The mutants of a C file, all in one object."""

    def __init__(self, build, subject_, numbered, folder, choice, pool):
        folder.mkdir()
        self.build, self.subject, self.folder, self.choice, self.pool = build, subject_, folder, choice, pool
        self.numbered = numbered
        made = schemata.Schemata(subject_, build.root, folder / "plain", numbered)
        self.different = list(made.different())
        self.killer = Programs(build, subject_, made.object, choice).killer

    def survive(self, numbers, register):
        """Number → what kills it with each shift checked, None if nothing does; without those that are discarded alone."""
        survivors = {number: self.numbered[number] for number in numbers}
        checked = schemata.Schemata(self.subject, self.build.root, self.folder / "checked", survivors, SHIFTS_CHECKED)
        killer = Programs(self.build, self.subject, checked.object, self.choice).killer
        found = dict(zip(survivors, self.pool.map(killer, survivors)))
        unknown = {number: mutant for number, mutant in survivors.items() if not found[number] and key(mutant) not in register}
        discarded = same_alone(self.build, self.subject, unknown, self.folder, self.pool) if unknown else ()
        return {number: killed_by for number, killed_by in found.items() if number not in discarded}


def examined(build, subjects, made, folder, jobs, register=()):
    """The distinct ones of the mutants made of the subjects, judged."""
    choice = chooser(folder)
    numbered = {subject_.path: {} for subject_ in subjects}
    for number, mutant in enumerate(made, 1):
        numbered[mutant.path][number] = mutant
    distinct = {}
    with ThreadPoolExecutor(jobs) as files, ThreadPoolExecutor(jobs) as pool:
        def prepared(subject_):
            way = Alone if subject_.path.endswith(".cpp") else Together
            return way(build, subject_, numbered[subject_.path], folder / f"of_{subjects.index(subject_)}", choice, pool)

        ways = each(files, prepared, [one for one in subjects if numbered[one.path]], "compiling mutants")
        asked = [(way, number) for way in ways for number in way.different]
        killers = each(pool, lambda one: one[0].killer(one[1]), asked, "testing mutants")
        for (_, number), killed_by in zip(asked, killers):
            distinct[number] = killed_by
        for way in ways:
            survivors = [number for number in way.different if not distinct[number]]
            for number in survivors:
                del distinct[number]
            distinct |= way.survive(survivors, register) if survivors else {}
    return [Candidate(made[number - 1], killed_by) for number, killed_by in sorted(distinct.items())]


def registered(path):
    """(path, function, before, after) → (kind, reason), and what is wrong with the register itself."""
    entries, bad = {}, []
    for entry in tomllib.loads(path.read_text(encoding="utf-8")).get("survivor", []):
        entry = {"kind": EQUIVALENT, **entry}
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


def findings(distinct, register, made, all_registered=True):
    """What is not in the register, and what is there without need. `made`: all mutants, also those that are discarded."""
    survivors = {key(candidate.mutant): candidate.mutant for candidate in distinct if not candidate.killed_by}
    killed = {key(candidate.mutant) for candidate in distinct} - set(survivors)
    for place, mutant in survivors.items():
        if all_registered and place not in register:
            yield f"{mutant.path}:{mutant.line}: ({mutant.function}) survives: {mutant.before} → {mutant.after}"
    # What is discarded with this compiler may survive with another one.
    there, paths = set(map(key, made)) - killed, {mutant.path for mutant in made}
    for place in register:
        if place[0] in paths and place not in there:
            yield f"{place[0]}:1: ({place[1]}) registered, but killed or not there: {place[2]} → {place[3]}"


def idle(distinct, made):
    """Functions of which no mutant changes the object code: inline ones that their test does not call."""
    changed = {(candidate.mutant.path, candidate.mutant.function) for candidate in distinct}
    lines = {(mutant.path, mutant.function): mutant.line for mutant in made}
    for (path, function), line in lines.items():
        if (path, function) not in changed:
            yield f"{path}:{line}: ({function}) no mutant changes the code of the test; expected a test that calls it"


def share(killed, total):
    return 100.0 * killed / total if total else 0.0


def tables(distinct, register):
    by_file = {}
    for candidate in distinct:
        row = by_file.setdefault(candidate.mutant.path, [0, 0, 0])
        row[0] += 1
        row[1] += bool(candidate.killed_by)
        row[2] += register.get(key(candidate.mutant), ("",))[0] == EQUIVALENT
    rows = [[path, total, killed, equivalent, f"{share(killed, total - equivalent):.1f} %"]
            for path, (total, killed, equivalent) in by_file.items()]
    survivors = [[f"{c.mutant.path}: {c.mutant.function}", c.mutant.before, c.mutant.after,
                  *register.get(key(c.mutant), ("", "not in the register"))] for c in distinct if not c.killed_by]
    killed = sum(row[2] for row in rows)
    of_all = (f"{killed} of {len(distinct)} are killed, {share(killed, len(distinct)):.1f} %, "
              "with the equivalent ones among them.")
    return [part.table("Mutants by file", ["File", "Mutants", "Killed", "Equivalent", "Killed of the others"], rows,
                       of_all),
            part.table("Survivors", ["Function", "Line", "Mutant", "Kind", "Reason"], survivors)]


def rate(area, distinct, register):
    """The share killed of those that change something."""
    killed = sum(1 for candidate in distinct if candidate.killed_by)
    equivalent = sum(register.get(key(candidate.mutant), ("",))[0] == EQUIVALENT for candidate in distinct)
    count = len(distinct) - equivalent
    value, least = share(killed, count), area.least(max(count, 1))
    of = f"a sample of {len(distinct)}" if area.sample else "all"
    return part.figure(f"{area.name}: mutants killed, of {of} that change what is computed", f"{value:.1f} %",
                       f"at least {least:.1f} %", bool(distinct) and least <= value)


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
            distinct = examined(build, subjects, [mutant for mutant in made if mutant in sample], Path(folder), args.jobs,
                                register)
        rates.append(rate(area, distinct, register))
        found += findings(distinct, register, made, area.sample == 0)
        found += idle(distinct, made) if area.sample == 0 else ()
        everything += distinct
    if args.kills:
        for candidate in everything:
            mutant = candidate.mutant
            print(f"{mutant.path}:{mutant.line}: ({mutant.function}) {mutant.before} → {mutant.after}: "
                  f"{candidate.killed_by or 'survives'}")
    figures = [*rates, part.figure("survivors without a registered reason, entries that are wrong or in vain, functions not "
                                   "called", len(found), "0", not found)]
    return part.end(args.out, "mutation", "Mutation",
                    "Small faults (an operator, a constant, a sign, a term, a saturation) are put one at a time into what the "
                    "drive computes with; unit tests, and comparisons with the reference, find them. Of control, math and the cross-checks these "
                    "are all there are, of the others a sample. Faults that the compiler proves to be none are left out.",
                    figures, tables(everything, register), found)


if __name__ == "__main__":
    os.environ["LC_ALL"] = "C.UTF-8"
    sys.exit(main())
