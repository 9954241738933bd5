# SPDX-License-Identifier: MIT
"""The comparison of estimators: the search, its files, the table and the page that shows it."""

import dataclasses
import math
import os
import re
import tomllib
import unittest
from unittest import mock

from support import TOOLS, FolderTest, captured
from comparison import cli, runs, search, table
from comparison.runs import Case, Motor, Outcome
from robustness.simulator import FAILED_SAFE, LOCKED, OFF_LIMITS, REFUSED, UNCONTROLLED

MOTORSIM = os.environ.get("NF_MOTORSIM")
PAGE = TOOLS.parent / cli.PAGE
# As other figures of the page, test_expected.py: a fifth, and half of the last digit.
MARGIN, ROUNDED = 0.2, 0.05
GOOD = Outcome(True, 1.0, 3.0, LOCKED)
RANGES = {"a": {"min": 1e-3, "max": 1.0}, "b": {"min": 0.5, "max": 50.0}}


def bowl(found):
    """Least where a = 0.02 and b = 4."""
    return math.log(found["a"] / 0.02) ** 2 + math.log(found["b"] / 4.0) ** 2


def called(*words, program=MOTORSIM):
    """Exit status, output and errors of the command."""
    return captured(cli.main, *words, "--motorsim", program)


class Search(unittest.TestCase):
    def test_it_finds_the_least_cost(self):
        for seed in range(5):
            best, least = search.search(RANGES, bowl, 300, seed)
            # The last steps are STEP_LEAST of the logarithm of a range, which is at most log(1000).
            self.assertLess(least, 2 * (search.STEP_LEAST * math.log(1000)) ** 2)
            self.assertEqual(least, bowl(best))

    def test_it_makes_as_many_trials_as_asked_within_the_ranges_and_the_same_again(self):
        def trials(seed):
            tried = []
            search.search(RANGES, lambda found: tried.append(found) or bowl(found), 40, seed)
            return tried
        first = trials(1)
        self.assertEqual(len(first), 40)
        self.assertEqual(first, trials(1))
        self.assertNotEqual(first, trials(2))
        for found in first:
            for name, gain in RANGES.items():
                self.assertTrue(gain["min"] <= found[name] <= gain["max"])

    def test_it_begins_with_gains_that_are_known(self):
        tried = []
        search.search(RANGES, lambda found: tried.append(found) or bowl(found), 6, first={"a": 0.02, "b": 4.0})
        self.assertEqual(tried[0], {"a": 0.02, "b": 4.0})
        self.assertNotEqual(tried[1], tried[0])

    def test_a_lost_rotor_costs_more_than_any_other_run(self):
        good, bad = dataclasses.replace(GOOD, angle_deg=1.0), Outcome(True, 80.0, 90.0, LOCKED)
        lost, refused = dataclasses.replace(good, locked=False), Outcome(False, None, None, REFUSED)
        self.assertEqual(search.cost_of([good, good]), 2.0)
        self.assertEqual(search.cost_of([bad]), search.LOST)
        self.assertEqual(search.cost_of([good, refused, lost]), (2.0 + search.LOST) / 2)

    def test_noise_and_motors_are_others_than_those_of_the_table(self):
        self.assertFalse({case.seed for case in search.GOALS["scenarios"].cases} & set(range(1, table.SEEDS + 1)))
        self.assertFalse({motor.seed for motor in search.GOALS["zoo"].cases} & {table.ZOO_SEED})

    def test_shipped_gains_are_of_the_goals_and_within_their_ranges(self):
        for name, peer in runs.asked(MOTORSIM, ["estimators"]).items():
            for goal, aim in search.GOALS.items():
                path = runs.PEERS / f"{name}{aim.suffix}.toml"
                text = path.read_text(encoding="utf-8")
                self.assertIn(f"tune {name} --goal {goal} --evaluations {aim.evaluations} --seed {search.SEED}`", text)
                for gain, value in tomllib.loads(text)["gain"].items():
                    self.assertTrue(peer["gain"][gain]["min"] <= value <= peer["gain"][gain]["max"])


