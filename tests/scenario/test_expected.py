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
    ("s1_robust", "ideal"): (10.3, 1.72, 0.963, 0.355, 0.0437, None, 8.40),
    ("s1_robust", "adc"): (17.9, 2.17, 1.28, 0.404, 0.0798, None, 8.36),
    ("s1_robust", "deadtime"): (13.2, 2.26, 0.964, 0.358, 0.0603, None, 8.40),
    ("s1_robust", "hot"): (11.5, 1.93, 0.959, 0.603, 0.0366, None, 8.50),
    ("s1_robust", "saturated"): (9.85, 1.65, 0.803, 0.311, 0.0379, None, 8.40),
    ("s1_robust", "imp"): (36.2, 4.15, 1.20, 0.756, 0.343, None, 8.37),
    ("s1_robust", "all"): (15.2, 3.17, 1.66, 0.611, 0.328, None, 8.45),
    ("s2_robust", "ideal"): (14.2, 1.62, 0.0686, 0.0223, 0.0277, None, 0.000243),
    ("s2_robust", "adc"): (16.8, 1.88, 0.126, 0.0576, 0.0592, None, 0.00723),
    ("s2_robust", "deadtime"): (16.5, 2.02, 0.161, 0.0664, 0.0842, None, 1.35),
    ("s2_robust", "hot"): (14.6, 1.64, 0.0834, 0.0249, 0.0253, None, 0.000253),
    ("s2_robust", "saturated"): (14.5, 1.60, 0.0659, 0.0265, 0.0236, None, 0.000285),
    ("s2_robust", "imp"): (17.0, 2.25, 0.260, 0.0750, 0.105, None, 1.37),
    ("s2_robust", "all"): (19.4, 3.04, 0.323, 0.138, 0.155, None, 1.38),
    ("s3_robust", "ideal"): (25.0, 4.47, 3.56, 1.43, None, 4.50e-05, 8.82),
    ("s3_robust", "adc"): (27.2, 4.56, 3.53, 1.40, None, 0.00310, 8.78),
    ("s3_robust", "deadtime"): (25.0, 4.54, 3.52, 1.42, None, 0.000322, 8.80),
    ("s3_robust", "hot"): (25.6, 4.85, 3.71, 1.31, None, 0.000289, 8.84),
    ("s3_robust", "saturated"): (24.0, 4.38, 3.63, 1.56, None, 2.58e-05, 8.82),
    ("s3_robust", "imp"): (26.7, 4.69, 3.57, 1.43, None, 0.000213, 8.81),
    ("s3_robust", "all"): (28.0, 5.06, 3.42, 1.24, None, 0.00519, 8.78),
    ("s4", "ideal"): (7.70, 0.725, 0.0737, 0.0249, 0.992, None, 9.68e-05),
    ("s4", "adc"): (7.68, 0.722, 0.0732, 0.0245, 0.990, None, 0.00763),
    ("s4", "encoder"): (8.45, 0.748, 0.144, 0.0422, 0.991, None, 0.000116),
    ("s4", "adc+encoder"): (8.11, 0.748, 0.112, 0.0377, 0.992, None, 0.00763),
    ("s4", "hot"): (7.74, 0.712, 0.0743, 0.0186, 0.954, None, 0.000466),
    ("s4", "deadtime"): (7.46, 0.549, 0.0702, 0.0553, 1.09, None, 4.60e-05),
    ("s4", "imp"): (7.44, 0.536, 0.0709, 0.743, 1.01, None, 5.13e-05),
    ("s4", "all"): (7.48, 0.562, 0.0716, 0.674, 1.17, None, 0.00820),
    ("s4", "saturated"): (7.56, 0.701, 0.0720, 0.812, 0.446, None, 0.000640),
    ("s5", "ideal"): (5.09, 1.10, 0.116, 0.0159, 1.02, None, 0.00150),
    ("s5", "adc"): (7.30, 1.94, 0.385, 0.0462, 1.01, None, 0.0113),
    ("s5", "deadtime"): (7.20, 1.44, 0.213, 0.0272, 1.11, None, 0.000732),
    ("s5", "hot"): (4.66, 0.832, 0.113, 0.0111, 1.09, None, 0.00157),
    ("s5", "saturated"): (5.11, 0.864, 0.0750, 0.0141, 0.474, None, 0.000782),
    ("s5", "imp"): (9.82, 2.14, 0.384, 0.0412, 1.09, None, 0.00432),
    ("s5", "all"): (9.19, 2.05, 0.428, 0.0536, 1.22, None, 0.0162),
    ("steady", "ideal"): (1.21, 0.318, 0.0375, 0.0215, 0.141, None, 0.000179),
    ("steady", "deadtime"): (19.8, 3.77, 0.568, 0.244, 1.60, None, 0.775),
    ("steady", "imp"): (20.9, 4.11, 0.720, 0.253, 1.93, None, 0.831),
    ("steady", "all"): (20.8, 3.68, 0.593, 0.288, 1.76, None, 0.687),
    ("campaign", "ideal"): (19.0, 1.97, 0.0840, 0.0309, 0.0287, None, 0.000123),
    ("campaign", "adc"): (18.2, 2.19, 0.169, 0.0598, 0.0695, None, 0.0130),
    ("campaign", "deadtime"): (19.7, 2.23, 0.194, 0.0817, 0.0696, None, 1.35),
    ("campaign", "hot"): (19.1, 2.02, 0.0858, 0.0300, 0.0261, None, 0.00146),
    ("campaign", "saturated"): (18.9, 1.96, 0.0826, 0.0348, 0.0240, None, 0.000369),
    ("campaign", "imp"): (22.0, 2.53, 0.232, 0.0868, 0.115, None, 1.37),
    ("campaign", "all"): (23.6, 3.86, 0.452, 0.144, 0.189, None, 1.39),
    ("any", "ideal"): (20.3, 1.94, 0.959, 0.186, 0.0548, None, 0.000328),
    ("any", "deadtime"): (22.1, 2.16, 0.953, 0.186, 0.0903, None, 3.49),
    ("any", "imp"): (23.2, 2.32, 2.30, 0.253, 0.145, None, 3.40),
    ("any", "all"): (25.3, 2.64, 2.36, 0.347, 0.140, None, 3.43),
    ("s1_motor_b", "ideal"): (4.03, 0.926, 1.81, 0.453, 0.000653, None, 3.54),
    ("s1_motor_b", "adc"): (6.80, 1.30, 2.11, 0.484, 0.00166, None, 3.52),
    ("s1_motor_b", "hot"): (11.4, 1.30, 2.02, 0.629, 0.00192, None, 3.61),
    ("s1_motor_b", "saturated"): (3.42, 0.774, 1.44, 0.399, 0.000276, None, 3.54),
    ("s1_motor_b", "adc+hot+saturated"): (12.3, 1.56, 1.87, 0.830, 0.00335, None, 3.59),
    ("s1_motor_b", "deadtime"): (6.70, 1.00, 1.81, 0.459, 0.00106, None, 3.54),
    ("s1_motor_b", "imp"): (19.3, 1.83, 2.59, 0.746, 0.00427, None, 3.44),
    ("s1_motor_b", "all"): (12.5, 1.65, 2.46, 0.772, 0.00, None, 3.59),
    ("s2_motor_b", "ideal"): (3.90, 1.02, 0.0981, 0.00898, 0.609, None, 0.000355),
    ("s2_motor_b", "adc"): (6.34, 1.59, 0.182, 0.0368, 0.616, None, 0.00330),
    ("s2_motor_b", "hot"): (3.75, 0.886, 0.0776, 0.00958, 0.649, None, 0.000321),
    ("s2_motor_b", "saturated"): (3.58, 0.867, 0.0664, 0.0115, 0.605, None, 0.000197),
    ("s2_motor_b", "adc+hot+saturated"): (5.62, 1.25, 0.144, 0.0330, 0.664, None, 0.00346),
    ("s2_motor_b", "deadtime"): (19.3, 3.26, 0.702, 0.0482, 0.618, None, 0.601),
    ("s2_motor_b", "imp"): (14.2, 3.55, 0.528, 0.0543, 0.619, None, 0.576),
    ("s2_motor_b", "all"): (26.3, 4.11, 0.873, 0.0924, 0.678, None, 0.577),
    ("s1_odrive_d5065", "ideal"): (92.1, 19.1, 4.08, 6.29, 0.0575, None, 19.4),
    ("s1_odrive_d5065", "adc"): (95.4, 18.8, 4.30, 5.88, 0.0522, None, 19.3),
    ("s1_odrive_d5065", "hot"): (87.2, 8.68, 4.08, 6.73, 0.0209, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (158., 15.4, 7.36, 11.8, 0.0193, None, 19.4),
    ("s1_odrive_d5065", "adc+hot+saturated"): (88.1, 6.92, 4.86, 7.73, 0.0105, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (78.5, 28.7, 3.21, 3.19, 0.126, None, 3.18),
    ("s2_odrive_d5065", "adc"): (74.5, 27.7, 3.23, 2.91, 0.130, None, 3.23),
    ("s2_odrive_d5065", "hot"): (39.8, 5.82, 2.12, 2.34, 0.131, None, 3.36),
    ("s2_odrive_d5065", "saturated"): (51.7, 4.19, 2.77, 3.27, 0.131, None, 3.40),
    ("s2_odrive_d5065", "adc+hot+saturated"): (46.3, 3.60, 2.65, 3.17, 0.132, None, 3.36),
    ("s1_teknic_m2310p", "ideal"): (25.7, 3.40, 0.794, 0.246, 0.0775, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (33.0, 3.83, 2.38, 0.326, 0.0879, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (26.6, 3.40, 1.17, 0.447, 0.0682, None, 4.34),
    ("s1_teknic_m2310p", "saturated"): (25.0, 3.76, 0.692, 0.234, 0.0867, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (37.0, 4.20, 3.94, 0.460, 0.0898, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (47.0, 4.02, 0.344, 0.122, 0.0351, None, 1.10),
    ("s2_teknic_m2310p", "adc"): (48.2, 4.20, 0.308, 0.134, 0.0314, None, 1.09),
    ("s2_teknic_m2310p", "hot"): (49.5, 4.03, 0.321, 0.113, 0.0255, None, 1.10),
    ("s2_teknic_m2310p", "saturated"): (46.1, 3.94, 0.326, 0.122, 0.0253, None, 1.09),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (48.3, 4.89, 0.334, 0.140, 0.0334, None, 1.09),
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
