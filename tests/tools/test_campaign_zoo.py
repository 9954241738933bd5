# SPDX-License-Identifier: MIT
"""Campaigns over the zoo: which motors are run, what is refused, what the summary says."""

import io
import json
import subprocess
import unittest
from unittest import mock

from rich.console import Console

from campaign_support import MOTORSIM, CampaignTest
from robustness import axes, campaign, simulator, slice_map, summary, tables, zoo, zoo_summary
from robustness.campaign import CampaignError

PNG_START = b"\x89PNG\r\n"
MINE = """
title = "a few motors"
zoo = "user"
classes = ["hub", "servo"]
runs = 4
seed = 7
"""
TOO_FAST = ("motorsim: zoo:hub:0@1/motor.toml:11: motor.max_speed_rpm = 900: does not fit the firmware; allowed: at most 800 "
            "rpm: above it the rotor turns more than 0.7 rad in a PWM period; a higher board.pwm_frequency_hz raises it")
TOO_LARGE = ("motorsim: zoo:hub:0@1/motor.toml:6: motor.resistance_ohm = 2: does not fit the firmware; allowed: at most "
             "1.1 Ω: twice board.bus_full_scale_v over board.current_full_scale_a")


def row(run, outcome, **metrics):
    return {"run": run, "outcome": outcome, "values": {"motor": f"zoo:{('hub', 'servo')[run % 2]}:{run}@7"},
            "metrics": {"locked_coarse": outcome == "locked", "dimensionless": {"lag": float(run), "turn": 0.1}} | metrics}


def refused(run, why=zoo.FOR_FORMAT):
    return row(run, "refused") | {"metrics": {"refused": "line", "refused_for": why}}


class ZooTest(CampaignTest):
    def file(self, text=MINE, **replaced):
        return super().file(text, **replaced)

    def load(self, text=MINE):
        return super().load(text)


class Draws(ZooTest):
    def test_classes_take_turns_and_the_seed_is_the_campaigns(self):
        found = self.load()
        self.assertEqual([found.arguments(found.values(run)) for run in range(3)],
                         [["run", "zoo:hub:0@7:user"], ["run", "zoo:servo:1@7:user"], ["run", "zoo:hub:2@7:user"]])
        exact = self.load(MINE.replace('"user"', '"exact"'))
        self.assertEqual(exact.arguments(exact.values(0)), ["run", "zoo:hub:0@7"])

    def test_settings_of_the_file_hold_for_every_motor(self):
        found = self.load(MINE + "[set]\nobserver.kappa = 0.02\n")
        self.assertEqual(found.arguments(found.values(0)), ["run", "zoo:hub:0@7:user", "--set", "observer.kappa=0.02"])

    def test_seed_and_classes_of_the_command_line_make_another_campaign(self):
        found = campaign.changed(self.load(), seed=3, classes=("gimbal",))
        self.assertEqual(found.arguments(found.values(1)), ["run", "zoo:gimbal:1@3:user"])
        self.assertEqual(found.name, "mine-seed3-gimbal")
        self.assertEqual(campaign.changed(self.load()), self.load())

    def test_settings_of_the_command_line_hold_for_every_motor(self):
        file = self.load(MINE + "[set]\nobserver.kappa = 0.02\n")
        found = campaign.changed(file, settings=("observer.kappa=0.03", "startup.current_pct=80"))
        self.assertEqual(found.arguments(found.values(0))[2:],
                         ["--set", "observer.kappa=0.03", "--set", "startup.current_pct=80"])
        self.assertRegex(found.name, "^mine-set[0-9a-f]{8}$")
        self.assertNotEqual(found.name, campaign.changed(file, settings=("observer.kappa=0.04",)).name)

    def test_shipped_ones_have_every_class(self):
        listed = subprocess.run([MOTORSIM, "run", "zoo:bird:1"], capture_output=True, text=True, check=False).stderr
        for name in ("zoo", "zoo_user"):
            classes = campaign.load(name).drawn.classes
            self.assertIn(f"CLASS one of {', '.join(classes)};", listed)