class Cells(unittest.TestCase):
    def test_a_cell_is_the_worst_of_all_seeds(self):
        self.assertEqual(table.cell([GOOD, Outcome(True, 2.0, 0.5, LOCKED)]), "2, 3.0°")

    def test_a_lost_rotor_is_said(self):
        lost = dataclasses.replace(GOOD, locked=False)
        self.assertEqual(table.cell([lost, lost]), "lost")
        self.assertEqual(table.cell([GOOD, lost, GOOD]), "lost in 1 of 3")

    def test_sets_without_noise_have_one_run(self):
        self.assertEqual(runs.cases(["s1"], ["ideal", "imp"], [1, 2]),
                         [Case("s1", "ideal", 1), Case("s1", "imp", 1), Case("s1", "imp", 2)])


class Zoo(unittest.TestCase):
    def test_a_motor_is_that_of_the_campaign(self):
        self.assertEqual(Motor("zoo", 3, 7).arguments(), ["run", "zoo:outrunner:7@3"])
        self.assertEqual(Motor("zoo_user", 3, 7).arguments(), ["run", "zoo:outrunner:7@3:user"])

    def test_the_shares_are_of_the_motors_that_end_so_and_the_error_is_of_those_that_all_lock(self):
        def line(*endings):
            return [Outcome(ending == LOCKED, float(number), 1.0, ending) for number, ending in enumerate(endings)]
        lines = [line(LOCKED, LOCKED, LOCKED, OFF_LIMITS), line(FAILED_SAFE, LOCKED, LOCKED, UNCONTROLLED)]
        with mock.patch.object(table, "SHARED_LEAST", 2):
            heads, rows = table.zoo_table(["kalman_zoo", None], lines)
        self.assertEqual(heads, ["of 4 motors", "locked, %", "swings, %", "fault, %", "lost, %", "speed error of 2, %"])
        self.assertEqual(rows, [["Kalman filter, 4 states", "75.0", "25.0", "0.0", "0.0", "1.5"],
                                [table.DRIVE, "50.0", "0.0", "25.0", "25.0", "1.5"]])

    def test_too_few_motors_that_all_lock_show_no_error(self):
        for count, cell in ((table.SHARED_LEAST - 1, "–"), (table.SHARED_LEAST, "1")):
            _, rows = table.zoo_table([None], [[GOOD] * count])
            self.assertEqual(rows[0][-1], cell)

    def test_a_motor_that_is_refused_counts_for_none(self):
        refused = Outcome(False, None, None, REFUSED)
        with mock.patch.object(runs, "run_all", return_value=[GOOD, refused, GOOD, refused]):
            self.assertEqual(table.zoo_outcomes(None, ["a", None], "zoo", 2), [[GOOD], [GOOD]])

    def test_a_refusal_is_one_for_the_motor_and_not_an_error(self):
        message = "zoo:hub:0@1/motor.toml:11: motor.max_speed_rpm = 900: does not fit the firmware; allowed: less"
        self.assertEqual(Motor("zoo", 1, 0).refusal(message)["refused"], message)
        self.assertIsNone(Motor("zoo", 1, 0).refusal("no such file"))
        self.assertIsNone(Case("s1", "ideal", 1).refusal(message))


