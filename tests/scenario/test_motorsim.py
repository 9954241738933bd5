# SPDX-License-Identifier: MIT
"""motorsim as its users meet it: exit status, messages, files, from any folder."""

import csv
import functools
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
HOLDS, BROKEN, BAD_INPUT = 0, 1, 2
ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "host_sim"
RATED_RPM = 1800
MARGIN = 0.2       # of a figure that a page shows
FOUND_MARGIN = 0.03  # of a parameter, relative to the file
SETTLED_PCT = 0.5  # of the command: the metrics take a load step for recovered within as much
ROUNDING = 1e-3  # of a parameter in the firmware's numbers

METRICS = """
scenario with set notes seed speed_error_max_rpm speed_error_rms_rpm speed_error_max_pct
command_error_settled_pct angle_error_max_deg iq_error_max_a settling_time_s overshoot_pct
speed_dip_rpm recovery_time_s position_error_final_rad id_settled_a angle_error_rms_deg
speed_error_command_pct speed_error_load_pct torque_error_settled_pct ripple_speed_pct ripple_current_pct swing_speed_pct swing_current_pct swing_hz lost_time_s
locked locked_coarse limit_cycle reached faults state_final
gates_enabled_final parameters motor dimensionless saturations saturation_internal_count accepted failed_limits""".split()
COLUMNS = """
time_s state speed_command_rpm speed_rpm speed_estimated_rpm speed_reference_rpm
position_command_rad position_rad position_estimated_rad angle_el_deg angle_estimated_el_deg
angle_error_el_deg i_q_a i_q_estimated_a i_q_reference_a i_d_a i_d_estimated_a i_a_a i_b_a i_c_a
v_d_v v_q_v duty_a duty_b duty_c bus_v torque_command_nm load_torque_nm torque_nm fault""".split()
NOT_IN_GOOD_RUN = {"swing_speed_pct", "swing_current_pct", "swing_hz", "lost_time_s"}
NOT_IN_SPEED_RUN = {"position_error_final_rad", "torque_error_settled_pct", *NOT_IN_GOOD_RUN}
NOT_IN_POSITION_RUN = {"command_error_settled_pct", "torque_error_settled_pct", "speed_dip_rpm", "recovery_time_s", "speed_error_load_pct",
                       "ripple_speed_pct", "ripple_current_pct", *NOT_IN_GOOD_RUN}

SHORT = """
motor = "motor_a"
board = "bench_310v"
tuning = "published"

[scenario]
title = "a short run"
mode = "speed"
duration_s = 0.05
prelude_s = 0.04

[[scenario.command]]
time_s = 0
speed_rpm = 100

[accept.ideal]
angle_error_max_deg = {angle}
"""


# The dead time of that board takes 1.6 V at 310 V, of the 2.7 V that this motor needs for its speed: with a tenth of the dead
# time it holds.
BEYOND = {("gbm2804h", "g431_bench")}


def pair_of(motor, board):
    return "any", "--set", f"motor={motor}", "--set", f"board={board}"


def fits(motor, board):
    """Whether the configuration takes both: currents, voltage and PWM of the board are enough."""
    done = subprocess.run([MOTORSIM, "run", *pair_of(motor, board), "--set", "scenario.duration_s=0.001", "--json", "-"],
                          text=True, capture_output=True, check=False)
    return done.returncode != BAD_INPUT


@functools.cache
def pairs_that_fit():
    motors, boards = ([path.stem for path in sorted((DATA / kind).glob("*.toml"))]
                      for kind in ("motors", "boards"))
    return [(motor, board) for motor in motors for board in boards if fits(motor, board) and (motor, board) not in BEYOND]


class MotorsimTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def motorsim(self, *args):
        return subprocess.run([MOTORSIM, *map(str, args)], cwd=self.folder, text=True,
                              capture_output=True, check=False)

    def assert_status(self, status, *args):
        done = self.motorsim(*args)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def refused(self, *args):
        """The one line."""
        done = self.assert_status(BAD_INPUT, *args)
        self.assertEqual(len(done.stderr.splitlines()), 1, (args, done.stderr))
        self.assertEqual(done.stdout, "")
        return done.stderr

    def short(self, angle=10):
        path = self.folder / "short.toml"
        path.write_text(SHORT.format(angle=angle), encoding="utf-8")
        return path

    def metrics(self, *args):
        return json.loads(self.motorsim("run", *args, "--json", "-").stdout)


class Metrics(MotorsimTest):
    def test_keys_are_complete_and_do_not_depend_on_the_scenario(self):
        for scenario in ("s1", "s2", "s3"):
            self.assertEqual(list(self.metrics(scenario)), METRICS)

    def test_what_does_not_apply_is_null(self):
        null = {key for key, value in self.metrics("s2").items() if value is None}
        self.assertEqual(null, NOT_IN_SPEED_RUN | {"settling_time_s", "overshoot_pct", "speed_error_command_pct"})
        null = {key for key, value in self.metrics("s3").items() if value is None}
        self.assertEqual(null, NOT_IN_POSITION_RUN)

    def test_nothing_saturates_inside_in_the_scenarios(self):
        for scenario in ("s1", "s2", "s3", "s1_robust", "s2_robust", "s3_robust"):
            for imperfection in ("ideal", "adc"):
                metrics = self.metrics(scenario, "--with", imperfection)
                self.assertEqual(metrics["saturation_internal_count"], 0, scenario)

    def test_what_was_run_is_named(self):
        metrics = self.metrics("s1", "--with", "hot", "--with", "adc", "--set", "scenario.seed=7")
        self.assertEqual((metrics["scenario"], metrics["seed"]), ("s1", 7))
        self.assertEqual(metrics["with"], ["hot", "adc"])
        self.assertEqual(metrics["set"], ["scenario.seed=7"])

    def test_the_parameters_are_told_as_estimated_actual_and_configured(self):
        parameters = self.metrics("s1", "--set", "plant.resistance_scale=1.02")["parameters"]
        resistance = parameters["resistance_ohm"]
        self.assertAlmostEqual(resistance["actual"], 1.02 * 2.125)
        self.assertAlmostEqual(resistance["configured"], 2.125)
        for name, value in parameters.items():  # nothing is corrected as published
            self.assertAlmostEqual(value["estimated"] / value["configured"], 1, delta=ROUNDING, msg=name)

    def test_only_json_goes_to_standard_output(self):
        done = self.assert_status(BROKEN, "run", self.short(angle=0), "--json", "-")
        self.assertEqual(json.loads(done.stdout)["scenario"], "short")
        self.assertIn("angle_error_max_deg", done.stderr)


class Limits(MotorsimTest):
    def test_a_limit_that_does_not_hold_is_named_in_one_line(self):
        done = self.assert_status(BROKEN, "run", self.short(angle=0))
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1)
        self.assertRegex(lines[0], r"^short: angle_error_max_deg = 0\.\d+, limit: 0$")

    def test_the_table_shows_values_and_limits(self):
        done = self.assert_status(HOLDS, "run", "s1")
        self.assertRegex(done.stdout, r"speed_error_max_pct +0\.\d+ +0\.36  ok")


class Notes(MotorsimTest):
    def test_what_will_not_happen_as_written_is_told_in_both_forms(self):
        late = ("--set", "scenario.load=[{time_s = 3, torque_nm = 1}]")
        note = self.metrics("s1", *late)["notes"]
        self.assertEqual(len(note), 1)
        self.assertRegex(note[0], r"^--set: scenario.load.time_s = 3: never acts, .*s1.toml:\d+\)$")
        self.assertIn(f"\nnote: {note[0]}\n", self.motorsim("run", "s1", *late).stdout)


    def test_a_start_that_outlasts_its_prelude_is_told_where_it_has_cost_the_lock(self):
        said = r"start lasted until [\d.]+ s and is judged from 0 s on.*prelude_s"
        heavy = self.metrics("any", "--set", "plant.inertia_scale=20", "--set", "scenario.initial_angle_el_deg=30")
        self.assertRegex("\n".join(heavy["notes"]), said)
        self.assertNotRegex("\n".join(self.metrics("any")["notes"]), said)