class Refusals(ZooTest):
    def wrong(self, text, says):
        with self.assertRaisesRegex(CampaignError, rf"mine\.toml: {says}"):
            self.load(text)

    def test_what_a_file_may_hold(self):
        self.wrong(MINE.replace('"user"', '"mine"'), 'zoo: is "mine"; allowed: "exact" or "user"')
        self.wrong(MINE.replace('["hub", "servo"]', "[]"), r"classes: is \[\]; allowed: a list of classes")
        self.wrong('scenario = "s1"\n' + MINE, "scenario: stands beside zoo, which draws all of it")
        self.wrong(MINE + "[vary]\na.b = { uniform = [0, 1] }\n", "vary: stands beside zoo")
        self.wrong(MINE.replace('zoo = "user"', 'scenario = "s1"'), "classes: are those of a zoo")
        self.wrong(MINE.replace("seed = 7", "seed = 4294967296"), "seed: is 4294967296; allowed: .*0 to 4294967295")

    def test_options_that_are_not_for_this_campaign(self):
        with self.assertRaisesRegex(CampaignError, "--classes: .*smoke.toml is no zoo"):
            campaign.changed(campaign.load("smoke"), classes=("hub",))
        with self.assertRaisesRegex(CampaignError, "--seed: is 4294967296; allowed"):
            campaign.changed(self.load(), seed=4294967296)
        with self.assertRaisesRegex(CampaignError, "--set: is kappa; allowed: KEY=VALUE"):
            campaign.changed(self.load(), settings=("kappa",))
        with self.assertRaisesRegex(CampaignError, "--set: plant.inertia_scale varies in .*smoke.toml; allowed: a key"):
            campaign.changed(campaign.load("smoke"), settings=("plant.inertia_scale=1",))

    def test_a_class_that_there_is_not_is_told_before_the_first_run(self):
        self.file(MINE.replace('"hub"', '"bird"'))
        self.assert_refused(self.run_mine(), 'scenario = "zoo:bird:0@7:user": is not in the zoo; allowed: ')

    def test_a_motor_that_the_firmware_does_not_take_is_an_outcome(self):
        for line, why in ((TOO_FAST, zoo.FOR_PHYSICS), (TOO_LARGE, zoo.FOR_FORMAT)):
            found = simulator.result_of(self.load(), simulator.BAD_INPUT, "", line)
            self.assertEqual(found, {"refused": line, "refused_for": why})
            self.assertEqual(simulator.outcome(found), "refused")
        with self.assertRaises(CampaignError):
            simulator.result_of(self.load(), simulator.BAD_INPUT, "", "motorsim: unknown key")

    def test_the_lines_of_the_simulator_are_told_apart(self):
        for setting, why in (("board.pwm_frequency_hz=2000", zoo.FOR_PHYSICS),
                             ("board.bus_nominal_v=12", zoo.FOR_PHYSICS),
                             ("current_loop.bandwidth_hz=10000", zoo.FOR_FORMAT)):
            done = subprocess.run([MOTORSIM, "run", "zoo:outrunner:1", "--set", setting, "--set", "board.bus_min_v=5",
                                   "--set", "current_loop.weakening_pct=0"],
                                  capture_output=True, text=True, check=False)
            found = self.load().drawn.refusal(done.stderr)
            self.assertEqual(found and found["refused_for"], why, done.stderr)