class WithSimulator(FolderTest):
    def tuned(self, goal, cases, evaluations, *words):
        """The text of the file that a search with these cases has written."""
        aim = dataclasses.replace(search.GOALS[goal], cases=cases)
        with mock.patch.dict(search.GOALS, {goal: aim}):
            status, out, _ = called("tune", "kalman", "--goal", goal, "--evaluations", str(evaluations),
                                    "--out", str(self.folder), *words)
        path = self.folder / f"kalman{aim.suffix}.toml"
        cost = search.cost_of(runs.run_all(MOTORSIM, [(case, path) for case in cases]))
        self.assertEqual((status, out), (0, f"{path}: cost {cost:.3g}\n"))
        return path.read_text(encoding="utf-8"), cost

    def test_a_search_writes_a_file_that_the_simulator_takes_and_that_has_the_cost_it_says(self):
        text, cost = self.tuned("scenarios", [Case("s2_robust", "imp", 101)], 4)
        self.assertIn("# Found by `tools/compare tune kalman --goal scenarios --evaluations 4 --seed 1`\n"
                      f"# with a cost of {cost:.3g} ", text)

    def test_the_search_for_the_zoo_begins_with_the_gains_for_the_scenarios(self):
        first = (runs.PEERS / "kalman.toml").read_text(encoding="utf-8")
        self.write("kalman.toml", first)
        with mock.patch.object(search, "cost_of", return_value=1.0):
            text, _ = self.tuned("zoo", [Motor("zoo", 1, 0)], 3)
        self.assertEqual(tomllib.loads(text), tomllib.loads(first))

    def test_motors_of_the_zoo_are_run(self):
        found = table.zoo_outcomes(MOTORSIM, ["neural_zoo", None], "zoo_user", 2)
        self.assertEqual([len(line) for line in found], [2, 2])
        self.assertNotEqual(found[0], found[1])

    def test_a_table_has_a_row_for_each_estimator_and_file(self):
        path = self.write("mine.toml", (runs.PEERS / "neural.toml").read_text(encoding="utf-8"))
        status, out, _ = called("table", "--scenario", "s2_robust", "--with", "ideal", "--seeds", "1",
                                "--estimator", "neural", "--estimator", str(path))
        self.assertEqual(status, 0)
        cells = [re.findall(r"[^│┃]+", line) for line in out.splitlines() if "°" in line]
        self.assertEqual(cells[0][0].split()[0], "eq.")
        self.assertIn(cells[1][0].split()[0].rstrip("…"), str(path))
        self.assertEqual(cells[0][1], cells[1][1])

    def test_bad_input_is_one_line(self):
        kinds = "luenberger, sliding_mode, flux, kalman, neural, all"
        for words, program, message in (
                (("table", "--scenario", "s9"), MOTORSIM, 'command line: scenario = "s9": not found, '),
                (("table", "--estimator", "ekf"), MOTORSIM, '--estimator: estimator = "ekf": not found; allowed: flux, '),
                (("tune", "ekf"), MOTORSIM, f"ekf: no estimator; allowed: {kinds}\n"),
                (("tune", "kalman"), "/nowhere", "/nowhere: No such file or directory; expected motorsim")):
            with self.subTest(words=words):
                status, out, err = called(*words, program=program)
                self.assertEqual((status, out), (2, ""))
                self.assertTrue(err.startswith(f"compare: {message}"), err)
                self.assertEqual(err.count("\n"), 1)


class Page(unittest.TestCase):
    # In S1 and S3 an estimator at its limit loses the rotor with one noise and not with another: no figure that another
    # build has.
    SCENARIO, SETS = "s2_robust", ("deadtime", "all")

    def shown(self, name):
        """The cells of a table of the page by row and column."""
        text = PAGE.read_text(encoding="utf-8")
        lines = re.search(f"<!-- {name} -->\n(.*?)<!-- end -->", text, re.DOTALL)[1].splitlines()
        heads, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
        return {row[0]: dict(zip(heads, row)) for row in rows}

    def test_the_page_has_all_tables_with_all_rows(self):
        wanted = [*table.TITLES.values(), table.DRIVE]
        for name in (*table.SCENARIOS, *table.VARIANTS):
            self.assertEqual(list(self.shown(name)), wanted)

    def test_the_page_shows_what_is_measured(self):
        shown = self.shown(self.SCENARIO)
        estimators = [*runs.asked(MOTORSIM, ["estimators"]), None]
        for row in table.rows(MOTORSIM, estimators, self.SCENARIO, self.SETS):
            for head, value in zip(table.heads(self.SETS)[1:], row[1:]):
                with self.subTest(row=row[0], column=head, shown=shown[row[0]][head], measured=value):
                    self.assert_near(shown[row[0]][head], value)

    def assert_near(self, cell, value):
        number = re.compile(r"\d+\.?\d*")
        self.assertEqual(number.sub("", cell), number.sub("", value))
        for text, now in zip(map(float, number.findall(cell)), map(float, number.findall(value))):
            self.assertAlmostEqual(text, now, delta=MARGIN * now + ROUNDED)


if __name__ == "__main__":
    unittest.main()
