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
    ("s1", "ideal"): (3.88, 0.676, 0.257, 0.0460),
    ("s1", "adc"): (8.89, 2.24, 0.370, 0.0843),
    ("s2", "ideal"): (7.28, 0.773, 0.105, 0.0478),
    ("s2", "adc"): (9.65, 2.50, 0.117, 0.0594),
    ("s3", "ideal"): (3.48, 0.661, 0.550, 0.0369),
    ("s3", "adc"): (9.48, 2.24, 0.637, 0.0694),
    ("s1_robust", "ideal"): (28.1, 7.69, 0.961, 0.356),
    ("s1_robust", "adc"): (29.3, 7.70, 1.28, 0.419),
    ("s2_robust", "ideal"): (14.8, 1.61, 0.0753, 0.0263),
    ("s2_robust", "adc"): (15.8, 1.86, 0.117, 0.0534),
    ("s3_robust", "ideal"): (38.2, 7.52, 2.75, 1.27),
    ("s3_robust", "adc"): (44.7, 7.63, 3.06, 1.37),
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
