# SPDX-License-Identifier: MIT
"""The transcripts in the guides: what the programs print.

transcripts.py PROGRAMS GDB           says which is not what is printed now; exit status 1 if one is not
transcripts.py PROGRAMS GDB --write   writes the outputs anew

PROGRAMS is the folder that has motorsim, nfconfig and gaindesign. A transcript is a block of a guide that is marked
`console`. A line that begins with `$ ` is a command; after a backslash it goes on in the next line. Lines that begin with a
prompt in brackets are typed into the program of the command before: the stepper, or gdb. All others are output; a line `...`
stands for any number of lines, and the eight digits of a checksum for any others. The blocks of a guide run one after the other in
one folder. A block that is marked `toml` and begins with `# NAME.toml` is written there as that file, before them.
"""
import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path

from generated import ROOT

BLOCK = re.compile(r"(?<=^```console\n).*?(?=^```$)", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"^```toml\n(# ([\w.]+\.toml)\n.*?)^```$", re.MULTILINE | re.DOTALL)
PROGRESS = re.compile(r"motorsim: \d+ of \d+ runs")  # where stderr is no terminal
TYPED = re.compile(r"^(\([^)]+\)) (.+)$")
ANY = "..."
CHECKSUM = re.compile(r"\b(configuration|hash) [0-9a-f]{8}\b")


def guides():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def commands(block):
    """Each command of a block with what it prints."""
    found = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append((line.removeprefix("$ "), []))
        elif found[-1][0].endswith("\\"):
            found[-1] = (f"{found[-1][0]}\n{line}", [])
        else:
            found[-1][1].append(line)
    return found


def gdb_command(gdb, command, typed):
    """gdb without a terminal shows no prompt and no command: it is told to."""
    shown = [word for line in typed for word in ("-ex", rf"echo (gdb) {line}\n", "-ex", line)]
    quiet = ["-q", "-nx", "-batch", "-ex", "set confirm off", "-ex", "set pagination off"]
    return [gdb, *quiet, *shlex.split(command)[1:3], *shown, *shlex.split(command)[3:]]


def departure(shown, printed):
    """The first line that is shown and not printed, with what was printed in its place; None without one."""
    at, anywhere = 0, False
    shown, printed = ([CHECKSUM.sub(r"\1", line) for line in lines] for lines in (shown, printed))
    for line in shown:
        if line == ANY:
            anywhere = True
            continue
        rest = printed[at:] if anywhere else printed[at:at + 1]
        if line not in rest:
            return line, printed[at:at + 3]
        at += rest.index(line) + 1
        anywhere = False
    return None if anywhere or at == len(printed) else ("the end", printed[at:at + 3])


def parts_of(shown):
    """The lines between those that stand for any."""
    parts = [[]]
    for line in shown:
        if line == ANY:
            parts.append([])
        else:
            parts[-1].append(line)
    return parts


def likeness(lines, others):
    return sum(SequenceMatcher(None, line, other).ratio() for line, other in zip(lines, others))


def renewed(shown, printed):
    """What is printed, with lines left out where they were: each part as long as it was, and where it is most alike."""
    if departure(shown, printed) is None:
        return shown
    first, *others = parts_of(shown)
    if not others:
        return printed
    found, at = printed[:len(first)], len(first)
    for number, lines in enumerate(others):
        last = len(printed) - len(lines)
        if number < len(others) - 1:
            at = max(range(at, max(at, last) + 1), key=lambda start: likeness(lines, printed[start:]))
        elif lines:
            at = max(at, last)
        found += [ANY, *printed[at:at + len(lines)]]
        at += len(lines)
    return found


@dataclass
class Transcript:
    guide: Path
    command: str
    shown: list
    printed: list

    def departure(self):
        found = departure(self.shown, self.printed)
        return found and f"{self.guide.name}: $ {self.command}: shown: {found[0]}  now: {' / '.join(found[1])}"


class Runner:
    """Runs the commands of a guide in a folder of its own."""

    def __init__(self, programs, gdb, folder):
        self.path, self.gdb, self.folder = f"{programs}{os.pathsep}{os.environ['PATH']}", gdb, Path(folder)
        for name in ("host_sim", "tools"):
            (self.folder / name).symlink_to(ROOT / name)
        (self.folder / "build").mkdir()
        (self.folder / "build/host").symlink_to(programs)

    def output(self, command, typed):
        text = None
        if command.startswith("gdb "):
            command = gdb_command(self.gdb, command, typed)
        elif typed:
            command, text = f"{command} --script -", "".join(f"{line}\n" for line in typed)
        done = subprocess.run(command, shell=isinstance(command, str), cwd=self.folder, input=text, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=os.environ | {"PATH": self.path})
        lines = done.stdout.replace(f"{ROOT}/", "").splitlines()
        return [line.rstrip() for line in lines if not PROGRESS.fullmatch(line)]

    def block(self, guide, block):
        for command, shown in commands(block):
            typed = [match[2] for match in map(TYPED.match, shown) if match]
            yield Transcript(guide, command, shown, self.output(command, typed))

    def guide(self, guide):
        """The transcripts of each block, and the block."""
        text = guide.read_text(encoding="utf-8")
        for written, name in FILE.findall(text):
            (self.folder / name).write_text(written, encoding="utf-8")
        for block in BLOCK.findall(text):
            yield block, list(self.block(guide, block))


def run(programs, gdb):
    """(guide, block, its transcripts) of all guides."""
    for guide in guides():
        with tempfile.TemporaryDirectory() as folder:
            for block, transcripts in Runner(programs, gdb, folder).guide(guide):
                yield guide, block, transcripts


def write(guide, block, transcripts):
    lines = [line for one in transcripts for line in (f"$ {one.command}", *renewed(one.shown, one.printed))]
    anew = "".join(f"{line}\n" for line in lines)
    guide.write_text(guide.read_text(encoding="utf-8").replace(f"```console\n{block}```\n", f"```console\n{anew}```\n"),
                     encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=Path, metavar="PROGRAMS", help="folder of the programs")
    parser.add_argument("gdb", metavar="GDB", help="the debugger")
    parser.add_argument("--write", action="store_true", help="write the outputs anew")
    args = parser.parse_args()
    found = []
    for guide, block, transcripts in run(args.programs.resolve(), args.gdb):
        departures = [said for one in transcripts if (said := one.departure())]
        found += departures
        if args.write and departures:
            write(guide, block, transcripts)
    if found and not args.write:
        sys.exit("\n".join(found))


if __name__ == "__main__":
    main()
