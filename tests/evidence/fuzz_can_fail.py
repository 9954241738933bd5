# SPDX-License-Identifier: MIT
"""evidence.fuzz_can_fail: fuzzing finds a fault in each kind of input in the time that it has, and has to have happened.

Each fault alone is put into a copy of one source; its object is linked before the libraries, which hold the good one.
"""

import json
import shlex
import subprocess
import tempfile
import unittest
from pathlib import Path

import fuzz
from part import ROOT

SAID = """
#100	INITED cov: {edges} ft: 2000 corp: 90/9Kb exec/s: 0 rss: 50Mb
#{runs}	DONE   cov: {edges} ft: 3000 corp: 95/9Kb lim: 4096 exec/s: 99 rss: 60Mb
Done {runs} runs in {seconds} second(s)
"""
# A state out of its range ends in a table's index or in a shift, whichever the inputs find first.
A_WILD_WORD = "runtime error: |AddressSanitizer: SEGV"
# What, and the program, source, text and fault; what the finding says, as a regular expression.
FAULTS = {
    "an index out of its array": (
        "drive", "firmware/protect/supervision.c",
        "phase < SUPERVISION_PHASES; phase++) {\n        note_phase",
        "phase <= SUPERVISION_PHASES; phase++) {\n        note_phase", "runtime error: index 3"),
    "a word beyond its range": (
        "drive", "firmware/drive/tick.c", "drive->bus = sample.bus;", "drive->bus = 2 * sample.bus;", r"\bbus\b"),
    "a text that the TOML reader does not survive": (
        "config", "host_sim/config/text_guard.cpp", "static_cast<unsigned char>(c) >= 0x80", "c == 0x7F", "unreachable program point"),
    "a recording whose state is not looked at": (
        "recording", "host_sim/replay/recording.cpp", "state_problem(state, cfg); !bad.empty()",
        "state_problem(state, cfg); bad.size() > 1000", A_WILD_WORD),
    "a refusal that nobody catches": (
        "stepper", "host_sim/debug/set.cpp", 'throw std::runtime_error(fmt::format("NAME = VALUE',
        'throw std::logic_error(fmt::format("NAME = VALUE', "deadly signal"),
    "a line longer than its buffer": (
        "console", "firmware/app/console.c", "console->length < CONSOLE_LINE_MAX", "console->length < TEXT_MAX",
        "index 32 out of bounds"),
}


def command_of(source):
    """How the source is compiled."""
    commands = json.loads((fuzz.FOLDER / "compile_commands.json").read_text(encoding="utf-8"))
    return next(shlex.split(one["command"]) for one in commands if one["file"] == str(source))


def link(name, faulty, program):
    """The program with the faulty object in place of its own, and before its libraries."""
    said = subprocess.run(["ninja", "-C", fuzz.FOLDER, "-t", "commands", f"tests/fuzz/fuzz_{name}"],
                          check=True, capture_output=True, text=True).stdout.splitlines()[-1]
    words = [word for word in shlex.split(said) if word not in (":", "&&") and not word.endswith(f"/{faulty.name}")]
    at = words.index("-o")
    words[at:at + 2] = [str(faulty), "-o", str(program)]
    subprocess.run(words, cwd=fuzz.FOLDER, check=True)


def build(folder, name, path, text, fault):
    """The program with a fault."""
    good = ROOT / path
    source = good.read_text(encoding="utf-8")
    if source.count(text) != 1:
        raise AssertionError(f"{path} has not once: {text}")
    copy, faulty = folder / good.name, folder / f"{good.name}.o"
    copy.write_text(source.replace(text, fault), encoding="utf-8")
    command = command_of(good)
    command[command.index("-o") + 1] = str(faulty)
    command[command.index("-c") + 1] = str(copy)
    subprocess.run(command, cwd=fuzz.FOLDER, check=True)
    link(name, faulty, folder / "program")
    return folder / "program"


class FuzzHasToHappen(unittest.TestCase):
    ASKED = fuzz.PROGRAMS["drive"]
    INVENTED = ASKED.seconds * ASKED.rate

    def kept(self, said, status=0):
        """Whether each figure of one run is."""
        return [figure["ok"] for figure in fuzz.figures_of([fuzz.outcome("drive", status, said)])]

    def said(self, edges=ASKED.edges, invented=INVENTED, seconds=ASKED.seconds):
        return SAID.format(edges=edges, runs=100 + invented, seconds=seconds)

    def test_what_meets_the_thresholds_just_so_is_kept_and_less_or_no_word_is_not(self):
        """An input, an edge or a second less; a program that only reads its corpus."""
        self.assertEqual(self.kept(self.said()), [True, True])
        for less in ({"invented": self.INVENTED - 1}, {"edges": self.ASKED.edges - 1}, {"seconds": self.ASKED.seconds - 1},
                     {"invented": 0}):
            with self.subTest(less):
                self.assertEqual(self.kept(self.said(**less)), [True, False])
        self.assertEqual(self.kept(""), [True, False])
        self.assertEqual(self.kept("", status=1), [False, False])

    def test_a_run_begins_without_what_an_earlier_one_kept(self):
        with tempfile.TemporaryDirectory() as temporary:
            old = Path(temporary) / "drive" / "old"
            old.parent.mkdir()
            old.touch()
            fuzz.fuzz("true", "drive", 1, Path(temporary))
            self.assertFalse(old.exists())


class Corpus(unittest.TestCase):
    def test_an_input_is_added_and_the_same_inputs_are_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as temporary:
            archive, crash = Path(temporary, "a.tar.xz"), Path(temporary, "crash")
            crash.write_bytes(b"\0x")
            fuzz.write(archive, {"drive/b": b"1", "drive/a": b"2"})
            before = archive.read_bytes()
            fuzz.write(archive, {"drive/a": b"2", "drive/b": b"1"})
            self.assertEqual(archive.read_bytes(), before)
            self.assertEqual(fuzz.keep(archive, "drives", crash), 2)
            self.assertEqual(archive.read_bytes(), before)
            self.assertEqual(fuzz.keep(archive, "drive", crash), 0)
            self.assertIn(b"\0x", fuzz.inputs(archive).values())


class FuzzCanFail(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if fuzz.build():
            raise AssertionError("the programs are not built")

    def test_each_fault_is_found(self):
        for what, (name, path, text, fault, said) in FAULTS.items():
            with self.subTest(what), tempfile.TemporaryDirectory() as temporary:
                folder = Path(temporary)
                program = build(folder, name, path, text, fault)
                one = fuzz.fuzz(program, name, fuzz.PROGRAMS[name].seconds, folder / "kept")
                self.assertTrue(one.why, "not found")
                self.assertRegex(one.why, said)
                self.assertTrue(Path(one.kept).is_file(), one.kept)


if __name__ == "__main__":
    unittest.main()