class OtherEstimator(MotorsimTest):
    RUN = ("s2_robust", "--with", "imp")

    def test_it_is_named_and_has_figures_of_its_own(self):
        own, other = (self.metrics(*self.RUN, *words) for words in ((), ("--estimator", "kalman")))
        self.assertEqual(other["notes"], ["extended Kalman filter with four states in place of the drive's observer"])
        self.assertTrue(other["locked"])
        self.assertNotEqual(own["speed_error_max_rpm"], other["speed_error_max_rpm"])
        self.assertEqual(other, self.metrics(*self.RUN, "--estimator", DATA / "peers/kalman.toml"))

    def test_each_has_gains_with_a_range_and_a_meaning(self):
        for peer in json.loads(self.assert_status(HOLDS, "estimators").stdout).values():
            self.assertTrue(peer["title"])
            for gain in peer["gain"].values():
                self.assertLess(gain["min"], gain["max"])
                self.assertTrue(gain["help"])

    def test_bad_input_is_one_line(self):
        for words, message in (
                (("--estimator", "kalmann"), '--estimator: estimator = "kalmann": not found, did you mean kalman?; '),
                (("--estimator", "kalman", "--record", "x.nfr"), "--record needs the drive's own observer: ")):
            self.assertRegex(self.refused("run", "s1", *words), f"^motorsim: {re.escape(message)}")
        self.assertFalse((self.folder / "x.nfr").exists())


class AnyMotor(MotorsimTest):
    """The scenario `any` takes every motor to the board that fits it."""

    def test_every_shipped_motor_holds(self):
        for motor, board in pairs_that_fit():
            for sets in ((), ("--with", "adc", "--with", "hot", "--with", "saturated")):
                with self.subTest(motor=motor, board=board, sets=sets):
                    self.assert_status(HOLDS, "run", *pair_of(motor, board), *sets)

    def test_every_shipped_motor_has_a_board_that_fits(self):
        motors = {path.stem for path in (DATA / "motors").glob("*.toml")}
        self.assertEqual({motor for motor, _ in pairs_that_fit()}, motors)

    def test_a_motor_of_ones_own_needs_three_lines(self):
        (self.folder / "mine").mkdir()
        shipped = (DATA / "motors" / "teknic_m2310p.toml").read_text(encoding="utf-8")
        (self.folder / "mine" / "motor.toml").write_text(shipped, encoding="utf-8")
        own = self.folder / "mine" / "run.toml"
        own.write_text('base = "any"\nmotor = "motor.toml"\nboard = "frdm_mc_lvpmsm"\n',
                       encoding="utf-8")
        mine, theirs = self.metrics(own), self.metrics(*pair_of("teknic_m2310p", "frdm_mc_lvpmsm"))
        self.assertTrue(mine["accepted"])
        for key in ("scenario", "set"):
            del mine[key], theirs[key]
        self.assertEqual(mine, theirs)

    def test_the_rated_speed_is_held_under_half_of_the_rated_torque(self):
        for motor, board in pairs_that_fit():
            with self.subTest(motor=motor, board=board):
                held = self.metrics(*pair_of(motor, board), "--set", "scenario.evaluate_from_s=1.5",
                                    "--set", "scenario.duration_s=1.7")
                self.assertLess(held["command_error_settled_pct"], SETTLED_PCT)


