# SPDX-License-Identifier: MIT
"""What a campaign's results say: counts, figures, where failures gather, the map."""

import io
import unittest

from rich.console import Console

from campaign_support import MINE, CampaignTest
from robustness import fail_map, progress, summary, tables
from robustness.simulator import OUTCOMES

PNG_START = b"\x89PNG\r\n"
KEY = "plant.resistance_scale"


def row(run, outcome, resistance="1", **metrics):
    values = {KEY: resistance, "plant.inertia_scale": "1", "plant.bus_ripple_pct": "0",
              "scenario.seed": "5"}
    return {"run": run, "outcome": outcome, "values": values, "metrics": metrics}


class Numbers(CampaignTest):
    def test_counts(self):
        rows = [row(k, "locked") for k in range(3)] + [row(3, "uncontrolled")]
        self.assertEqual([(c.outcome, c.runs, c.percent) for c in summary.counts(rows)],
                         [("locked", 3, 75.0), ("held, off limits", 0, 0.0), ("failed safe", 0, 0.0),
                          ("uncontrolled", 1, 25.0)])

    def test_every_outcome_has_its_own_look(self):
        for looks in (progress.STYLES, fail_map.COLOURS, fail_map.MARKERS):
            self.assertEqual(set(looks), set(OUTCOMES))
            self.assertEqual(len(set(looks.values())), len(OUTCOMES))
        self.assertEqual(set(fail_map.SCALE), set(OUTCOMES))

    def test_the_interval_is_wilsons(self):
        # Wilson 1927 for 0 of n: 0 to z²/(n + z²); symmetric for half of n.
        low, high = summary.interval(0, 100)
        self.assertEqual(low, 0)
        self.assertAlmostEqual(high, 100 * 3.8416 / 103.8416, places=9)
        low, high = summary.interval(50, 100)
        self.assertAlmostEqual(low + high, 100, places=9)
        self.assertAlmostEqual(high - low, 100 * 1.96 / 103.8416**0.5, places=9)

    def test_figures_of_locked_runs_and_the_worst_of_all(self):
        rows = [row(k, "locked", error_pct=float(k), note=None, good=True) for k in range(101)]
        rows.append(row(500, "uncontrolled", error_pct=1000.0, note=None, good=False))
        found, = summary.figures(rows)
        self.assertEqual((found.name, found.quantiles), ("error_pct", (50.0, 95.0, 99.0)))
        self.assertEqual((found.held.value, found.held.run), (100.0, 100))
        self.assertEqual((found.all.value, found.all.run), (1000.0, 500))

    def test_shares_tell_where_runs_fail(self):
        rows = [row(0, "uncontrolled", "0.9"), row(1, "failed safe", "0.95"),
                row(2, "locked", "0.96"), row(3, "locked", "1.0"), row(4, "locked", "1.1")]
        axes = self.load().axes(rows)
        found = summary.shares(axes[KEY], rows)
        self.assertEqual([round(share, 6) for share in found], [66.666667, 0, 0])
        self.assertEqual(list(summary.ranking(axes, rows))[0], KEY)
        self.assertNotIn("scenario.seed", summary.ranking(axes, rows))

    def test_reasons_count_runs(self):
        rows = [row(0, "failed safe", faults=["OVERCURRENT@1", "OVERCURRENT@9"],
                    failed_limits=["locked = false, limit: true"]),
                row(1, "uncontrolled", faults=[], failed_limits=["locked = false, limit: true"])]
        self.assertEqual(summary.reasons(rows), [("locked", 2), ("fault OVERCURRENT", 1)])
        self.assertEqual([failed["run"] for failed in summary.failures(rows)], [1, 0])
        self.assertEqual(summary.reason(rows[1]), "locked = false")

    def test_demands(self):
        rows = [row(0, "locked"), row(1, "failed safe"), row(2, "uncontrolled"), row(3, "locked"),
                row(4, "held, off limits"), row(5, "locked")]
        for accept, holds in (("locked_pct = 50", True), ("locked_pct = 50.1", False),
                              ("uncontrolled = 1", True), ("uncontrolled = 0", False)):
            demand, = summary.demands(self.load(f"{MINE}\n[accept]\n{accept}\n"), rows)
            self.assertEqual(demand.holds, holds, accept)


class Shown(CampaignTest):
    def shown(self, rows):
        out = io.StringIO()
        tables.show(Console(file=out, width=132), self.load(), rows, lambda run: f"again {run}")
        return out.getvalue()

    def test_tables_name_failures_with_their_command(self):
        text = self.shown([row(0, "locked", error_pct=1.0),
                           row(1, "uncontrolled", error_pct=3.0,
                               failed_limits=["error_pct = 3, limit: 2"])])
        for said in ("2 of 6 runs", "50.00", "again 1  # uncontrolled: error_pct = 3", KEY):
            self.assertIn(said, text)

    def test_without_failures_there_is_nothing_about_them(self):
        text = self.shown([row(0, "locked", error_pct=1.0)])
        self.assertNotIn("again", text)
        self.assertNotIn("third", text)


class Maps(CampaignTest):
    def drawn(self, vary, values, outcomes):
        campaign = self.load(MINE[:MINE.index("[vary]")] + "[vary]\n" + vary)
        rows = [{"run": k, "outcome": outcome, "values": values(k), "metrics": {}}
                for k, outcome in enumerate(outcomes)]
        return fail_map.write(self.folder, campaign, rows)

    def test_a_map_of_every_kind_of_parameter(self):
        path = self.drawn("a.b = { uniform = [0, 1] }\nc.d_deg = { choice = [0, 90] }\n"
                          "e.f = { log_uniform = [1, 100] }\nscenario.seed = { integer = [0, 9] }\n",
                          lambda k: {"a.b": str(k / 20), "c.d_deg": ("0", "90")[k % 2],
                                     "e.f": str(1 + k), "scenario.seed": "3"},
                          list(OUTCOMES) * 5)
        self.assertTrue(path.read_bytes().startswith(PNG_START))

    def test_a_map_of_one_parameter_and_one_run(self):
        self.assertTrue(self.drawn("a.b = { uniform = [0, 1] }", lambda k: {"a.b": "0.5"},
                                   ["locked"]).is_file())

    def test_seeds_alone_have_no_map(self):
        self.assertIsNone(self.drawn("scenario.seed = { integer = [0, 9] }",
                                     lambda k: {"scenario.seed": "3"}, ["locked"]))

    def test_panels_are_points_below_and_shares_above_the_diagonal(self):
        campaign = self.load()
        rows = [row(0, "locked", "0.9"), row(1, "uncontrolled", "1.1")]
        figure = fail_map.Map(campaign, rows).figure()
        panels = figure.axes[:9]
        self.assertEqual(len(fail_map.Map(campaign, rows).keys), 3)
        for number, panel in enumerate(panels):
            below, above = number // 3 > number % 3, number // 3 < number % 3
            self.assertEqual(len(panel.lines) > 0, below)
            self.assertEqual(len(panel.collections) > 0, above)

    def test_labels_say_the_unit(self):
        for key, expected in (("scenario.initial_angle_el_deg", "initial angle el, °"),
                              ("plant.resistance_scale", "resistance scale"), ("motor", "motor")):
            self.assertEqual(fail_map.label(key), expected)


if __name__ == "__main__":
    unittest.main()
