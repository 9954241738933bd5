# SPDX-License-Identifier: MIT
"""programs.completion: what a shell offers behind a begun command line, and what a misspelt one is answered.

test_completion.py MOTORSIM NFCONFIG
"""

import subprocess
import sys
import unittest
from pathlib import Path

MOTORSIM, NFCONFIG = sys.argv[1:]
BAD_INPUT = 2
# A shell calls the function that it was given with these two variables; here for the last word of the line.
BASH = 'source <("$1" --completion bash); COMP_WORDS=("$@"); ' \
       'COMP_CWORD=$(($# - 1)); _"$(basename "$1")" 2>/dev/null; printf "%s\\n" "${COMPREPLY[@]}"'


def offered(*line, program=MOTORSIM):
    """What bash offers for the last word of a line."""
    shown = subprocess.run(["bash", "-c", BASH, "bash", program, *line], capture_output=True, text=True, check=True)
    return shown.stdout.split()


def refusal(*line, program=MOTORSIM):
    done = subprocess.run([program, *line], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


class Completion(unittest.TestCase):
    def test_a_first_word_is_a_command(self):
        self.assertEqual(["run", "replay"], offered("r"))
        self.assertIn("identify", offered(""))

    def test_a_dash_is_an_option_of_the_command_before_it(self):
        self.assertEqual(["--trace", "--trace-prelude"], offered("run", "s1", "--tr"))
        self.assertNotIn("--trace", offered("bench", "--"))

    def test_a_name_is_one_of_the_files_of_its_kind(self):
        motors = offered("run", "any", "--motor", "motor_")
        self.assertLessEqual({"motor_a", "motor_b"}, set(motors))
        self.assertTrue(all(motor.startswith("motor_") for motor in motors), motors)
        self.assertIn("s1", offered("run", ""))
        self.assertIn("any", offered("show", "--motor", "motor_a", "--tuning", "", program=NFCONFIG))

    def test_a_setting_is_completed_up_to_its_value(self):
        self.assertEqual(["plant.flux_scale="], offered("run", "s1", "--set", "plant.fl"))

    def test_a_word_of_few_is_one_of_them(self):
        self.assertEqual(["motor"], offered("keys", "mot", program=NFCONFIG))

    def test_behind_a_name_a_second_scenario_is_not_offered(self):
        self.assertEqual([], offered("run", "s1", "s"))

    def test_where_a_file_is_expected_the_shell_is_left_to_offer_it(self):
        self.assertEqual([], offered("run", "s1", "--trace", ""))
        self.assertEqual([], offered("replay", ""))

    def test_a_command_line_that_is_wrong_already_offers_something_or_nothing_but_does_not_fail(self):
        for line in (["nonsense", ""], ["run", "--nonsense", ""], ["run", "s1", "--set"], ["--"], ["-"], ["run", "\u00e4 'b"]):
            with self.subTest(line=line):
                offered(*line)

    def test_zsh_is_offered_the_same(self):
        stub = 'compdef() { :; }; compadd() { while [[ $1 == -* ]]; do [[ $1 == -S ]] && shift; shift; done; print -l -- "$@"; }; ' \
               '_files() { print files; }; source <("$1" --completion zsh); words=("$@"); CURRENT=$#; _motorsim'
        for line in (["r"], ["run", "s1", "--set", "plant.fl"], ["run", "any", "--motor", "motor_"]):
            with self.subTest(line=line):
                shown = subprocess.run(["zsh", "-f", "-c", stub, "zsh", MOTORSIM, *line], capture_output=True, text=True, check=True)
                self.assertEqual(offered(*line), shown.stdout.split())
        shown = subprocess.run(["zsh", "-f", "-c", stub, "zsh", MOTORSIM, "replay", ""], capture_output=True, text=True, check=True)
        self.assertEqual(["files"], shown.stdout.split())


class Misspelt(unittest.TestCase):
    def test_a_misspelt_word_is_answered_with_the_one_that_was_meant(self):
        for line, meant, program in ((["rn", "any"], "run", MOTORSIM), (["run", "any", "--mtor", "motor_b"], "--motor", MOTORSIM),
                                     (["identfy"], "identify", MOTORSIM), (["shw"], "show", NFCONFIG),
                                     (["header", "--bord=x"], "--board", NFCONFIG)):
            with self.subTest(line=line):
                status, out, err = refusal(*line, program=program)
                self.assertEqual((BAD_INPUT, "", 1), (status, out, err.count("\n")))
                self.assertIn(f"did you mean {meant}?", err)

    def test_what_is_like_no_word_gets_no_guess(self):
        for line in (["x" * 300], ["qqqqqq"], ["run", "any", "--"]):
            with self.subTest(line=line):
                self.assertNotIn("did you mean", refusal(*line)[2])


if __name__ == "__main__":
    unittest.main(argv=[Path(sys.argv[0]).name, "-v"])
