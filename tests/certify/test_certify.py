# SPDX-License-Identifier: MIT
"""certify.command: `motorsim certify` as its users meet it."""

import json
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
ALL_LOCKED, NOT_ALL, BAD_INPUT = 0, 1, 2
ROOT = Path(__file__).resolve().parents[2]
MOTOR_A = (ROOT / "host_sim/motors/motor_a.toml").read_text(encoding="utf-8")
KEYS = """motor board notes seed runs runs_planned box tunings recommended why limiting draws""".split()
FEW = ("--runs", "3", "--tuning", "any")

# Twice the standard deviation is the bar: φ 1 % and 60 %.
BARS = """
[measured]
resistance_std_pct = {pct}
inductance_d_std_pct = {pct}
inductance_q_std_pct = {pct}
flux_linkage_std_pct = {pct}
inertia_std_pct = {pct}
"""


def wait_until_caught(process, number):
    """Until the process would end by this signal no more."""
    mask = "0"
    while not int(mask, 16) >> (number - 1) & 1:
        time.sleep(0.01)
        status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
        mask = re.search(r"^SigCgt:\s*(\w+)", status, re.MULTILINE)[1]


class Certify(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def certify(self, *args):
        return subprocess.run([MOTORSIM, "certify", *map(str, args)], cwd=self.folder, text=True, capture_output=True,
                              check=False)

    def found(self, *args):
        done = self.certify(*args, "--json", "-")
        self.assertIn(done.returncode, (ALL_LOCKED, NOT_ALL), done.stderr)
        return json.loads(done.stdout), done.returncode

    def motor(self, pct):
        path = self.folder / f"bars_{pct}.toml"
        path.write_text(MOTOR_A + BARS.format(pct=pct), encoding="utf-8")
        return path

    def refused(self, *args):
        done = self.certify(*args)
        self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
        self.assertEqual((done.stdout, len(done.stderr.splitlines())), ("", 1), done.stderr)
        return done.stderr


class Results(Certify):
    def test_motor_a_is_locked_and_the_table_says_what_was_assumed(self):
        done = self.certify("motor_a", *FEW)
        self.assertEqual(done.returncode, ALL_LOCKED, done.stderr)
        self.assertIn("3 of 3 machines are locked with the tuning any", done.stdout)
        self.assertRegex(done.stdout, r"resistance R +1\.91\d +2\.33\d +ohm +typical")

    def test_json_has_everything(self):
        found, _ = self.found("motor_a", *FEW)
        self.assertEqual(list(found), KEYS)
        axes = [axis["key"] for axis in found["box"]]
        self.assertEqual(len(found["draws"]), 3)
        for draw in found["draws"]:
            self.assertEqual(list(draw["draw"]), axes)
        self.assertEqual(found["tunings"]["any"]["locked"], 3)

    def test_the_same_seed_gives_the_same_bytes_and_another_one_others(self):
        one, again, other = (self.certify("motor_a", *FEW, "--seed", seed, "--json", "-").stdout for seed in (1, 1, 2))
        self.assertEqual(one, again)
        self.assertNotEqual(one, other)

    def test_more_runs_begin_with_the_same_ones(self):
        fewer, more = (self.found("motor_a", "--tuning", "any", "--runs", runs)[0]["draws"] for runs in (1, 2))
        self.assertEqual(fewer, more[:1])

    def test_wide_bars_are_certified_lower_than_narrow_ones(self):
        (narrow, good), (wide, bad) = (self.found(self.motor(pct), "--tuning", "any", "--runs", 10) for pct in (0.5, 30))
        self.assertEqual((good, bad), (ALL_LOCKED, NOT_ALL))
        self.assertLess(wide["tunings"]["any"]["locked"], narrow["tunings"]["any"]["locked"])
        self.assertEqual({axis["from"] for axis in narrow["box"] if axis["key"] == "motor.resistance_ohm"}, {"measured"})

    def test_a_motor_of_the_zoo_brings_its_board(self):
        found, _ = self.found("zoo:3", "--tuning", "any", "--runs", 1)
        self.assertIn("servo", found["motor"])

    def test_a_tuning_that_loses_is_not_recommended(self):
        found, _ = self.found("motor_a", "--tuning", "published", "--tuning", "any", "--runs", 3)
        self.assertEqual(found["recommended"], "any")
        self.assertLess(found["tunings"]["published"]["locked"], 3)


class Page(Certify):
    def test_it_is_written_beside_the_table_and_nothing_is_overwritten_unasked(self):
        done = self.certify("motor_a", *FEW, "-o", "a.html")
        page = (self.folder / "a.html").read_text(encoding="utf-8")
        self.assertIn("locked", done.stdout)
        self.assertTrue(page.startswith("<!DOCTYPE html>"))
        self.assertTrue(page.endswith("</html>\n"))
        for elsewhere in ("http", "src=", "href=", "url("):
            self.assertNotIn(elsewhere, page)
        self.assertIn("a.html: is there already; --overwrite", self.refused("motor_a", *FEW, "-o", "a.html"))
        self.assertEqual(self.certify("motor_a", *FEW, "-o", "a.html", "--overwrite").returncode, ALL_LOCKED)
        self.assertEqual((self.folder / "a.html").read_text(encoding="utf-8"), page)

    def test_it_never_replaces_what_was_read(self):
        own = self.motor(1)
        self.assertIn("--output: ", self.refused(own, *FEW, "-o", own, "--overwrite"))
        self.assertIn("--json: ", self.refused(own, *FEW, "--json", own))
        self.assertIn("same file", self.refused(own, *FEW, "-o", "x", "--json", "x"))
        self.assertFalse((self.folder / "x").exists())


class Refusals(Certify):
    def test_bad_input_is_one_line(self):
        for args, message in (
                ((), "motor is required"),
                (("motor_aa",), "did you mean motor_a?"),
                (("motor_a", "--runs", "0"), "--runs"),
                (("motor_a", "--runs", "many"), "--runs"),
                (("motor_a", "--seed", "-1"), "--seed"),
                (("motor_a", "--tuning", "anyy"), "did you mean any?"),
                (("motor_a", "--board", "nowhere.toml"), "nowhere.toml"),
                (("motor_a", "--set", "motor.mass_kg=3"), "mass_kg"),
                (("motor_a", "--board", "b_g431b_esc1"), "motor.max_speed_rpm"),
                (("zoo:17:user",), "zoo")):
            with self.subTest(args):
                self.assertIn(message, self.refused(*args))

    def test_a_name_plate_is_told_what_to_do(self):
        plate = self.folder / "plate.toml"
        plate.write_text('[motor]\nname = "plate"\npole_pairs = 2\nmax_speed_rpm = 2000\nmax_current_a = 10\n'
                         "continuous_current_a = 8\n", encoding="utf-8")
        self.assertIn("motorsim identify", self.refused(plate))


class Interrupted(Certify):
    def test_it_reports_on_the_runs_so_far(self):
        with subprocess.Popen([MOTORSIM, "certify", "motor_a", "--runs", "100000"], cwd=self.folder, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
            wait_until_caught(running.pid, signal.SIGINT)
            running.send_signal(signal.SIGINT)
            text, _ = running.communicate()
        self.assertIn(running.returncode, (ALL_LOCKED, NOT_ALL))
        self.assertRegex(text, r"It was stopped after \d+ of 100000 runs\.")

    def test_without_a_terminal_each_quarter_of_many_runs_is_a_line(self):
        with subprocess.Popen([MOTORSIM, "certify", "motor_a", "--runs", "100"], cwd=self.folder, text=True,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as running:
            self.assertEqual(running.stderr.readline(), "motorsim: 25 of 100 runs\n")
            running.send_signal(signal.SIGINT)
            running.communicate()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
