# SPDX-License-Identifier: MIT
"""What the scenarios measure today, bounded on both sides; and their limits, bounded by what is measured.

The limits in the scenario files say what a user may rely on and leave room. These figures say what the
drive does: a change that moves one by more than a fifth, for better or worse, has to be understood and
the table changed with it. Of a set with noise a figure is the mean over four seeds.

test_expected.py MOTORSIM RESULTS RUN... [Expected.test_case]...
                                     holds the table, which has to be of just these runs, SCENARIO:SET; the tests of their
                                     limits have left in the folder RESULTS what they measured with the first seed
test_expected.py MOTORSIM --measure  prints the table as it is measured now, and writes the rows of docs/results.md
"""

import functools
import json
import math
import re
import subprocess
import sys
import tomllib
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

MOTORSIM, *ARGUMENTS = sys.argv[1:]
MEASURES = ARGUMENTS == ["--measure"]
RESULTS_FOLDER = None if MEASURES else Path(ARGUMENTS.pop(0))
RUNS = [word for word in ARGUMENTS if ":" in word]
CASES = [word for word in ARGUMENTS if ":" not in word]
ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "host_sim" / "scenarios"
RESULTS = ROOT / "docs/results.md"
MARGIN = 0.2
NOISY, SEEDS = {"adc", "imp", "all"}, range(1, 5)
JOBS = 2
# Below these a figure is a rounding of converter or frame: they add to the margin, and to what a limit may be.
FINEST = {
    "speed_error_max_rpm": 0.0,
    "speed_error_rms_rpm": 0.0,
    "angle_error_max_deg": 0.0,
    "iq_error_max_a": 0.0,
    "command_error_settled_pct": 0.02,
    "position_error_final_rad": 1e-3,
    "id_settled_a": 0.01,
}
METRICS = tuple(FINEST)
ROUNDED = 0.05  # of a figure with one digit behind the point, as docs/results.md has them
# A limit is no farther from the worst of its runs: room for other noise and another machine, not for another drive.
ROOM = 2.0
# Their limits judge other motors than that of these runs: those of a campaign, and any.
ELSEWHERE = {"campaign", "any"}
EXPECTED = {
    ("s1", "ideal"): (3.34, 0.631, 0.259, 0.0426, 0.0643, None, 9.55e-05),
    ("s1", "adc"): (9.00, 2.25, 0.366, 0.0842, 0.148, None, 0.00112),
    ("s2", "ideal"): (6.94, 0.744, 0.105, 0.0475, 0.0449, None, 0.000129),
    ("s2", "adc"): (9.97, 2.51, 0.116, 0.0600, 0.133, None, 0.00853),
    ("s3", "ideal"): (3.33, 0.702, 0.587, 0.0347, None, 0.00437, 0.000261),
    ("s3", "adc"): (9.05, 2.21, 0.643, 0.0658, None, 0.00476, 0.00120),
    ("s1_robust", "ideal"): (10.3, 1.74, 0.958, 0.356, 0.0436, None, 8.40),
    ("s1_robust", "adc"): (17.6, 2.17, 1.28, 0.406, 0.0819, None, 8.36),
    ("s1_robust", "deadtime"): (12.9, 2.15, 0.966, 0.357, 0.0598, None, 8.40),
    ("s1_robust", "hot"): (10.2, 1.90, 0.958, 0.590, 0.0481, None, 8.51),
    ("s1_robust", "saturated"): (10.1, 1.73, 0.738, 0.297, 0.0389, None, 8.40),
    ("s1_robust", "imp"): (35.8, 3.76, 1.85, 1.01, 0.402, None, 8.37),
    ("s1_robust", "all"): (19.5, 3.94, 1.90, 0.655, 0.351, None, 8.46),
    ("s2_robust", "ideal"): (14.2, 1.60, 0.0766, 0.0244, 0.0295, None, 0.000755),
    ("s2_robust", "adc"): (16.5, 1.87, 0.107, 0.0539, 0.0623, None, 0.00696),
    ("s2_robust", "deadtime"): (17.0, 1.98, 0.167, 0.0522, 0.0784, None, 1.35),
    ("s2_robust", "hot"): (14.3, 1.57, 0.139, 0.0269, 0.0320, None, 0.00353),
    ("s2_robust", "saturated"): (14.3, 1.59, 0.0763, 0.0297, 0.0256, None, 0.000310),
    ("s2_robust", "imp"): (15.9, 2.20, 0.258, 0.0696, 0.103, None, 1.37),
    ("s2_robust", "all"): (16.7, 3.01, 0.282, 0.115, 0.145, None, 1.37),
    ("s3_robust", "ideal"): (25.0, 4.49, 3.60, 1.44, None, 4.56e-05, 8.82),
    ("s3_robust", "adc"): (27.8, 4.55, 3.48, 1.39, None, 0.00312, 8.79),
    ("s3_robust", "deadtime"): (25.0, 4.62, 3.65, 1.47, None, 0.000327, 8.82),
    ("s3_robust", "hot"): (27.5, 4.97, 3.69, 1.33, None, 0.000288, 8.84),
    ("s3_robust", "saturated"): (23.3, 4.49, 3.59, 1.53, None, 2.63e-05, 8.82),
    ("s3_robust", "imp"): (27.3, 4.69, 3.82, 1.49, None, 0.000196, 8.82),
    ("s3_robust", "all"): (31.0, 5.21, 3.13, 1.20, None, 0.00542, 8.79),
    ("s4", "ideal"): (7.63, 0.718, 0.0741, 0.0242, 0.989, None, 8.49e-05),
    ("s4", "adc"): (7.68, 0.723, 0.0729, 0.0243, 0.990, None, 0.00765),
    ("s4", "encoder"): (8.19, 0.754, 0.111, 0.0381, 1.00, None, 0.000110),
    ("s4", "adc+encoder"): (8.10, 0.747, 0.110, 0.0379, 0.992, None, 0.00763),
    ("s4", "hot"): (7.73, 0.712, 0.0743, 0.0199, 0.955, None, 0.000461),
    ("s4", "deadtime"): (7.45, 0.549, 0.0704, 0.0547, 1.09, None, 5.23e-05),
    ("s4", "imp"): (7.42, 0.535, 0.0703, 0.742, 1.01, None, 7.73e-05),
    ("s4", "all"): (7.45, 0.561, 0.0717, 0.675, 1.18, None, 0.00819),
    ("s4", "saturated"): (7.63, 0.706, 0.0726, 0.812, 0.444, None, 0.000635),
    ("s5", "ideal"): (4.76, 1.09, 0.162, 0.0145, 1.01, None, 0.00199),
    ("s5", "adc"): (7.82, 1.94, 0.281, 0.0472, 1.02, None, 0.00848),
    ("s5", "deadtime"): (6.72, 1.41, 0.284, 0.0252, 1.15, None, 0.00293),
    ("s5", "hot"): (4.56, 0.824, 0.143, 0.0106, 1.09, None, 0.00296),
    ("s5", "saturated"): (4.75, 0.864, 0.145, 0.0140, 0.474, None, 0.00132),
    ("s5", "imp"): (9.81, 2.13, 0.478, 0.0436, 1.07, None, 0.00810),
    ("s5", "all"): (9.73, 2.11, 0.463, 0.0543, 1.24, None, 0.0159),
    ("steady", "ideal"): (1.42, 0.319, 0.0501, 0.0212, 0.153, None, 0.000304),
    ("steady", "deadtime"): (20.3, 3.42, 0.572, 0.233, 1.56, None, 0.752),
    ("steady", "imp"): (21.4, 3.99, 0.733, 0.259, 2.00, None, 0.830),
    ("steady", "all"): (19.5, 3.79, 0.662, 0.275, 1.99, None, 0.667),
    ("campaign", "ideal"): (18.5, 1.93, 0.0882, 0.0294, 0.0292, None, 0.00135),
    ("campaign", "adc"): (19.7, 2.24, 0.132, 0.0642, 0.0655, None, 0.0104),
    ("campaign", "deadtime"): (17.6, 2.19, 0.172, 0.0711, 0.0838, None, 1.35),
    ("campaign", "hot"): (18.5, 1.90, 0.173, 0.0303, 0.0254, None, 0.00648),
    ("campaign", "saturated"): (18.7, 1.94, 0.0884, 0.0386, 0.0255, None, 0.000319),
    ("campaign", "imp"): (21.4, 2.53, 0.252, 0.0953, 0.106, None, 1.37),
    ("campaign", "all"): (19.9, 3.68, 0.382, 0.132, 0.174, None, 1.39),
    ("any", "ideal"): (20.2, 1.94, 0.951, 0.187, 0.0495, None, 0.00127),
    ("any", "deadtime"): (22.2, 2.17, 0.950, 0.185, 0.0672, None, 3.49),
    ("any", "imp"): (21.9, 2.26, 2.42, 0.270, 0.153, None, 3.40),
    ("any", "all"): (22.6, 2.72, 2.77, 0.404, 0.193, None, 3.44),
    ("s1_motor_b", "ideal"): (4.04, 0.923, 1.81, 0.455, 0.000950, None, 3.54),
    ("s1_motor_b", "adc"): (5.86, 1.30, 2.11, 0.481, 0.00181, None, 3.52),
    ("s1_motor_b", "hot"): (12.3, 1.31, 2.03, 0.626, 0.00179, None, 3.61),
    ("s1_motor_b", "saturated"): (3.39, 0.835, 1.35, 0.380, 0.000632, None, 3.54),
    ("s1_motor_b", "adc+hot+saturated"): (11.2, 1.58, 1.79, 0.826, 0.00522, None, 3.59),
    ("s1_motor_b", "deadtime"): (5.81, 1.01, 1.81, 0.459, 0.000674, None, 3.54),
    ("s1_motor_b", "imp"): (20.9, 1.89, 2.84, 0.777, 0.00428, None, 3.44),
    ("s1_motor_b", "all"): (10.8, 1.69, 2.37, 0.783, 0.00, None, 3.59),
    ("s2_motor_b", "ideal"): (3.79, 1.04, 0.0947, 0.00938, 0.600, None, 0.000367),
    ("s2_motor_b", "adc"): (6.18, 1.61, 0.172, 0.0336, 0.613, None, 0.00389),
    ("s2_motor_b", "hot"): (3.77, 0.891, 0.0816, 0.00912, 0.648, None, 0.000532),
    ("s2_motor_b", "saturated"): (3.32, 0.860, 0.0663, 0.00966, 0.606, None, 0.000181),
    ("s2_motor_b", "adc+hot+saturated"): (5.37, 1.27, 0.139, 0.0313, 0.662, None, 0.00453),
    ("s2_motor_b", "deadtime"): (19.3, 3.73, 0.758, 0.0466, 0.602, None, 0.568),
    ("s2_motor_b", "imp"): (19.2, 5.14, 0.752, 0.0642, 0.588, None, 0.566),
    ("s2_motor_b", "all"): (19.5, 4.22, 0.804, 0.0797, 0.691, None, 0.572),
    ("s1_odrive_d5065", "ideal"): (91.0, 19.3, 4.28, 6.65, 0.0497, None, 19.4),
    ("s1_odrive_d5065", "adc"): (85.6, 17.9, 3.76, 5.35, 0.0519, None, 19.3),
    ("s1_odrive_d5065", "hot"): (93.7, 8.06, 4.14, 5.78, 0.0148, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (105., 10.9, 5.22, 10.4, 0.00808, None, 19.4),
    ("s1_odrive_d5065", "adc+hot+saturated"): (97.4, 7.66, 4.90, 7.93, 0.0120, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (79.6, 28.2, 3.26, 3.11, 0.130, None, 3.20),
    ("s2_odrive_d5065", "adc"): (75.3, 28.4, 3.25, 2.93, 0.131, None, 3.18),
    ("s2_odrive_d5065", "hot"): (38.8, 5.64, 2.15, 2.28, 0.132, None, 3.35),
    ("s2_odrive_d5065", "saturated"): (51.9, 3.80, 2.76, 3.19, 0.129, None, 3.35),
    ("s2_odrive_d5065", "adc+hot+saturated"): (45.8, 3.87, 2.58, 3.34, 0.131, None, 3.36),
    ("s1_teknic_m2310p", "ideal"): (28.0, 3.45, 0.981, 0.261, 0.0687, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (31.2, 3.82, 2.40, 0.329, 0.0948, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (23.6, 3.29, 1.64, 0.464, 0.0719, None, 4.33),
    ("s1_teknic_m2310p", "saturated"): (22.9, 3.77, 0.781, 0.201, 0.0953, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (30.1, 4.20, 4.07, 0.467, 0.0961, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (49.0, 3.98, 0.286, 0.0905, 0.0340, None, 1.10),
    ("s2_teknic_m2310p", "adc"): (47.9, 4.19, 0.285, 0.119, 0.0323, None, 1.09),
    ("s2_teknic_m2310p", "hot"): (48.3, 3.94, 0.255, 0.0786, 0.0292, None, 1.09),
    ("s2_teknic_m2310p", "saturated"): (48.0, 3.95, 0.345, 0.105, 0.0327, None, 1.09),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (50.3, 4.71, 0.397, 0.134, 0.0387, None, 1.09),
}


def measured(scenario, imperfection, seed):
    if RESULTS_FOLDER and seed == SEEDS[0]:
        result = json.loads((RESULTS_FOLDER / f"{scenario}.{imperfection}.json").read_text(encoding="utf-8"))
        assert result["seed"] == seed, f"{scenario} has the seed {result['seed']}"
        return result
    sets = [word for name in imperfection.split("+") for word in ("--with", name)]
    done = subprocess.run([MOTORSIM, "run", scenario, *sets, "--json", "-", "--set",
                           f"scenario.seed={seed}"], text=True, capture_output=True, check=False)
    return json.loads(done.stdout)


def seeds_of(imperfection):
    return SEEDS if NOISY & set(imperfection.split("+")) else SEEDS[:1]


@functools.cache
def all_runs():
    """The results of every run of the table, a list over the seeds."""
    jobs = [(run, seed) for run in EXPECTED for seed in seeds_of(run[1])]
    with ThreadPoolExecutor(JOBS) as pool:
        results = list(pool.map(lambda job: measured(*job[0], job[1]), jobs))
    found = {run: [] for run in EXPECTED}
    for (run, _), result in zip(jobs, results):
        found[run].append(result)
    return found


def means(run):
    """Each of METRICS, its mean over the seeds; None where it does not apply."""
    results = all_runs()[run]
    return [None if results[0][metric] is None else
            sum(result[metric] for result in results) / len(results) for metric in METRICS]


def print_measured():
    write_results()
    for run in EXPECTED:
        figures = ", ".join("None" if mean is None else f"{mean:#.3g}" for mean in means(run))
        print(f'    ("{run[0]}", "{run[1]}"): ({figures}),')


def pair(scenario, imperfection):
    """Speed error in % and angle error, as docs/results.md shows them: of the first seed."""
    result = all_runs()[scenario, imperfection][0]
    return f"{result['speed_error_max_pct']:.2g}, {result['angle_error_max_deg']:.1f}°"


def result_rows():
    """The rows of docs/results.md that state what scenarios measure."""
    for name in ("ideal", "adc", "deadtime", "hot", "saturated", "imp", "all"):
        end = all_runs()["s3_robust", name][0]["position_error_final_rad"]
        pairs = " | ".join(pair(f"{scenario}_robust", name) for scenario in ("s1", "s2", "s3"))
        yield f"| `{name}` | {pairs} | {math.degrees(end):.2f}° |"
    for name, shown in (("ideal", "`ideal`"), ("adc", "`adc`"), ("hot", "`hot`"),
                        ("saturated", "`saturated`"), ("adc+hot+saturated", "all three")):
        cells = (", ".join(f"{all_runs()[f'{scenario}_{motor}', name][0]['speed_error_max_pct']:.2g}"
                           for scenario in ("s1", "s2"))
                 for motor in ("motor_b", "odrive_d5065", "teknic_m2310p"))
        yield f"| {shown} | {' | '.join(cells)} |"


def write_results():
    """Each row of the page in place of the one with its label and as many figures."""
    anew = {(label, len(values)): row for row in result_rows() for label, values in [numbers(row)]}
    lines = RESULTS.read_text(encoding="utf-8").splitlines()
    shown = (anew.get((label, len(values)), line) for line in lines for label, values in [numbers(line)])
    RESULTS.write_text("".join(f"{line}\n" for line in shown), encoding="utf-8")


def numbers(line):
    """Label and figures of a row of a table; of other lines something that is neither."""
    label, _, cells = line.removeprefix("|").partition("|")
    return label.strip(), [float(text) for text in re.findall(r"\d+\.?\d*", cells)]


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
        for run, expected in EXPECTED.items():
            for metric, mean, value in zip(METRICS, means(run), expected, strict=True):
                with self.subTest(run=run, metric=metric):
                    self.assertEqual(mean is None, value is None)
                    if value is not None:
                        self.assertAlmostEqual(mean, value, delta=MARGIN * value + FINEST[metric])

    def test_every_scenario_is_run_and_every_run_is_in_the_table(self):
        self.assertEqual({":".join(run) for run in EXPECTED}, set(RUNS))
        self.assertEqual({scenario for scenario, _ in EXPECTED},
                         {path.stem for path in SCENARIOS.glob("*.toml")})

    def test_the_results_page_shows_what_is_measured(self):
        shown = [numbers(line) for line in RESULTS.read_text(encoding="utf-8").splitlines()]
        for name, values in map(numbers, result_rows()):
            found = [row for label, row in shown if label == name and len(row) == len(values)]
            with self.subTest(row=name, values=values):
                self.assertEqual(len(found), 1)
                for text, value in zip(found[0], values):
                    self.assertAlmostEqual(text, value, delta=MARGIN * value + ROUNDED)

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
        results = [result for (name, imperfection), found in all_runs().items() if name == scenario
                   and (imperfection if imperfection in chosen else "any") == selection
                   for result in found]
        names = {name for name in results[0]
                 if all(isinstance(result[name], (int, float)) for result in results)} if results else ()
        return {name: max(result[name] for result in results) for name in names}


if __name__ == "__main__":
    if MEASURES:
        print_measured()
    else:
        unittest.main(argv=[sys.argv[0], *CASES])