class WrongFile(MotorsimTest):
    """What the page for users says of a motor file that is not its motor."""

    PAIRS = (("motor_a", "bench_310v"), ("odrive_d5065", "b_g431b_esc1"),
             ("teknic_m2310p", "frdm_mc_lvpmsm"))

    def rows(self):
        page = (ROOT / "docs/configuration.md").read_text(encoding="utf-8")
        lines = page.partition("### What a wrong file looks like")[2].partition("\n## ")[0].splitlines()
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines
                if line.startswith("| `") and "=" in line]

    def ran(self, settings, pair):
        sets = [word for setting in settings.strip("`").split() for word in ("--set", setting)]
        return self.metrics(*pair_of(*pair), *sets)

    @staticmethod
    def verdict(metrics):
        faults = [mark.partition("@")[0] for mark in metrics["faults"]]
        return faults[0] if faults else "held" if metrics["locked"] else "lost"

    def test_each_line_is_what_is_measured(self):
        rows = self.rows()
        self.assertEqual(len(rows), 5)
        for settings, _, errors, found, *verdicts in rows:
            with self.subTest(settings=settings):
                runs = [self.ran(settings, pair) for pair in self.PAIRS]
                self.assertEqual([self.verdict(run) for run in runs], verdicts)
                measured = [runs[0]["speed_error_max_pct"], runs[0]["angle_error_max_deg"]]
                for text, value in zip(errors.replace(" %", "").replace("°", "").split(", "), measured):
                    self.assertAlmostEqual(float(text), value, delta=MARGIN * value + 0.05)
                for text, value in zip(found.split(", "), runs[0]["parameters"].values(), strict=True):
                    self.assertAlmostEqual(float(text), value["estimated"] / value["configured"],
                                           delta=FOUND_MARGIN)


class Determinism(MotorsimTest):
    def test_two_runs_give_the_same_bytes(self):
        for run in ("a", "b"):
            self.assert_status(HOLDS, "run", "s1", "--with", "adc", "--trace", f"{run}.csv",
                               "--json", f"{run}.json")
        for ending in ("csv", "json"):
            first, second = (self.folder / f"{run}.{ending}" for run in ("a", "b"))
            self.assertEqual(first.read_bytes(), second.read_bytes())

    def test_the_seed_matters(self):
        first, second = (self.metrics("s1", "--with", "adc", "--set", f"scenario.seed={seed}") for seed in (1, 2))
        self.assertNotEqual(first["speed_error_rms_rpm"], second["speed_error_rms_rpm"])

    def test_tracing_changes_nothing(self):
        self.assertEqual(self.metrics("s2", "--trace", "t.csv"), self.metrics("s2"))


