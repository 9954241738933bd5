# SPDX-License-Identifier: MIT
"""A dead time that the drive believes wrongly costs next to nothing, because the alignment measures it."""

import json
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
JOBS = 2
SCENARIOS = ("s1_robust", "s2_robust", "s3_robust")
TRUE_S = 2e-6       # of the set `deadtime`
SHARES = (1.0, 0.7, 1.3)
# What the exactly known dead time leaves may grow by so much, and by the scatter of a largest value of runs whose switching
# instants differ: the exactly known one alone has 0.23 to 0.39 degrees in s2_robust with other instants.
GROWTH, SCATTER = 1.3, 0.2
FIGURES = ("speed_error_max_pct", "angle_error_max_deg")


def metrics_of(run):
    scenario, share, *settings = run
    words = [word for setting in (f"model.dead_time_s={share * TRUE_S}", *settings) for word in ("--set", setting)]
    done = subprocess.run([MOTORSIM, "run", scenario, "--with", "deadtime", "--json", "-", *words],
                          capture_output=True, text=True, check=False)
    return json.loads(done.stdout)


class WrongDeadTime(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        runs = [(scenario, share) for scenario in SCENARIOS for share in SHARES]
        unmeasured = [(SCENARIOS[1], share, "adaptation.dead_time_pct=0") for share in SHARES]
        with ThreadPoolExecutor(JOBS) as pool:
            cls.found = dict(zip(runs, pool.map(metrics_of, runs), strict=True))
            cls.unmeasured = dict(zip(unmeasured, pool.map(metrics_of, unmeasured), strict=True))

    def test_figures_stay_near_those_of_the_exactly_known_one(self):
        for (scenario, share), found in self.found.items():
            exact = self.found[scenario, 1.0]
            for figure in FIGURES:
                with self.subTest(scenario=scenario, share=share, figure=figure):
                    self.assertTrue(found["locked"])
                    self.assertLessEqual(found[figure], GROWTH * exact[figure] + SCATTER)

    def test_without_the_measurement_they_do_not(self):
        exact = self.unmeasured[SCENARIOS[1], 1.0, "adaptation.dead_time_pct=0"]
        for (_, share, *_), found in self.unmeasured.items():
            if share != 1.0:
                self.assertGreater(found[FIGURES[1]], GROWTH * exact[FIGURES[1]] + SCATTER)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
