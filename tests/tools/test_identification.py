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
from identification import cli, motor, peers, table

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


def peer_result(peer, name, seed=1, **changed):
    return result(**changed) | {"motor": peer.name, "set": name, "seed": seed}


class PeersTable(unittest.TestCase):
    def test_a_row_has_the_largest_error_and_the_median_bar(self):
        results = [result(off=0.004, bar=bar, inertia_kg_m2=entry(1.9, 0.03, 2.0)) for bar in (0.01, 0.012, 0.04)]
        results[1] |= {"resistance_ohm": entry(0.992, 0.012, 1.0)}
        self.assertEqual("| hub |" + " 0.8 (± 1.2) % |" + " 0.4 (± 1.2) % |" * 3 + " 5 (± 1.5) % |", peers.row("hub", results))

    def test_each_motor_has_a_row_for_each_set_and_one_of_the_other_project(self):
        text = peers.lines(peers.PEERS, [peer_result(peer, name) for peer in peers.PEERS for name in peers.SETS])
        self.assertEqual(2 + len(peers.PEERS) * (len(peers.SETS) + 1), len(text))
        self.assertEqual({2 + len(peers.KEYS)}, {line.count("|") for line in text})
        self.assertEqual("| hub motor, 250 W, phobia | 0.86 % | 0.36 % | 0.29 % | 0.45 % | 0.65 % |", text[10])

    def test_a_motor_that_one_seed_refuses_has_no_numbers(self):
        results = [result(), {"refusal": "identify refused: the rotor is stuck"}]
        self.assertEqual("| hub |" + " refused |" * 5, peers.row("hub", results))


class PeersCommand(FolderTest):
    def called(self, *words):
        out, err = StringIO(), StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = peers.main([*words, "--out", str(self.folder)])
        return status, out.getvalue(), err.getvalue()

    def test_a_program_that_is_not_there_is_named(self):
        status, _, err = self.called("--motorsim", "/nowhere/motorsim")
        self.assertEqual(peers.BAD_INPUT, status)
        self.assertEqual("measure_peers: /nowhere/motorsim: no program; run tools/dev build\n", err)

    def test_a_motor_that_is_none_is_named(self):
        status, out, err = self.called("hub_250w", "hub_251w")
        self.assertEqual((peers.BAD_INPUT, ""), (status, out))
        self.assertEqual("measure_peers: hub_251w: no such motor; expected xnova_4530, rotomax_120, hub_250w, qs_138\n", err)

    def test_each_file_that_it_names_is_there(self):
        names = [peer.name for peer in peers.PEERS] + [peer.supply for peer in peers.PEERS if peer.supply]
        for name in (*names, *peers.SETS, "board"):
            self.assertTrue((peers.FILES / f"{name}.toml").is_file(), name)

    def test_the_refusal_of_a_motor_is_its_result(self):
        program = self.write("motorsim", "#!/bin/sh\necho identify refused: the rotor is stuck >&2\nexit 1\n")
        program.chmod(0o755)
        status, out, _ = self.called("hub_250w", "--motorsim", str(program))
        self.assertEqual(peers.REFUSED, status)
        self.assertIn("hub_250w, as there, seed 5: identify refused: the rotor is stuck", out)

    def test_a_number_of_seeds_that_is_none_is_refused(self):
        for word in ("0", "-1", "x", "100"):
            with self.assertRaises(SystemExit), redirect_stderr(StringIO()) as err:
                peers.parser().parse_args(["--seeds", word])
            self.assertIn("expected a whole number from 1 to 99", err.getvalue())


class Peer(FolderTest):
    """The one of least inductance, 3 µH at 48 V, with both sets."""

    def test_each_value_meets_its_goal(self):
        with redirect_stdout(StringIO()):
            self.assertEqual(peers.DONE, peers.main(["xnova_4530", "--seeds", "1", "--motorsim", str(MOTORSIM),
                                                     "--out", str(self.folder)]))
        results = [json.loads((self.folder / f"xnova_4530_{name}_1.json").read_text(encoding="utf-8")) for name in peers.SETS]
        for value in peers.compared():
            worst = max(error for error, _ in table.errors(value, results))
            self.assertLessEqual(worst, value.goal, value.title)


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