class Trace(MotorsimTest):
    def rows(self, *args):
        self.motorsim("run", *args, "--trace", "t.csv")
        with open(self.folder / "t.csv", encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def test_header_and_rows(self):
        rows = self.rows("s1")
        self.assertEqual(list(rows[0]), COLUMNS)
        self.assertEqual(len(rows), 10000)
        self.assertEqual(float(rows[0]["time_s"]), 0)
        self.assertAlmostEqual(float(rows[-1]["time_s"]), 0.9999)
        self.assertEqual({row["state"] for row in rows}, {"RUN"})
        self.assertEqual({row["fault"] for row in rows}, {"NONE"})
        self.assertAlmostEqual(float(rows[-1]["speed_rpm"]), RATED_RPM, delta=5)

    def test_every_number_is_one(self):
        for row in self.rows("s3"):
            for name in set(COLUMNS) - {"state", "fault"}:
                float(row[name])

    def test_errors_agree_with_the_metrics(self):
        rows = self.rows("s1", "--json", "m.json")
        metrics = json.loads((self.folder / "m.json").read_text(encoding="utf-8"))
        for actual, estimated, name in (("speed_rpm", "speed_estimated_rpm", "speed_error_max_rpm"),
                                        ("i_q_a", "i_q_estimated_a", "iq_error_max_a")):
            largest = max(abs(float(row[actual]) - float(row[estimated])) for row in rows)
            self.assertAlmostEqual(largest, metrics[name], delta=0.01)
        largest = max(abs(float(row["angle_error_el_deg"])) for row in rows)
        self.assertAlmostEqual(largest, metrics["angle_error_max_deg"], delta=1e-5)

    def test_prelude_on_request(self):
        rows = self.rows(self.short(), "--trace-prelude")
        self.assertAlmostEqual(float(rows[0]["time_s"]), -0.04)
        self.assertEqual(rows[0]["state"], "OFFSET_CAL")
        self.assertEqual(rows[-1]["state"], "RUN")


class BadInput(MotorsimTest):
    def test_one_line_and_status_2(self):
        wrong = (["run"], [], ["run", "s9"], ["run", "s1", "--with", "nonsense"],
                 ["run", "s1", "--set", "motor.mass_kg=3"], ["run", "s1", "--trace", "no/such/folder/t.csv"],
                 ["bench", "--runs", "0"], ["run", "s1", "--trace", "/dev/full"], ["run", "s1", "--json", "/dev/full"])
        for args in wrong:
            self.refused(*args)
        self.assertIn("fly", self.refused("fly"))


class Outputs(MotorsimTest):
    def test_what_is_read_is_not_written_over(self):
        path = self.short()
        before = path.read_bytes()
        (self.folder / "link").symlink_to(path)
        for option in ("--trace", "--json"):
            for name in ("short.toml", "./short.toml", path, "link"):
                self.assertIn(f"{option}: ", self.refused("run", path, option, name))
        self.assertEqual(path.read_bytes(), before)

    def test_trace_and_results_are_two_files(self):
        for name in ("same", "./same", self.folder / "same"):
            self.assertIn("same file", self.refused("run", "s1", "--trace", "same", "--json", name))
        self.assertFalse((self.folder / "same").exists())

    def test_a_file_needs_a_name(self):
        for args in (["--trace", ""], ["--trace", "-"]):
            self.assertIn(args[0], self.refused("run", "s1", *args))
        self.assertFalse((self.folder / "-").exists())


class Conventions(MotorsimTest):
    """Wherever --json is an option, it takes a file's name, and - is standard output."""

    COMMANDS = (("run", "s1"), ("bench", "--runs", "1"), ("identify", "s1"),
                ("certify", "motor_a", "--runs", "1", "--tuning", "any"))

    def test_json_goes_to_a_file_and_a_hyphen_is_standard_output(self):
        for command in self.COMMANDS:
            with self.subTest(command):
                json.loads(self.assert_status(HOLDS, *command, "--json", "-").stdout)
                self.assertEqual(self.assert_status(HOLDS, *command, "--json", "out.json").stdout, "")
                json.loads((self.folder / "out.json").read_text(encoding="utf-8"))
                for wrong, named in (([], "--json"), ([""], "--json"), (["no/such/x.json"], "no/such/x.json")):
                    self.assertIn(named, self.refused(*command, "--json", *wrong))

    def test_no_command_has_a_json_of_its_own(self):
        commands = re.findall(r"^  (\w+) {2,}", self.motorsim("--help").stdout, re.MULTILINE)
        self.assertIn("bench", commands)
        for command in commands:
            said = re.search(r"^ +--json( \w+)?", self.motorsim(command, "--help").stdout, re.MULTILINE)
            if said:
                self.assertEqual(said[1], " FILE", command)
                self.assertIn(command, [known[0] for known in self.COMMANDS])


class Help(MotorsimTest):
    def test_help_teaches(self):
        for args in (["--help"], ["run", "--help"], ["bench", "--help"], ["certify", "--help"], ["list", "--help"]):
            self.assert_status(HOLDS, *args)
        self.assertIn("motorsim run s1", self.motorsim("--help").stdout)

    def test_list_names_scenarios_and_imperfections(self):
        text = self.assert_status(HOLDS, "list").stdout
        for name in ("s1", "s2_robust", "s3", "adc", "deadtime", "A fig. 5"):
            self.assertIn(name, text)

    def test_bench_gives_numbers(self):
        figures = json.loads(self.motorsim("bench", "--runs", "2", "--json", "-").stdout)
        self.assertEqual(figures["scenario"], "s1")
        self.assertGreater(figures["real_time_factor_best"], 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
