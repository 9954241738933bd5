# SPDX-License-Identifier: MIT
"""All mutants of a C file in one object: compiled and linked once, one of them chosen when a test begins.

Each mutant of a function is a function of its own beside the original; under the function's name stands a switch between
them. None of them is optimised together with what surrounds it, so the same assembly is the same function: what the
compiler makes of a mutant tells whether it is distinct. What it says of a mutant's lines, error or warning, refuses it.
"""

import os
import re
import subprocess
from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path

CHOICE = Path(__file__).with_name("chosen_mutant.c")
# A function apart from all others, whole, and with nothing in its text that the next one would have otherwise.
APART = "__attribute__((noipa, unused)) "
OPTIONS = ("-Wno-attributes", "-fno-asynchronous-unwind-tables", "-fno-reorder-blocks-and-partition", "-fno-ident")
SAID = re.compile(r"^(?P<file>[^:\n]+):(?P<line>\d+):\d+: (?P<kind>error|warning|fatal error): (?P<text>.*)$", re.MULTILINE)
FUNCTION = re.compile(r"^(\w+__m(\d+)):\n(.*?)^\t\.size\t\1,", re.MULTILINE | re.DOTALL)
LABEL = re.compile(r"\.L(\d+)\b")


class CannotCompile(Exception):
    """The file as it is, with what the compiler says."""


@dataclass
class Text:
    """The file with mutants beside their functions; `lines`: the first line of each mutant and of what follows it."""

    text: bytes
    lines: list  # (line, number of the mutant or None)

    def mutant_at(self, line):
        return self.lines[bisect_right(self.lines, line, key=lambda entry: entry[0]) - 1][1]


def variant(source, whole, number, edit=None):
    """The function's text under a name of its own, with a mutant's edit."""
    start, end, text = edit or (whole.end, whole.end, "")
    return (APART.encode() + source[whole.start:whole.name] + f"{whole.spelling}__m{number}".encode()
            + source[whole.name + len(whole.spelling):start] + text.encode() + source[end:whole.end])


def switch(source, whole, numbers, original):
    """The function that calls the chosen one."""
    head = source[whole.start:whole.body].decode()
    call = f"{whole.spelling}__m{{}}({', '.join(whole.parameters)});"
    give = (lambda number: f"{call.format(number)} return;") if whole.returns_nothing else (
        lambda number: f"return {call.format(number)}")
    cases = "".join(f"case {number}: {give(number)}\n" for number in numbers)
    return f"{head}{{\nswitch (nf_mutant) {{\n{cases}default: {give(original)}\n}}\n}}\n".encode()


def combined(source, numbered):
    """The file with these mutants: number → mutant. The originals have numbers behind all of them."""
    by_function = {}
    for number, mutant in sorted(numbered.items()):
        by_function.setdefault(mutant.whole, []).append((number, mutant))
    original = max(numbered, default=0)
    parts, lines, at = [b"extern int nf_mutant;\n#line 1\n"], [(0, None)], 0
    line = 1

    def add(text, number=None):
        nonlocal line
        lines.append((line, number))
        parts.append(text)
        line += text.count(b"\n")

    originals = {}
    for whole, mutants in sorted(by_function.items(), key=lambda entry: entry[0].start):
        add(source[at:whole.start])
        original += 1
        originals[whole] = original
        add(variant(source, whole, original) + b"\n")
        for number, mutant in mutants:
            add(variant(source, whole, number, (mutant.start, mutant.end, mutant.text)) + b"\n", number)
        add(switch(source, whole, [number for number, _ in mutants], original))
        at = whole.end
    add(source[at:])
    return Text(b"".join(parts), lines), originals


def assembly(path):
    """Number → what the function is, without the names of its labels; those of constants stay."""
    found = {}
    for _, number, body in FUNCTION.findall(path.read_text(encoding="utf-8")):
        names = {}
        body = LABEL.sub(lambda label: names.setdefault(label[1], f".L:{len(names)}"), body)
        found[int(number)] = re.sub(rf"\b(\w+)__m{number}\b", r"\1", body)
    return found


class Schemata:
    """The distinct mutants of one subject, in an object for its tests."""

    def __init__(self, subject, root, folder, numbered, options=()):
        self.subject, self.folder = subject, folder
        folder.mkdir(parents=True)
        self.object = folder / "mutants.o"
        self.source = (root / subject.path).read_bytes()
        self.numbered = dict(numbered)  # without those that the compiler refuses
        unit = folder / Path(subject.path).name
        compiled = ["-include", str(unit), "-c", str(root / subject.unit)] if subject.is_header else ["-c", str(unit)]
        command = [word for word in subject.compile if word != "-Werror"] + [*OPTIONS, *options]
        # First without code: each mutant that is refused takes another pass, and the last needs code for all that are left.
        self.make(unit, [*command, "-fsyntax-only", *compiled])
        self.code = self.make(unit, [*command, "-S", "-o", str(folder / "mutants.s"), *compiled])
        run(["gcc", "-c", "-o", str(self.object), str(folder / "mutants.s")])

    def make(self, unit, command):
        """Compiles until nothing is said of a mutant; what each function is."""
        while True:
            text, self.originals = combined(self.source, self.numbered)
            unit.write_bytes(text.text)
            said = subprocess.run(command, cwd=unit.parent, capture_output=True, text=True, errors="replace",
                                  env={**os.environ, "LC_ALL": "C"}, check=False)
            refused = {text.mutant_at(int(one["line"])) for one in SAID.finditer(said.stderr)
                       if Path(one["file"]).resolve() == unit.resolve()} - {None}
            if not refused:
                break
            for number in refused:
                del self.numbered[number]
        if said.returncode:
            raise CannotCompile(f"{self.subject.path}: {said.stderr.strip()}")
        return assembly(Path(command[command.index("-o") + 1])) if "-o" in command else {}

    def different(self):
        """The numbers of the mutants that the compiler made something of its own of."""
        seen = {(whole, self.code.get(number)) for whole, number in self.originals.items()}
        for number, mutant in self.numbered.items():
            key = mutant.whole, self.code.get(number)
            if key not in seen:
                seen.add(key)
                yield number


def run(command):
    made = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    if made.returncode:
        raise CannotCompile(made.stderr.strip())
