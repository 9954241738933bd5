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
    ("s1_robust", "ideal"): (27.9, 7.69, 0.964, 0.357, 0.0415, None, 8.41),
    ("s1_robust", "adc"): (29.5, 7.70, 1.29, 0.414, 0.0720, None, 8.37),
    ("s1_robust", "deadtime"): (51.7, 8.47, 2.09, 0.872, 0.0777, None, 8.41),
    ("s1_robust", "hot"): (28.5, 7.68, 0.957, 0.589, 0.0374, None, 8.49),
    ("s1_robust", "saturated"): (27.7, 7.76, 0.735, 0.297, 0.0369, None, 8.41),
    ("s1_robust", "imp"): (51.9, 8.50, 1.59, 1.16, 0.355, None, 8.38),
    ("s1_robust", "all"): (42.2, 8.85, 1.98, 1.44, 0.527, None, 8.45),
    ("s2_robust", "ideal"): (14.5, 1.61, 0.0765, 0.0246, 0.0318, None, 0.000841),
    ("s2_robust", "adc"): (15.9, 1.86, 0.109, 0.0541, 0.0608, None, 0.00677),
    ("s2_robust", "deadtime"): (17.0, 2.28, 0.386, 0.0771, 0.0713, None, 1.34),
    ("s2_robust", "hot"): (14.3, 1.56, 0.136, 0.0257, 0.0280, None, 0.00421),
    ("s2_robust", "saturated"): (14.4, 1.58, 0.0702, 0.0283, 0.0268, None, 0.000706),
    ("s2_robust", "imp"): (17.3, 2.24, 0.228, 0.0741, 0.0966, None, 1.34),
    ("s2_robust", "all"): (20.4, 3.57, 0.340, 0.143, 0.174, None, 1.27),
    ("s3_robust", "ideal"): (38.2, 7.65, 2.54, 1.22, None, 2.86e-05, 8.91),
    ("s3_robust", "adc"): (46.1, 7.66, 2.86, 1.25, None, 0.00315, 8.86),
    ("s3_robust", "deadtime"): (48.1, 8.26, 2.47, 1.16, None, 4.83e-05, 8.89),
    ("s3_robust", "hot"): (42.3, 8.28, 2.40, 1.05, None, 5.89e-05, 8.97),
    ("s3_robust", "saturated"): (32.1, 7.70, 2.53, 1.29, None, 2.51e-05, 8.90),
    ("s3_robust", "imp"): (45.5, 7.91, 2.94, 1.31, None, 0.000238, 8.84),
    ("s3_robust", "all"): (43.0, 8.39, 2.60, 1.02, None, 0.00547, 8.89),
    ("s4", "ideal"): (7.71, 0.726, 0.0741, 0.0261, 1.10, None, 0.00334),
    ("s4", "adc"): (7.72, 0.727, 0.0731, 0.0264, 1.09, None, 0.0110),
    ("s4", "encoder"): (8.22, 0.752, 0.111, 0.0396, 1.09, None, 0.00335),
    ("s4", "adc+encoder"): (8.16, 0.754, 0.110, 0.0384, 1.09, None, 0.0111),
    ("s4", "hot"): (7.77, 0.727, 0.0748, 0.0332, 0.950, None, 0.00216),
    ("s4", "deadtime"): (7.43, 0.571, 0.0718, 0.182, 0.753, None, 0.00208),
    ("s4", "imp"): (7.40, 0.571, 0.0709, 0.976, 0.678, None, 0.00260),
    ("s4", "all"): (7.46, 0.630, 0.0708, 1.07, 0.938, None, 0.00406),
    ("s4", "saturated"): (7.61, 0.661, 0.0709, 0.740, 0.969, None, 0.00176),
    ("s5", "ideal"): (4.98, 1.06, 0.174, 0.0132, 1.66, None, 0.00782),
    ("s5", "adc"): (7.95, 1.93, 0.212, 0.0497, 1.71, None, 0.0128),
    ("s5", "hot"): (4.72, 0.938, 0.168, 0.0136, 1.55, None, 0.00729),
    ("s5", "saturated"): (4.81, 0.866, 0.121, 0.0119, 1.65, None, 0.00360),
    ("steady", "ideal"): (1.39, 0.320, 0.0468, 0.0192, 0.137, None, 0.000288),
    ("steady", "deadtime"): (30.4, 4.92, 1.30, 0.490, 3.93, None, 0.616),
    ("steady", "imp"): (35.4, 5.03, 1.26, 0.443, 2.92, None, 0.613),
    ("steady", "all"): (23.7, 4.55, 0.983, 0.383, 2.44, None, 0.523),
    ("campaign", "ideal"): (18.5, 1.91, 0.0767, 0.0426, 0.0308, None, 0.000149),
    ("campaign", "adc"): (18.1, 2.15, 0.162, 0.0685, 0.0640, None, 0.0134),
    ("campaign", "deadtime"): (20.0, 2.29, 0.195, 0.0518, 0.0836, None, 1.34),
    ("campaign", "hot"): (18.6, 1.87, 0.190, 0.0477, 0.0245, None, 0.00724),
    ("campaign", "saturated"): (18.6, 1.91, 0.0701, 0.0504, 0.0233, None, 0.000634),
    ("campaign", "imp"): (22.5, 2.63, 0.290, 0.104, 0.113, None, 1.34),
    ("campaign", "all"): (24.8, 3.99, 0.425, 0.135, 0.182, None, 1.27),
    ("any", "ideal"): (33.2, 5.96, 0.950, 0.185, 0.0559, None, 0.000448),
    ("any", "deadtime"): (33.7, 6.12, 0.961, 0.188, 0.0876, None, 3.49),
    ("any", "imp"): (33.4, 6.14, 1.87, 0.271, 0.151, None, 3.38),
    ("any", "all"): (38.7, 6.28, 3.13, 0.440, 0.140, None, 3.41),
    ("s1_motor_b", "ideal"): (4.64, 2.34, 1.79, 0.452, 0.00215, None, 3.55),
    ("s1_motor_b", "adc"): (7.20, 2.52, 2.08, 0.469, 0.00178, None, 3.53),
    ("s1_motor_b", "hot"): (20.2, 2.53, 2.02, 0.695, 0.00183, None, 3.60),
    ("s1_motor_b", "saturated"): (4.26, 2.31, 1.32, 0.378, 0.00168, None, 3.55),
    ("s1_motor_b", "adc+hot+saturated"): (18.6, 2.73, 1.77, 0.905, 0.00304, None, 3.58),
    ("s1_motor_b", "deadtime"): (15.8, 2.57, 1.79, 0.454, 0.00129, None, 3.55),
    ("s1_motor_b", "imp"): (32.0, 3.08, 3.24, 0.992, 0.00386, None, 3.50),
    ("s1_motor_b", "all"): (18.6, 2.79, 2.43, 0.906, 5.64e-05, None, 3.58),
    ("s2_motor_b", "ideal"): (4.88, 1.57, 0.123, 0.0116, 0.607, None, 0.000850),
    ("s2_motor_b", "adc"): (7.62, 2.01, 0.192, 0.0371, 0.606, None, 0.00414),
    ("s2_motor_b", "hot"): (4.63, 1.48, 0.116, 0.00977, 0.655, None, 0.000999),
    ("s2_motor_b", "saturated"): (4.47, 1.46, 0.0972, 0.0109, 0.601, None, 0.000676),
    ("s2_motor_b", "adc+hot+saturated"): (6.52, 1.73, 0.159, 0.0350, 0.658, None, 0.00471),
    ("s2_motor_b", "deadtime"): (16.0, 3.16, 0.435, 0.0497, 0.595, None, 0.521),
    ("s2_motor_b", "imp"): (30.5, 8.59, 1.37, 0.0900, 0.751, None, 0.357),
    ("s2_motor_b", "all"): (21.9, 5.08, 0.963, 0.0784, 0.729, None, 0.458),
    ("s1_odrive_d5065", "ideal"): (104., 18.6, 4.38, 6.72, 0.0626, None, 19.4),
    ("s1_odrive_d5065", "adc"): (96.3, 17.9, 4.11, 6.58, 0.0599, None, 19.3),
    ("s1_odrive_d5065", "hot"): (89.8, 13.2, 4.32, 6.54, 0.0337, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (102., 13.3, 4.43, 9.89, 0.0226, None, 19.4),
    ("s1_odrive_d5065", "adc+hot+saturated"): (85.6, 11.7, 4.26, 8.90, 0.0197, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (73.7, 24.2, 3.31, 2.78, 0.157, None, 2.35),
    ("s2_odrive_d5065", "adc"): (73.1, 23.7, 3.30, 2.79, 0.171, None, 2.26),
    ("s2_odrive_d5065", "hot"): (49.0, 10.7, 2.67, 2.36, 0.131, None, 2.94),
    ("s2_odrive_d5065", "saturated"): (54.7, 8.39, 2.84, 3.42, 0.131, None, 3.15),
    ("s2_odrive_d5065", "adc+hot+saturated"): (50.1, 6.38, 2.75, 3.44, 0.132, None, 3.21),
    ("s1_teknic_m2310p", "ideal"): (73.2, 12.5, 0.669, 0.192, 0.0728, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (66.9, 12.4, 2.32, 0.315, 0.0948, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (70.2, 12.4, 1.62, 0.389, 0.0641, None, 4.34),
    ("s1_teknic_m2310p", "saturated"): (71.2, 12.7, 0.557, 0.189, 0.0864, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (61.3, 12.3, 4.13, 0.444, 0.0940, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (49.6, 3.99, 0.329, 0.104, 0.0367, None, 1.09),
    ("s2_teknic_m2310p", "adc"): (47.2, 4.19, 0.283, 0.106, 0.0359, None, 1.08),
    ("s2_teknic_m2310p", "hot"): (46.6, 3.89, 0.267, 0.0813, 0.0246, None, 1.09),
    ("s2_teknic_m2310p", "saturated"): (51.4, 4.08, 0.344, 0.138, 0.0292, None, 1.09),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (49.0, 4.60, 0.446, 0.127, 0.0389, None, 1.08),
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
