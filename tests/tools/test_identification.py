# SPDX-License-Identifier: MIT
"""Identifications of many motors: the table, the command, and a dozen motors from end to end."""

import json
import os
import unittest
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from support import TOOLS, FolderTest
from identification import cli, motor, table

MOTORSIM = Path(os.environ.get("NF_MOTORSIM", TOOLS.parent / "build/host/motorsim"))
SEED, MOTORS = 12, 12
# Of any motor's value in goals of the 95th percentile, as it is the worst of a dozen.
WORST = 2
INSIDE_PCT = 90     # 95 % are expected, and 96 values are few
LONGEST_S = 22


def entry(value, bar, truth):
    return {"value": value, "bar": bar, "truth": truth}


def result(off=0.01, bar=0.02, **changed):
    found = {value.key: entry(1 + off, bar, 1.0) for value in table.VALUES}
    return {"motor": "zoo:0@1:user", "refusal": None, "duration_s": 15.0} | found | changed


class Table(unittest.TestCase):
    def test_a_row_has_the_95th_percentile_the_medians_and_the_share_within(self):
        results = [result(off=k / 1000, bar=0.0205) for k in range(100)]
        self.assertEqual("| R | 2 % | 9.5 % | 4.9 % | 2.1 % | 21.0 % |", table.row(table.VALUES[0], results))

    def test_a_time_is_in_ns(self):
        self.assertIn("| 1e+07 ns |", table.row(table.VALUES[5], [result()]))

    def test_a_value_whose_truth_is_zero_has_no_relative_error(self):
        self.assertEqual([], table.errors(table.VALUES[-1], [result(coulomb_friction_nm=entry(1, 1, 0))]))

    def test_a_motor_that_was_refused_is_named(self):
        refused = {"motor": "zoo:1@1:user", "refusal": "identify refused: the rotor is stuck"}
        text = table.summary([result(), refused])
        self.assertIn("1 of 2 motors measured", text[0])
        self.assertIn("zoo:1@1:user: identify refused: the rotor is stuck", text)

    def test_a_run_counts_as_close_only_with_both_errors_small(self):
        run = {"locked": True, "speed_error_command_pct": 5.0, "speed_error_load_pct": 2.1}
        self.assertIn("1 of 1 locked when run with the result, 0 within", table.summary([result(run=run)])[1])


class Command(FolderTest):
    def called(self, *words):
        out, err = StringIO(), StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = cli.main([*words, "--out", str(self.folder)])
        return status, out.getvalue(), err.getvalue()

    def test_a_program_that_is_not_there_is_named(self):
        status, _, err = self.called("--motorsim", "/nowhere/motorsim")
        self.assertEqual(cli.BAD_INPUT, status)
        self.assertEqual("measure_zoo: /nowhere/motorsim: no program; run tools/dev build\n", err)

    def test_a_number_of_motors_that_is_none_is_refused(self):
        for word in ("0", "-1", "x", "1.5"):
            with self.assertRaises(SystemExit), redirect_stderr(StringIO()) as err:
                cli.parser().parse_args(["--motors", word])
            self.assertIn("expected a whole number from 1 to 999999", err.getvalue())


class Motors(unittest.TestCase):
    """Off their files as users' motors are, with saturated iron and half or one and a half times the dead time."""

    @classmethod
    def setUpClass(cls):
        with TemporaryDirectory() as folder, redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            cls.status = cli.main(["--seed", str(SEED), "--motors", str(MOTORS), "--motorsim", str(MOTORSIM), "--out", folder])
            cls.results = [json.loads(Path(folder, f"{k}.json").read_text(encoding="utf-8")) for k in range(MOTORS)]

    def test_all_are_measured_without_a_fault(self):
        self.assertEqual(cli.DONE, self.status)
        self.assertEqual([], [each["refusal"] for each in self.results if each["refusal"]])

    def test_no_value_is_far_off(self):
        for value in table.VALUES:
            if value.goal is not None:
                worst = max(error for error, _ in table.errors(value, self.results))
                self.assertLessEqual(worst, WORST * value.goal, value.title)

    def test_the_truth_lies_within_the_bars(self):
        self.assertGreaterEqual(table.all_inside_pct(self.results), INSIDE_PCT)

    def test_it_takes_no_longer_than_said(self):
        self.assertLessEqual(max(each["duration_s"] for each in self.results), LONGEST_S)

    def test_the_drive_holds_them_with_the_results(self):
        self.assertEqual([True] * MOTORS, [each["run"]["locked"] for each in self.results])

    def test_a_draw_belongs_to_the_motor(self):
        programs = motor.Programs(MOTORSIM, MOTORSIM.with_name("nfconfig"))
        self.assertEqual(motor.Motor(SEED, 3).plant(programs), motor.Motor(SEED, 3).plant(programs))
        self.assertNotEqual(motor.Motor(SEED, 3).plant(programs), motor.Motor(SEED, 4).plant(programs))


if __name__ == "__main__":
    unittest.main()
