"""What the scenarios measure today, bounded on both sides.

The limits in the scenario files say what a user may rely on and leave room. These figures say what the
drive does: a change that moves one by more than a fifth, for better or worse, has to be understood and
the table changed with it. `ideal` is free of noise; `adc` is the mean over ten seeds.

test_expected.py MOTORSIM            holds the table
test_expected.py MOTORSIM --measure  prints the table as it is measured now
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
    ("s1", "ideal"): (3.61, 0.685, 0.248, 0.0389),
    ("s1", "adc"): (8.86, 2.21, 0.348, 0.0845),
    ("s2", "ideal"): (6.85, 0.794, 0.110, 0.0481),
    ("s2", "adc"): (9.73, 2.47, 0.114, 0.0597),
    ("s3", "ideal"): (3.24, 0.643, 0.586, 0.0346),
    ("s3", "adc"): (9.55, 2.25, 0.620, 0.0714),
    ("s1_robust", "ideal"): (27.6, 7.68, 0.980, 0.340),
    ("s1_robust", "adc"): (29.0, 7.68, 1.30, 0.405),
    ("s2_robust", "ideal"): (14.4, 1.59, 0.0732, 0.0235),
    ("s2_robust", "adc"): (15.8, 1.82, 0.125, 0.0550),
    ("s3_robust", "ideal"): (39.6, 7.57, 3.00, 0.958),
    ("s3_robust", "adc"): (45.8, 7.63, 3.28, 0.996),
}


def measured(scenario, imperfection, seed):
    done = subprocess.run([MOTORSIM, "run", scenario, "--with", imperfection, "--json", "-",
                           "--set", f"scenario.seed={seed}"],
                          text=True, capture_output=True, check=False)
    return json.loads(done.stdout)


def means(scenario, imperfection):
    """Each of METRICS, its mean over the seeds."""
    runs = [measured(scenario, imperfection, seed) for seed in SEEDS[imperfection]]
    return [sum(run[metric] for run in runs) / len(runs) for metric in METRICS]


def print_measured():
    for scenario, imperfection in EXPECTED:
        figures = ", ".join(f"{mean:#.3g}" for mean in means(scenario, imperfection))
        print(f'    ("{scenario}", "{imperfection}"): ({figures}),')


class Expected(unittest.TestCase):
    def test_figures_are_what_they_were(self):
        for (scenario, imperfection), expected in EXPECTED.items():
            for metric, mean, value in zip(METRICS, means(scenario, imperfection), expected):
                with self.subTest(scenario=scenario, imperfection=imperfection, metric=metric):
                    self.assertAlmostEqual(mean, value, delta=MARGIN * value)


if __name__ == "__main__":
    if sys.argv[1:] == ["--measure"]:
        print_measured()
    else:
        unittest.main(argv=sys.argv[:1])
