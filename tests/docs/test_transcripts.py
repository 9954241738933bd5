# SPDX-License-Identifier: MIT
"""docs.transcripts: the transcripts in the guides are what the programs print today.

test_transcripts.py PROGRAMS GDB     PROGRAMS: the folder that has motorsim, nfconfig and gaindesign

A transcript is a block of a guide that is marked `console`. A line that begins with `$ ` is a command. Lines that begin
with a prompt in brackets are typed into the program of the command before: the stepper, or gdb. All others are output; a line
`...` stands for any number of lines. The blocks of a guide run one after the other in one folder. A block that is marked `toml`
and begins with `# NAME.toml` is written there as that file, before them.
"""
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAMS, GDB = Path(sys.argv[1]).resolve(), sys.argv[2]
ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"^```toml\n(# ([\w.]+\.toml)\n.*?)^```$", re.MULTILINE | re.DOTALL)
TYPED = re.compile(r"^(\([^)]+\)) (.+)$")


def guides():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def commands(block):
    """Each command of a block with what it prints, and what is typed into it."""
    found = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append((line.removeprefix("$ "), [], []))
        else:
            _, printed, typed = found[-1]
            printed.append(line)
            if match := TYPED.match(line):
                typed.append(match[2])
    return found


def gdb_command(command, typed):
    """gdb without a terminal shows no prompt and no command: it is told to."""
    shown = [word for line in typed for word in ("-ex", rf"echo (gdb) {line}\n", "-ex", line)]
    quiet = ["-q", "-nx", "-batch", "-ex", "set confirm off", "-ex", "set pagination off"]
    return [GDB, *quiet, *shlex.split(command)[1:3], *shown, *shlex.split(command)[3:]]


def run(command, typed, folder):
    program = command.split(" ")[0]
    text = None
    if program == "gdb":
        command = gdb_command(command, typed)
    elif typed:
        command, text = f"{command} --script -", "".join(f"{line}\n" for line in typed)
    path = f"{PROGRAMS}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(command, shell=isinstance(command, str), cwd=folder, input=text, text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=os.environ | {"PATH": path})
    return [line.rstrip() for line in done.stdout.replace(f"{ROOT}/", "").splitlines()]


def departure(shown, printed):
    """The first line that is shown and not printed, with what was printed in its place; None without one."""
    at, anywhere = 0, False
    for line in shown:
        if line == "...":
            anywhere = True
            continue
        rest = printed[at:] if anywhere else printed[at:at + 1]
        if line not in rest:
            return line, printed[at:at + 3]
        at += rest.index(line) + 1
        anywhere = False
    return None if anywhere or at == len(printed) else ("the end", printed[at:at + 3])


class Transcripts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for name in ("host_sim", "tools"):
            (self.folder / name).symlink_to(ROOT / name)
        (self.folder / "build").mkdir()
        (self.folder / "build/host").symlink_to(PROGRAMS)

    def test_each_command_prints_what_the_guide_shows(self):
        for guide in guides():
            text = guide.read_text(encoding="utf-8")
            for written, name in FILE.findall(text):
                (self.folder / name).write_text(written, encoding="utf-8")
            for block in BLOCK.findall(text):
                for command, shown, typed in commands(block):
                    with self.subTest(guide=guide.name, command=command):
                        self.assertIsNone(departure(shown, run(command, typed, self.folder)))


class TheTest(unittest.TestCase):
    def test_a_line_that_is_not_printed_is_found(self):
        self.assertIsNone(departure(["a", "...", "d"], ["a", "b", "c", "d"]))
        self.assertEqual(departure(["a", "...", "e"], ["a", "b", "d"]), ("e", ["b", "d"]))
        self.assertEqual(departure(["a", "c"], ["a", "b", "c"]), ("c", ["b", "c"]))
        self.assertEqual(departure(["a"], ["a", "b"]), ("the end", ["b"]))
        self.assertIsNone(departure(["a", "..."], ["a"]))

    def test_there_are_transcripts(self):
        found = [block for guide in guides() for block in BLOCK.findall(guide.read_text(encoding="utf-8"))]
        self.assertGreater(len(found), 4)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
