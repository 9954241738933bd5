# SPDX-License-Identifier: MIT
"""evidence.traceability: each equation of the papers and each requirement has its functions and tests.

tests/evidence/requirements.toml says which, and whether it is met: what departs from its wording or is not met says why.
It holds when every equation of both papers and every requirement has a function (where all of the code is meant, the
folders with it) and a test, every function that is named is defined in the sources, every test is one that ctest runs
(its own name, or that of a Unity or Python test in it), one of the tests of an entry runs each of its functions, each
equation's number stands in a comment beside one of its functions, and no comment cites an equation that there is not.

What a test runs evidence.coverage has counted: of each Unity test alone, with its setUp(). It counts no functions of
tools/design and of what of the board no PC runs, and no tests of these, of targets and of gates: an entry with none but
such tests is not asked. Where an entry has others too, one of these has to run each function that is counted.
"""

import argparse
import functools
import json
import re
import sys
import tomllib
from pathlib import Path

import ctested
import part
from syntax import Place, test_functions, unit, units

REGISTER = Path("tests/evidence/requirements.toml")
EQUATIONS = {"A": 23, "B": 60}  # of each paper, numbered from 1
# Of each group the number of its requirements; the head of the register says which group is what.
REQUIREMENTS = {"C1.": 3, "C2.": 3, "C3.": 8, "C4.": 8, "C5.": 6, "C6.": 12, "C7.": 8, "H": 20, "F": 78, "I": 11, "L": 10}
RAN = part.ROOT / "build/host/evidence/ran.json"
SOURCES = {"firmware": "c", "hal": "c", "host_sim": "c++", "tools/design": "c++"}  # and the language its headers are for
KEYS = {"id", "title", "source", "functions", "scope", "tests", "status", "note"}
STATUSES = MET, DEPARTS, NOT_MET = "met", "departs", "not met"

NUMBERS = r"\(\d+\)(?:(?:–|, | and )\(\d+\))*"
OF_A_PAPER = re.compile(rf"[Pp]aper ([AB]) ({NUMBERS})|({NUMBERS}) of\s+paper ([AB])")
PAPER = re.compile(r"\b[Pp]aper ([AB])\b")
BARE = re.compile(rf"(?<![\w)])({NUMBERS})")


# --- What the sources say ---

def numbers(text):
    """`(14)–(16), (22)` as 14, 15, 16, 22."""
    for first, last in re.findall(r"\((\d+)\)(?:–\((\d+)\))?", text):
        yield from range(int(first), int(last or first) + 1)


def cited(comments):
    """(paper, number) and place of each equation that the comments of a unit name. A number alone is of the one paper that
    they name."""
    papers = {paper for text, _ in comments for paper in PAPER.findall(text)}
    for text, place in comments:
        found = [(match[1] or match[4], match[2] or match[3], match.start()) for match in OF_A_PAPER.finditer(text)]
        if len(papers) == 1:
            rest = OF_A_PAPER.sub(lambda match: " " * len(match[0]), text)
            found += [(*papers, match[1], match.start()) for match in BARE.finditer(rest)]
        for paper, listed, start in found:
            for number in numbers(listed):
                yield (paper, number), Place(place.path, place.line + text.count("\n", 0, start))


class Sources:
    """functions: name → files that define it. citations: (paper, number) → {file: line of the first place}."""

    def __init__(self, root):
        self.functions, self.citations = {}, {}
        for functions, comments in units(root, SOURCES, PAPER):
            for name, place in functions:
                self.functions.setdefault(name, set()).add(place.path)
            for cited_equation, place in cited(comments):
                self.citations.setdefault(cited_equation, {}).setdefault(place.path, place.line)


# --- What ctest runs ---

def program_sources(build):
    """Name of a program → its own source files."""
    found = {}
    for path, program in ctested.compiled(build):
        found.setdefault(program, []).append(path)
    return found


def python_files(argument, folder):
    """The test file that an argument of a command names, as a path or as a module of the folder."""
    paths = (Path(argument), folder / argument, folder / f"{argument}.py")
    return [path for path in paths if path.suffix == ".py" and path.is_file()][:1]


@functools.cache
def tests(build):
    """Name of a test, or of a test function → names of the tests of ctest that run it."""
    found = {}
    sources = program_sources(build)
    for name, test in ctested.listed(build).items():
        found.setdefault(name, set()).add(name)
        for argument in test.command:
            for path in sources.get(Path(argument).name, python_files(argument, test.folder)):
                for function in test_functions(path):
                    found.setdefault(function, set()).add(name)
    return found


