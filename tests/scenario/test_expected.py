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
    ("s1", "ideal"): (3.88, 0.676, 0.257, 0.0460, 0.0684, None, 3.70e-05),
    ("s1", "adc"): (9.30, 2.24, 0.367, 0.0825, 0.158, None, 0.00125),
    ("s2", "ideal"): (7.28, 0.773, 0.105, 0.0478, 0.0367, None, 0.000223),
    ("s2", "adc"): (10.3, 2.47, 0.119, 0.0615, 0.133, None, 0.00851),
    ("s3", "ideal"): (3.48, 0.661, 0.550, 0.0369, None, 0.00419, 0.000188),
    ("s3", "adc"): (9.14, 2.22, 0.646, 0.0662, None, 0.00484, 0.00121),
    ("s1_robust", "ideal"): (28.1, 7.69, 0.961, 0.356, 0.0400, None, 8.41),
    ("s1_robust", "adc"): (29.0, 7.70, 1.29, 0.412, 0.0812, None, 8.37),
    ("s1_robust", "deadtime"): (48.6, 8.49, 1.88, 0.870, 0.0727, None, 8.41),
    ("s1_robust", "hot"): (28.5, 7.69, 0.957, 0.587, 0.0498, None, 8.49),
    ("s1_robust", "saturated"): (27.8, 7.76, 0.735, 0.297, 0.0444, None, 8.41),
    ("s1_robust", "imp"): (53.4, 8.55, 1.72, 1.19, 0.432, None, 8.38),
    ("s1_robust", "all"): (42.0, 8.80, 1.84, 1.42, 0.421, None, 8.45),
    ("s2_robust", "ideal"): (14.8, 1.61, 0.0753, 0.0263, 0.0307, None, 0.000755),
    ("s2_robust", "adc"): (15.7, 1.86, 0.117, 0.0530, 0.0620, None, 0.00623),
    ("s2_robust", "deadtime"): (17.2, 2.34, 0.453, 0.0760, 0.0795, None, 1.34),
    ("s2_robust", "hot"): (14.5, 1.56, 0.145, 0.0277, 0.0239, None, 0.00414),
    ("s2_robust", "saturated"): (14.2, 1.57, 0.0685, 0.0260, 0.0224, None, 0.000500),
    ("s2_robust", "imp"): (16.5, 2.25, 0.238, 0.0712, 0.0988, None, 1.34),
    ("s2_robust", "all"): (20.2, 3.54, 0.347, 0.144, 0.173, None, 1.27),
    ("s3_robust", "ideal"): (37.7, 7.52, 2.75, 1.27, None, 2.78e-05, 8.91),
    ("s3_robust", "adc"): (44.6, 7.59, 3.01, 1.33, None, 0.00315, 8.86),
    ("s3_robust", "deadtime"): (40.3, 7.71, 2.68, 1.21, None, 2.76e-05, 8.87),
    ("s3_robust", "hot"): (42.1, 8.17, 2.42, 1.05, None, 2.11e-06, 8.98),
    ("s3_robust", "saturated"): (31.8, 7.62, 2.62, 1.33, None, 3.36e-05, 8.91),
    ("s3_robust", "imp"): (48.1, 7.84, 3.13, 1.40, None, 0.000278, 8.84),
    ("s3_robust", "all"): (41.8, 8.27, 2.55, 1.08, None, 0.00536, 8.89),
    ("s4", "ideal"): (7.69, 0.726, 0.0720, 0.0256, 1.10, None, 0.00337),
    ("s4", "adc"): (7.70, 0.726, 0.0728, 0.0264, 1.09, None, 0.0110),
    ("s4", "encoder"): (8.22, 0.750, 0.119, 0.0400, 1.09, None, 0.00336),
    ("s4", "adc+encoder"): (8.30, 0.754, 0.128, 0.0431, 1.09, None, 0.0111),
    ("s4", "hot"): (7.79, 0.727, 0.0749, 0.0333, 0.950, None, 0.00221),
    ("s4", "deadtime"): (7.47, 0.561, 0.0718, 0.150, 0.855, None, 0.00148),
    ("s4", "imp"): (7.40, 0.572, 0.0706, 0.973, 0.697, None, 0.00258),
    ("s4", "all"): (7.46, 0.635, 0.0702, 1.10, 1.04, None, 0.00384),
    ("s4", "saturated"): (7.55, 0.659, 0.0732, 0.741, 0.967, None, 0.00179),
    ("s5", "ideal"): (4.97, 1.05, 0.165, 0.0121, 1.69, None, 0.00794),
    ("s5", "adc"): (7.54, 1.92, 0.227, 0.0477, 1.71, None, 0.0113),
    ("s5", "hot"): (4.73, 0.920, 0.160, 0.0133, 1.55, None, 0.00720),
    ("s5", "saturated"): (4.64, 0.877, 0.0725, 0.0121, 1.66, None, 0.00153),
    ("steady", "ideal"): (1.17, 0.319, 0.0444, 0.0190, 0.130, None, 0.000257),
    ("steady", "deadtime"): (42.4, 4.44, 1.70, 0.516, 3.37, None, 0.615),
    ("steady", "imp"): (37.2, 5.23, 1.30, 0.465, 3.04, None, 0.614),
    ("steady", "all"): (26.9, 4.54, 1.13, 0.442, 2.69, None, 0.523),
    ("campaign", "ideal"): (18.2, 1.89, 0.0906, 0.0462, 0.0276, None, 0.00131),
    ("campaign", "adc"): (18.7, 2.15, 0.166, 0.0722, 0.0708, None, 0.0134),
    ("campaign", "deadtime"): (18.6, 2.19, 0.132, 0.0746, 0.0853, None, 1.34),
    ("campaign", "hot"): (18.5, 1.89, 0.176, 0.0442, 0.0288, None, 0.00656),
    ("campaign", "saturated"): (18.5, 1.91, 0.0732, 0.0497, 0.0245, None, 0.000114),
    ("campaign", "imp"): (20.6, 2.56, 0.256, 0.0879, 0.127, None, 1.34),
    ("campaign", "all"): (22.8, 3.80, 0.408, 0.140, 0.178, None, 1.27),
    ("any", "ideal"): (30.1, 5.90, 0.948, 0.353, 0.0482, None, 0.000340),
    ("any", "deadtime"): (30.0, 6.14, 0.960, 0.356, 0.0697, None, 3.48),
    ("any", "imp"): (34.0, 6.30, 1.91, 0.851, 0.170, None, 3.36),
    ("any", "all"): (33.4, 6.29, 2.32, 0.562, 0.253, None, 3.42),
    ("s1_motor_b", "ideal"): (4.59, 2.34, 1.79, 0.452, 0.00260, None, 3.55),
    ("s1_motor_b", "adc"): (7.39, 2.52, 2.08, 0.466, 0.00206, None, 3.53),
    ("s1_motor_b", "hot"): (20.3, 2.54, 2.01, 0.701, 0.00187, None, 3.60),
    ("s1_motor_b", "saturated"): (4.33, 2.31, 1.32, 0.376, 0.00168, None, 3.55),
    ("s1_motor_b", "adc+hot+saturated"): (19.7, 2.74, 1.77, 0.904, 0.00299, None, 3.58),
    ("s1_motor_b", "deadtime"): (12.1, 2.41, 1.79, 0.453, 0.00130, None, 3.55),
    ("s1_motor_b", "imp"): (31.1, 2.97, 3.26, 1.00, 0.00302, None, 3.50),
    ("s1_motor_b", "all"): (20.6, 2.78, 2.42, 0.905, 3.62e-05, None, 3.58),
    ("s2_motor_b", "ideal"): (4.80, 1.56, 0.120, 0.0112, 0.605, None, 0.00102),
    ("s2_motor_b", "adc"): (7.48, 2.00, 0.188, 0.0353, 0.605, None, 0.00368),
    ("s2_motor_b", "hot"): (4.70, 1.48, 0.114, 0.0102, 0.655, None, 0.000981),
    ("s2_motor_b", "saturated"): (4.39, 1.45, 0.0705, 0.0110, 0.605, None, 9.78e-05),
    ("s2_motor_b", "adc+hot+saturated"): (6.55, 1.72, 0.149, 0.0355, 0.654, None, 0.00417),
    ("s2_motor_b", "deadtime"): (16.0, 3.98, 0.637, 0.0413, 0.757, None, 0.428),
    ("s2_motor_b", "imp"): (20.1, 5.28, 0.843, 0.0642, 0.639, None, 0.381),
    ("s2_motor_b", "all"): (22.6, 4.67, 0.915, 0.0877, 0.679, None, 0.479),
    ("s1_odrive_d5065", "ideal"): (125., 20.1, 5.37, 7.10, 0.0534, None, 19.4),
    ("s1_odrive_d5065", "adc"): (113., 18.5, 4.75, 6.87, 0.0666, None, 19.3),
    ("s1_odrive_d5065", "hot"): (82.5, 12.7, 3.62, 5.45, 0.0238, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (99.4, 13.0, 4.54, 9.11, 0.0227, None, 19.4),
    ("s1_odrive_d5065", "adc+hot+saturated"): (94.4, 11.6, 4.36, 8.72, 0.0192, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (80.7, 23.3, 3.64, 2.69, 0.175, None, 2.27),
    ("s2_odrive_d5065", "adc"): (74.6, 22.6, 3.45, 2.58, 0.160, None, 2.37),
    ("s2_odrive_d5065", "hot"): (47.4, 8.90, 2.76, 2.21, 0.134, None, 3.07),
    ("s2_odrive_d5065", "saturated"): (55.1, 8.90, 3.00, 3.70, 0.143, None, 3.22),
    ("s2_odrive_d5065", "adc+hot+saturated"): (53.1, 6.92, 2.90, 3.45, 0.133, None, 3.24),
    ("s1_teknic_m2310p", "ideal"): (73.1, 12.6, 0.707, 0.215, 0.0787, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (66.2, 12.4, 2.30, 0.315, 0.104, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (70.4, 12.4, 1.59, 0.392, 0.0702, None, 4.34),
    ("s1_teknic_m2310p", "saturated"): (70.7, 12.7, 0.551, 0.174, 0.110, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (62.1, 12.3, 4.09, 0.448, 0.104, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (48.3, 3.97, 0.312, 0.103, 0.0368, None, 1.09),
    ("s2_teknic_m2310p", "adc"): (47.7, 4.21, 0.303, 0.109, 0.0392, None, 1.08),
    ("s2_teknic_m2310p", "hot"): (48.6, 3.90, 0.306, 0.0767, 0.0248, None, 1.09),
    ("s2_teknic_m2310p", "saturated"): (50.4, 4.05, 0.332, 0.140, 0.0302, None, 1.09),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (49.2, 4.62, 0.458, 0.140, 0.0414, None, 1.08),
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
        names = {name for result in results for name, value in result.items()
                 if isinstance(value, (int, float))}
        return {name: max(result[name] for result in results) for name in names}


if __name__ == "__main__":
    if MEASURES:
        print_measured()
    else:
        unittest.main(argv=[sys.argv[0], *CASES])
