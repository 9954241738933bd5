# SPDX-License-Identifier: MIT
"""What the scenarios measure today, bounded on both sides; and their limits, bounded by what is measured.

The limits in the scenario files say what a user may rely on and leave room. The figures of expected.toml say what the
drive does: a change that moves one by more than a fifth, for better or worse, has to be understood and
the table changed with it: `tools/dev figures --write`.

test_expected.py MOTORSIM RESULTS [Expected.test_case]...
    holds the table. The folder RESULTS has what the tests of the scenarios' limits have measured with the first seed, and
    runs.txt, which names these runs.
"""

import sys
import tomllib
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/docs"))
import expected  # noqa: E402
import generated  # noqa: E402
from expected import FINEST, METRICS  # noqa: E402

MOTORSIM, RESULTS, *CASES = sys.argv[1:]
SCENARIOS = ROOT / "host_sim" / "scenarios"
EXPECTED = expected.expected()
MEASURED = expected.Measured(MOTORSIM, expected.runs_of(Path(RESULTS) / "runs.txt"), Path(RESULTS))
# A limit is no farther from the worst of its runs: room for other noise and another machine, not for another drive.
ROOM = 2.0
# Their limits judge other motors than that of these runs: those of a campaign, and any.
ELSEWHERE = {"campaign", "any"}


def limits(scenario):
    """The [accept] tables of a scenario, those of its base included."""
    document = tomllib.loads((SCENARIOS / f"{scenario}.toml").read_text(encoding="utf-8"))
    inherits = "base" in document and document["scenario"].get("inherit_limits", True)
    found = limits(document["base"]) if inherits else {}
    for selection, table in document.get("accept", {}).items():
        found[selection] = found.get(selection, {}) | table
    return found


def judged_here():
    return {scenario for scenario, _ in EXPECTED} - ELSEWHERE


class Expected(unittest.TestCase):
    def test_figures_are_what_they_were(self):
        self.assertEqual(list(expected.moved(MEASURED, EXPECTED)), [])

    def test_every_scenario_is_run_and_every_run_is_in_the_table(self):
        self.assertEqual(set(EXPECTED), set(MEASURED.runs))
        self.assertEqual({scenario for scenario, _ in EXPECTED},
                         {path.stem for path in SCENARIOS.glob("*.toml")})

    def test_the_pages_show_what_is_measured(self):
        for page, tables in expected.pages(MEASURED).items():
            self.assertIsNone(generated.departure(page, tables))

    def test_no_limit_is_far_from_what_is_measured(self):
        for scenario in judged_here():
            for selection, table in limits(scenario).items():
                worst = self.worst(scenario, selection)
                for metric, limit in table.items() if worst else ():
                    with self.subTest(scenario=scenario, selection=selection, metric=metric):
                        self.assertIn(metric, worst)
                        if metric != "locked":
                            self.assertLessEqual(limit, ROOM * (worst[metric] + FINEST.get(metric, 0.0)))

    def test_every_scenario_has_limits_for_a_run_without_imperfections(self):
        for scenario in judged_here():
            self.assertIn("ideal", limits(scenario), scenario)

    def worst(self, scenario, selection):
        """The largest figures of the runs that a selection's limits judge; empty without any."""
        chosen = limits(scenario)
        results = [result for (name, imperfection), found in MEASURED.results.items() if name == scenario
                   and (imperfection if imperfection in chosen else "any") == selection
                   for result in found]
        names = {name for name in results[0]
                 if all(isinstance(result[name], (int, float)) for result in results)} if results else ()
        return {name: max(result[name] for result in results) for name in names}


class TheTest(unittest.TestCase):
    """A figure that has moved is found, and it alone is written."""

    RUN = ("s1", "ideal")
    VALUES = (3.0, 1.0, 2.0, 0.5, None, None, 0.1)

    def setUp(self):
        self.measured = expected.Measured("", [self.RUN])
        self.measured.results = {self.RUN: [dict(zip(METRICS, self.VALUES))]}

    def test_a_figure_beyond_its_margin_is_found_and_written_and_others_stay(self):
        table = {self.RUN: [3.5, 1.3, 2.0, 0.5, None, None, 0.1]}
        self.assertEqual([line.rpartition(", ")[2] for line in expected.moved(self.measured, table)],
                         ["speed_error_rms_rpm: shown: 1.30  now: 1.00"])
        self.assertIn("\n[s1]\nideal = [3.50, 1.00, 2.00, 0.500, nan, nan, 0.100]\n", expected.written(self.measured, table))

    def test_a_run_that_only_one_side_has_is_found(self):
        self.assertEqual([line.rpartition(": ")[2] for line in expected.moved(self.measured, {("s2", "adc"): self.VALUES})],
                         ["is not there", "no such run"])

    def test_a_figure_that_applies_on_one_side_only_is_found(self):
        self.assertEqual(len(list(expected.moved(self.measured, {self.RUN: [0.1] * len(METRICS)}))), len(METRICS) - 1)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *CASES])