# --- The register ---

def equation(name):
    """`A (22)` as ("A", 22); None for a requirement."""
    match = re.fullmatch(r"([AB]) \((\d+)\)", name)
    return (match[1], int(match[2])) if match else None


def entries(path):
    """The entries of the register, one an equation or requirement, each with the line it begins at."""
    text = path.read_text(encoding="utf-8")
    lines = [number for number, line in enumerate(text.splitlines(), 1) if line.strip() == "[[entry]]"]
    for line, entry in zip(lines, tomllib.loads(text)["entry"]):
        names = entry["id"] if isinstance(entry["id"], list) else [entry["id"]]
        for name in names:
            yield {"note": "", "functions": [], "scope": [], "tests": [], "source": "", "title": "", "status": MET, **entry,
                   "id": name, "line": line}


def what_ran(path):
    if not path.is_file():
        sys.exit(f"{path}: is missing; evidence.coverage --ran {path} writes it")
    return json.loads(path.read_text(encoding="utf-8"))


class Finder:
    """Compares the register with the sources and the tests."""

    def __init__(self, root, build, register, ran):
        self.root, self.register, self.ran = root, register, ran
        self.sources, self.tests = Sources(root), tests(build)
        self.entries = list(entries(root / register))
        self.bad = []

    def say(self, entry, text):
        self.bad.append(f"{self.register}:{entry['line']}: {entry['id']}: {text}")

    def check_entry(self, entry):
        for key in sorted(set(entry) - KEYS - {"line"}):
            self.say(entry, f"there is no key '{key}'")
        for key in ("title", "source", "tests"):
            if not entry[key]:
                self.say(entry, f"has no {key}")
        if bool(entry["functions"]) == bool(entry["scope"]):
            self.say(entry, "has both functions and a scope" if entry["scope"] else "has no functions")
        if entry["status"] not in STATUSES:
            self.say(entry, f"is '{entry['status']}'; expected {', '.join(STATUSES)}")
        elif entry["status"] != MET and not entry["note"]:
            self.say(entry, f"is '{entry['status']}' and has no note that says why")
        for name in entry["scope"]:
            if not any((self.root / name).rglob("*.c")):
                self.say(entry, f"its scope {name} has no code")
        for name in entry["functions"]:
            if name not in self.sources.functions:
                self.say(entry, f"no function {name} is defined in {', '.join(SOURCES)}")
        for name in entry["tests"]:
            if name not in self.tests:
                self.say(entry, f"ctest runs no test {name}")
        self.check_runs(entry)
        if equation(entry["id"]):
            self.check_citation(entry)

    def runs(self, entry):
        """Each of its tests of which the coverage has counted what it runs, with these functions: a Unity test by itself, a
        Python test as all of the test of ctest that it belongs to."""
        for test in entry["tests"]:
            for program in sorted(self.tests.get(test, set()) & set(self.ran["tests"])):
                ran = self.ran["tests"][program]
                alone = len(ran) > 1 and test != program
                yield test, set(ran.get(test, ()) if alone else ran[""])

    def links(self, entry):
        """(function, whether one of its counted tests runs it) of all that are counted; none where no test is."""
        runs = [functions for _, functions in self.runs(entry)]
        for name in entry["functions"] if runs else ():
            if name in self.ran["counted"]:
                yield name, any(name in functions for functions in runs)

    def check_runs(self, entry):
        for name, is_run in self.links(entry):
            if not is_run:
                tests = sorted({test for test, _ in self.runs(entry)})
                self.say(entry, f"{name} is run by none of {', '.join(tests)}")

    def check_citation(self, entry):
        beside = {unit(path) for name in entry["functions"] for path in self.sources.functions.get(name, ())}
        citing = self.sources.citations.get(equation(entry["id"]), {})
        if not beside & {unit(path) for path in citing}:
            self.say(entry, f"no comment beside {', '.join(entry['functions'])} names it")

    def check(self):
        for entry in self.entries:
            self.check_entry(entry)
        names = [entry["id"] for entry in self.entries]
        self.bad += [f"{self.register}: {name} stands twice" for name in sorted(set(names)) if names.count(name) > 1]
        wanted = {(paper, number) for paper, count in EQUATIONS.items() for number in range(1, count + 1)}
        there = {equation(name) for name in names} - {None}
        self.bad += [f"{self.register}: equation ({number}) of paper {paper} is missing"
                     for paper, number in sorted(wanted - there)]
        self.bad += [f"{self.register}: {section}{number} is missing" for section, count in REQUIREMENTS.items()
                     for number in range(1, count + 1) if f"{section}{number}" not in names]
        self.bad += [f"{path}:{line}: there is no equation ({number}) of paper {paper}"
                     for (paper, number), places in sorted(self.sources.citations.items()) if (paper, number) not in wanted
                     for path, line in sorted(places.items())]
        return self.bad