class Summary(ZooTest):
    ROWS = [row(0, "locked", speed_error_load_pct=1.0), row(1, "uncontrolled", faults=[]),
            row(2, "failed safe", faults=["LOST_PHASE@8 (0.1 s)"]), row(3, "held, off limits"),
            row(4, "locked", speed_error_load_pct=3.0), refused(5)]

    def test_each_class_and_all(self):
        hub, servo, everything = zoo_summary.classes(self.load(), self.ROWS)
        self.assertEqual((hub.name, hub.runs, servo.runs, everything.runs), ("hub", 3, 3, 6))
        self.assertAlmostEqual(hub.percent["locked"], 200 / 3)
        self.assertAlmostEqual(everything.coarse_percent, 200 / 6)
        self.assertEqual((hub.false_faults, servo.false_faults), (1, 0))
        self.assertEqual((hub.faults, servo.faults), ({"LOST_PHASE": 1}, {}))

    def test_a_number_by_which_failures_gather_comes_first(self):
        rows = [row(run, "locked" if run < 10 else "uncontrolled") for run in range(20)]
        lag, turn = zoo_summary.gatherings(self.load(), rows)
        self.assertEqual((lag.name, turn.name), ("lag", "turn"))
        self.assertEqual(lag.edges, (0, 4, 8, 12, 16, 19))
        self.assertEqual(lag.percent, (0, 0, 50, 100, 100))

    def test_demands(self):
        for accept, holds in (("unnamed_pct = 34", True), ("unnamed_pct = 33", False), ("false_faults = 1", True),
                              ("false_faults = 0", False), ("refused_formats = 1", True),
                              ("refused_formats = 0", False)):
            demand, = summary.demands(self.load(f"{MINE}\n[accept]\n{accept}\n"), self.ROWS)
            self.assertEqual(demand.holds, holds, accept)

    def test_tables_say_it(self):
        out = io.StringIO()
        tables.show(Console(file=out, width=160), self.load(), self.ROWS, lambda run: f"again {run}")
        for said in ("hub", "lag", "false faults", "faults: LOST_PHASE (false) 1", "refused: 1 for number format",
                     "speed_error_load_pct of 95 % of the locked: 2.9", "again 5  # refused: line"):
            self.assertIn(said, out.getvalue())

    def test_the_file_has_what_the_tables_have(self):
        path = zoo_summary.write(self.folder, self.load(), self.ROWS)
        found = json.loads(path.read_text(encoding="utf-8"))
        self.assertEqual([line["name"] for line in found["classes"]], ["hub", "servo", "all"])
        self.assertEqual(found["faults"], {"LOST_PHASE": {"runs": 1, "false": True}})
        self.assertEqual(found["refused"], {"number format": 1})

    def test_the_picture(self):
        self.assertTrue(slice_map.write(self.folder, self.load(), self.ROWS).read_bytes().startswith(PNG_START))
        self.assertIsNone(slice_map.write(self.folder, self.load(), [refused(0)]))

    def test_ranks_fill_an_axis_evenly(self):
        ranked = axes.Ranked((1.0, 2.0, 2.0, 5.0))
        self.assertEqual([ranked.place(value) for value in (1.0, 2.0, 5.0)], [0.125, 0.5, 0.875])
        self.assertEqual([ranked.at(place) for place in (0, 0.3, 1)], [1.0, 2.0, 5.0])


class Running(ZooTest):
    def test_a_campaign_from_end_to_end(self):
        self.file()
        with mock.patch("robustness.slice_map.write", return_value=None):
            status, out, _ = self.run_mine("--runs", 2, "--classes", "hub")
        self.assertEqual(status, 0)  # nothing is demanded
        self.assertIn(str(self.folder / "out" / "summary.json"), out)
        rows = self.rows()
        self.assertEqual([row["values"]["motor"] for row in rows], ["zoo:hub:0@7", "zoo:hub:1@7"])
        self.assertTrue(all(zoo.has_numbers(row) for row in rows))
        _, again, _ = self.called("report", self.folder / "mine.toml", "--out", self.folder / "out", "--classes", "hub")
        self.assertTrue(out.startswith(again[:again.index("\n/")]))


if __name__ == "__main__":
    unittest.main()
