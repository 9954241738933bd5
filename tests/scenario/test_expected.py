"""What the scenarios measure today, bounded on both sides.

The limits in the scenario files say what a user may rely on and leave room. These figures say what the
drive does: a change that moves one by more than a fifth, for better or worse, has to be understood and
the table changed with it. `ideal` is free of noise; `adc` is the mean over ten seeds.
"""

import json
import subprocess
import sys
import unittest

MOTORSIM = sys.argv.pop(1)
MARGIN = 0.2
SEEDS = {"ideal": range(1, 2), "adc": range(1, 11)}
METRICS = "speed_error_max_rpm speed_error_rms_rpm angle_error_max_deg iq_error_max_a".split()
EXPECTED = {
    ("s1", "ideal"): (4.14, 0.765, 0.253, 0.0400),
    ("s1", "adc"): (9.65, 2.54, 0.333, 0.0760),
    ("s2", "ideal"): (7.68, 1.04, 0.136, 0.0495),
    ("s2", "adc"): (11.8, 3.09, 0.147, 0.0675),
    ("s3", "ideal"): (2.95, 0.650, 0.502, 0.0371),
    ("s3", "adc"): (9.25, 2.28, 0.569, 0.0679),
    ("s1_robust", "ideal"): (17.5, 4.71, 0.675, 0.0965),
    ("s1_robust", "adc"): (17.5, 4.71, 0.739, 0.110),
    ("s2_robust", "ideal"): (13.7, 1.30, 0.199, 0.0683),
    ("s2_robust", "adc"): (14.5, 1.56, 0.205, 0.0884),
    ("s3_robust", "ideal"): (16.4, 3.99, 1.27, 0.0813),
    ("s3_robust", "adc"): (16.3, 4.02, 1.16, 0.0771),
}


def measured(scenario, imperfection, seed):
    done = subprocess.run([MOTORSIM, "run", scenario, "--with", imperfection, "--json", "-",
                           "--set", f"scenario.seed={seed}"],
                          text=True, capture_output=True, check=False)
    return json.loads(done.stdout)


class Expected(unittest.TestCase):
    def test_figures_are_what_they_were(self):
        for (scenario, imperfection), expected in EXPECTED.items():
            seeds = SEEDS[imperfection]
            runs = [measured(scenario, imperfection, seed) for seed in seeds]
            for metric, value in zip(METRICS, expected):
                with self.subTest(scenario=scenario, imperfection=imperfection, metric=metric):
                    mean = sum(run[metric] for run in runs) / len(seeds)
                    self.assertAlmostEqual(mean, value, delta=MARGIN * value)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