# --- For the page ---

def row(entry, found):
    where = [f"{name} ({', '.join(path.as_posix() for path in sorted(found.sources.functions.get(name, ())))})"
             for name in entry["functions"]] or [f"all of {', '.join(entry['scope'])}"]
    run = [name if name in found.tests.get(name, ()) else f"{name} ({', '.join(sorted(found.tests.get(name, ())))})"
           for name in entry["tests"]]
    title = entry["title"] + (f" – {entry['note']}" if entry["note"] else "")
    return entry["id"], title, entry["source"], entry["status"], "\n".join(where), "\n".join(run)


def statuses(listed):
    """How many are met as they stand, and which are not."""
    names = {status: [entry["id"] for entry in listed if entry["status"] == status] for status in STATUSES}
    words = [f"{len(names[MET])} of {len(listed)} met as they stand", *(f"{len(names[status])} {word}: {', '.join(names[status])}"
                                                      for status, word in ((DEPARTS, "depart"), (NOT_MET, "not met"))
                                                      if names[status])]
    return "; ".join(words)


def seen_to_run(found):
    """Figures of the links between functions and tests that the coverage has counted."""
    links = [is_run for entry in found.entries for _, is_run in found.links(entry)]
    every = sum(len(entry["functions"]) for entry in found.entries)
    return f"{sum(links)} of {len(links)} ({every} in all)", "all that are counted", bool(links) and all(links)


def result(found, bad):
    """Figures and tables."""
    of_paper = {paper: sorted((entry for entry in found.entries if (equation(entry["id"]) or " ")[0] == paper),
                              key=lambda entry: equation(entry["id"])) for paper in EQUATIONS}
    requirements = [entry for entry in found.entries if not equation(entry["id"])]
    whole = [entry for entry in found.entries if not any(f": {entry['id']}: " in line for line in bad)]

    def share(of_what, listed, count):
        kept = len([entry for entry in listed if entry in whole])
        return part.figure(f"{of_what} with function and test", f"{kept} of {count}", "all", 0 < kept == count)

    figures = [*(share(f"equations of paper {paper}", listed, EQUATIONS[paper]) for paper, listed in of_paper.items()),
               share("requirements", requirements, sum(REQUIREMENTS.values())),
               part.figure("functions that a test beside them was seen to run", *seen_to_run(found)),
               part.figure("broken links", len(bad), 0, not bad)]
    columns = ("Number", "What", "Source", "Status", "Functions", "Tests")
    tables = [part.table(title, columns, [row(entry, found) for entry in listed], statuses(listed))
              for title, listed in (*((f"Paper {paper}", listed) for paper, listed in of_paper.items()),
                                    ("Requirements", requirements))]
    return figures, tables


SAYS = ("Each equation of both papers and each requirement, with the functions that do it, the tests that hold it, and "
        "whether it is met, met in another way than it is worded (departs) or not met. "
        "Functions are looked up in the sources, tests among those that ctest runs; that a test runs the function is "
        "seen in the coverage, of each Unity test alone, where it counts both; and each equation's number in the "
        "comments beside its functions.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, default=part.ROOT)
    parser.add_argument("--build", type=Path, default=part.ROOT / "build" / "host", help="the build whose tests count")
    parser.add_argument("--register", type=Path, default=REGISTER, help="relative to the root")
    parser.add_argument("--ran", type=Path, default=RAN, help="which functions each test runs, by evidence.coverage")
    args = part.arguments(parser)
    found = Finder(args.root.resolve(), args.build.resolve(), args.register, what_ran(args.ran))
    bad = found.check()
    return part.end(args.out, "traceability", "Traceability", SAYS, *result(found, bad), bad)


if __name__ == "__main__":
    sys.exit(main())
