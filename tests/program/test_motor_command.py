# SPDX-License-Identifier: MIT
"""programs.motor: `motorsim motor` as its users meet it, with a terminal and without one.

test_motor_command.py MOTORSIM NFCONFIG
"""

import os
import pty
import select
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

MOTORSIM, NFCONFIG = sys.argv[1:]
DONE, BAD_INPUT = 0, 2
SILENCE_S = 30  # far longer than an answer takes
# In the order in which they are asked for.
SHEET = {
    "--name": "EC 45 flat",
    "--poles": "16",
    "--resistance": "0.608 ohm phase to phase",
    "--inductance": "0.463 mH phase to phase",
    "--torque-constant": "36.9 mN.m/A six-step",
    "--rated-speed": "4000 rpm",
    "--rated-torque": "128 mN.m",
    "--max-current": "6 A peak",
    "--inertia": "181 g.cm2",
    "--no-load": "234 mA 6110 rpm",
}


def words(values):
    return [word for pair in values.items() for word in pair]


def run(*arguments):
    return subprocess.run([MOTORSIM, "motor", *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          check=False)


class Terminal:
    """A person at a terminal, who answers what is asked."""

    def __init__(self, *arguments):
        self.here, there = pty.openpty()
        self.process = subprocess.Popen([MOTORSIM, "motor", *map(str, arguments)], stdin=there, stderr=there,
                                        stdout=subprocess.PIPE, text=True)
        os.close(there)

    def until_question(self):
        """What is printed up to a question, or to the end."""
        shown = ""
        while not shown.endswith(": "):
            if not select.select([self.here], [], [], SILENCE_S)[0]:
                raise AssertionError(f"neither a question nor an end: {shown}")
            try:
                shown += os.read(self.here, 4096).decode()
            except OSError:  # what reading gives when nobody is at the other end
                break
        return shown

    def type(self, line):
        os.write(self.here, f"{line}\n".encode())

    def end_input(self):
        os.write(self.here, b"\x04")

    def end(self):
        shown = self.until_question()
        out, _ = self.process.communicate(timeout=SILENCE_S)
        os.close(self.here)
        return self.process.returncode, out, shown


class WithoutTerminal(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = Path(folder.name) / "motor.toml"

    def assert_one_line(self, done):
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (BAD_INPUT, "", 1), done.stderr)

    def test_the_file_is_taken_by_the_other_programs(self):
        done = run(*words(SHEET), "-o", self.file)
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertIn(f"{self.file}: written", done.stdout)
        shown = subprocess.run([NFCONFIG, "show", "--motor", self.file, "--board", "b_g431b_esc1"], capture_output=True, text=True,
                               check=False)
        self.assertEqual(shown.returncode, DONE, shown.stderr)
        self.assertRegex(shown.stdout, r"derating.current_max .* 6\.0")

    def test_without_a_file_to_write_it_is_printed(self):
        printed, _ = run(*words(SHEET)), run(*words(SHEET), "-o", self.file)
        self.assertEqual(printed.stdout, self.file.read_text())

    def test_a_file_that_is_there_is_replaced_only_when_that_is_said(self):
        self.file.write_text("of yesterday")
        self.assert_one_line(run(*words(SHEET), "-o", self.file))
        self.assertEqual(self.file.read_text(), "of yesterday")
        self.assertEqual(run(*words(SHEET), "-o", self.file, "--overwrite").returncode, DONE)
        self.assertIn("[motor]", self.file.read_text())

    def test_one_line_names_each_option_that_is_missing(self):
        done = run()
        self.assert_one_line(done)
        for option, example in SHEET.items():
            self.assertIn(f'{option} "{example}', done.stderr)
        self.assertEqual(done.stderr.count("--inductance "), 1)
        for option in SHEET:
            with self.subTest(option):
                done = run(*words({o: v for o, v in SHEET.items() if o != option}))
                self.assert_one_line(done)
                self.assertIn(option, done.stderr)
                self.assertNotIn("--inertia" if option != "--inertia" else "--poles", done.stderr)

    def test_what_is_wrong_is_said_before_what_is_missing(self):
        for option, typed in (("--resistance", "0.6 ohm"), ("--kv", "270"), ("--no-load", "1 A"), ("--poles", "7")):
            with self.subTest(option):
                done = run(option, typed)
                self.assert_one_line(done)
                self.assertTrue(done.stderr.startswith(f'motorsim: {option} "{typed}": '), done.stderr)

    def test_an_option_that_is_given_twice_is_refused(self):
        done = run("--poles", "8", "--poles", "8")
        self.assert_one_line(done)
        self.assertIn("--poles", done.stderr)

    def test_remarks_are_said_and_stand_in_the_file(self):
        done = run(*words(SHEET), "--kv", "200 rpm/V six-step", "-o", self.file)
        self.assertIn("note: --kv", done.stderr)
        self.assertIn("# note: --kv", self.file.read_text())

    def test_a_control_character_stays_out_of_message_and_file(self):
        for option, typed in (("--resistance", "0.6 ohm phase\n[motor]"), ("--name", "a\nb"), ("--kv", "\x1b[2J 3")):
            with self.subTest(option):
                done = run(*words({**SHEET, option: typed}))
                self.assert_one_line(done)
                self.assertNotIn("\x1b", done.stderr)


class AtATerminal(unittest.TestCase):
    def test_each_value_is_asked_for_with_an_example(self):
        terminal = Terminal()
        for typed in SHEET.values():
            question = terminal.until_question()
            self.assertIn("as ", question)
            terminal.type(typed)
        status, out, _ = terminal.end()
        self.assertEqual((status, out), (DONE, run(*words(SHEET)).stdout))

    def test_only_what_is_missing_is_asked_for(self):
        terminal = Terminal(*words({o: v for o, v in SHEET.items() if o != "--max-current"}))
        self.assertIn("6 A peak", terminal.until_question())
        terminal.type("6 A peak")
        status, out, _ = terminal.end()
        self.assertEqual((status, out), (DONE, run(*words(SHEET)).stdout))

    def test_an_answer_that_cannot_be_taken_is_asked_for_again(self):
        terminal = Terminal(*words({o: v for o, v in SHEET.items() if o != "--resistance"}))
        for typed, said in (("", "does not begin with a number"), ("0.6", "has no unit"), ("0.6 ohm", 'say "phase to phase"'),
                            ("9e9 ohm phase", "is too large")):
            terminal.until_question()
            terminal.type(typed)
            shown = terminal.until_question()
            self.assertIn(said, shown)
            terminal.type("x")
        terminal.until_question()
        terminal.type(SHEET["--resistance"])
        self.assertEqual(terminal.end()[0], DONE)

    def test_the_unit_says_which_of_several_was_meant(self):
        for typed, option in (("270 rpm/V six-step", "--kv"), ("4 V/krpm six-step", "--emf-constant"),
                              ("40 mNm/A six-step", "--torque-constant")):
            with self.subTest(typed):
                terminal = Terminal(*words({o: v for o, v in SHEET.items() if o != "--torque-constant"}))
                terminal.until_question()
                terminal.type(typed)
                status, out, _ = terminal.end()
                self.assertEqual(status, DONE)
                self.assertIn(f"# {option} {typed}", out)

    def test_a_friction_that_nobody_knows_is_answered_with_0(self):
        terminal = Terminal(*words({o: v for o, v in SHEET.items() if o != "--no-load"}))
        self.assertIn("0 where nobody knows it", terminal.until_question())
        terminal.type("0")
        status, out, _ = terminal.end()
        self.assertEqual(status, DONE)
        self.assertRegex(out, "viscous_friction_nm_s = 0 +# --friction 0")

    def test_the_end_of_the_input_ends_it_and_names_what_is_missing(self):
        terminal = Terminal(*words({o: v for o, v in SHEET.items() if o != "--inertia"}))
        terminal.until_question()
        terminal.end_input()
        status, out, shown = terminal.end()
        self.assertEqual((status, out), (BAD_INPUT, ""))
        self.assertIn('--inertia "181 g.cm2"', shown)


if __name__ == "__main__":
    unittest.main(argv=[Path(sys.argv[0]).name, "-v"])
