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
    ("s1_robust", "deadtime"): (58.6, 8.66, 2.51, 0.879, 0.0706, None, 8.41),
    ("s1_robust", "hot"): (28.5, 7.68, 0.957, 0.589, 0.0374, None, 8.49),
    ("s1_robust", "saturated"): (27.7, 7.76, 0.735, 0.297, 0.0369, None, 8.41),
    ("s1_robust", "imp"): (49.0, 8.49, 1.48, 1.11, 0.432, None, 8.38),
    ("s1_robust", "all"): (41.0, 8.78, 1.98, 1.40, 0.416, None, 8.45),
    ("s2_robust", "ideal"): (14.5, 1.61, 0.0765, 0.0246, 0.0318, None, 0.000841),
    ("s2_robust", "adc"): (15.9, 1.86, 0.109, 0.0541, 0.0608, None, 0.00677),
    ("s2_robust", "deadtime"): (16.8, 2.14, 0.232, 0.0632, 0.0720, None, 1.34),
    ("s2_robust", "hot"): (14.3, 1.56, 0.136, 0.0257, 0.0280, None, 0.00421),
    ("s2_robust", "saturated"): (14.4, 1.58, 0.0702, 0.0283, 0.0268, None, 0.000706),
    ("s2_robust", "imp"): (16.7, 2.25, 0.223, 0.0754, 0.102, None, 1.34),
    ("s2_robust", "all"): (20.6, 3.59, 0.345, 0.148, 0.181, None, 1.27),
    ("s3_robust", "ideal"): (38.2, 7.65, 2.73, 1.15, None, 8.42e-05, 8.93),
    ("s3_robust", "adc"): (46.1, 7.72, 2.85, 1.13, None, 0.00309, 8.88),
    ("s3_robust", "deadtime"): (34.7, 8.13, 2.87, 1.26, None, 0.000250, 8.94),
    ("s3_robust", "hot"): (42.9, 8.10, 2.94, 1.11, None, 0.000262, 8.94),
    ("s3_robust", "saturated"): (32.1, 7.68, 2.67, 1.23, None, 4.83e-05, 8.92),
    ("s3_robust", "imp"): (48.4, 8.19, 2.88, 1.22, None, 0.000208, 8.91),
    ("s3_robust", "all"): (46.5, 8.40, 2.92, 1.01, None, 0.00562, 8.88),
    ("s4", "ideal"): (7.63, 0.718, 0.0741, 0.0242, 0.989, None, 8.49e-05),
    ("s4", "adc"): (7.68, 0.723, 0.0729, 0.0243, 0.990, None, 0.00765),
    ("s4", "encoder"): (8.19, 0.754, 0.111, 0.0381, 1.00, None, 0.000110),
    ("s4", "adc+encoder"): (8.10, 0.747, 0.110, 0.0379, 0.992, None, 0.00763),
    ("s4", "hot"): (7.73, 0.712, 0.0743, 0.0199, 0.955, None, 0.000461),
    ("s4", "deadtime"): (7.45, 0.549, 0.0704, 0.0547, 1.09, None, 5.23e-05),
    ("s4", "imp"): (7.42, 0.535, 0.0703, 0.742, 1.01, None, 7.73e-05),
    ("s4", "all"): (7.45, 0.561, 0.0717, 0.675, 1.18, None, 0.00819),
    ("s4", "saturated"): (7.63, 0.706, 0.0726, 0.812, 0.444, None, 0.000635),
    ("s5", "ideal"): (4.77, 1.01, 0.162, 0.0127, 1.02, None, 0.00222),
    ("s5", "adc"): (7.58, 1.91, 0.215, 0.0482, 1.03, None, 0.00731),
    ("s5", "deadtime"): (6.19, 1.43, 0.260, 0.0199, 1.13, None, 0.00283),
    ("s5", "hot"): (4.82, 0.848, 0.155, 0.0109, 1.08, None, 0.00331),
    ("s5", "saturated"): (4.62, 0.808, 0.120, 0.0121, 0.478, None, 0.000886),
    ("s5", "imp"): (10.2, 2.02, 0.460, 0.0436, 1.06, None, 0.00774),
    ("s5", "all"): (10.2, 2.05, 0.413, 0.0527, 1.23, None, 0.0144),
    ("steady", "ideal"): (1.39, 0.320, 0.0468, 0.0192, 0.137, None, 0.000288),
    ("steady", "deadtime"): (23.3, 4.47, 0.877, 0.329, 2.23, None, 0.613),
    ("steady", "imp"): (38.6, 5.35, 1.40, 0.550, 3.64, None, 0.613),
    ("steady", "all"): (25.1, 4.57, 1.09, 0.388, 2.53, None, 0.524),
    ("campaign", "ideal"): (18.6, 1.91, 0.0746, 0.0491, 0.0289, None, 0.000282),
    ("campaign", "adc"): (18.7, 2.18, 0.128, 0.0676, 0.0710, None, 0.0106),
    ("campaign", "deadtime"): (20.1, 2.28, 0.182, 0.0608, 0.0856, None, 1.34),
    ("campaign", "hot"): (18.4, 1.88, 0.168, 0.0499, 0.0249, None, 0.00619),
    ("campaign", "saturated"): (18.7, 1.91, 0.0683, 0.0517, 0.0241, None, 0.000341),
    ("campaign", "imp"): (19.6, 2.48, 0.227, 0.0856, 0.116, None, 1.34),
    ("campaign", "all"): (24.4, 3.51, 0.376, 0.132, 0.158, None, 1.28),
    ("any", "ideal"): (33.2, 5.96, 0.950, 0.185, 0.0559, None, 0.000448),
    ("any", "deadtime"): (33.3, 6.12, 0.963, 0.188, 0.0619, None, 3.49),
    ("any", "imp"): (34.7, 6.22, 1.94, 0.287, 0.148, None, 3.38),
    ("any", "all"): (38.9, 6.29, 3.09, 0.429, 0.147, None, 3.41),
    ("s1_motor_b", "ideal"): (4.64, 2.34, 1.79, 0.452, 0.00215, None, 3.55),
    ("s1_motor_b", "adc"): (7.20, 2.52, 2.08, 0.469, 0.00178, None, 3.53),
    ("s1_motor_b", "hot"): (20.2, 2.53, 2.02, 0.695, 0.00183, None, 3.60),
    ("s1_motor_b", "saturated"): (4.26, 2.31, 1.32, 0.378, 0.00168, None, 3.55),
    ("s1_motor_b", "adc+hot+saturated"): (18.6, 2.73, 1.77, 0.905, 0.00304, None, 3.58),
    ("s1_motor_b", "deadtime"): (15.6, 2.63, 1.80, 0.457, 0.00133, None, 3.55),
    ("s1_motor_b", "imp"): (24.3, 2.92, 2.99, 0.845, 0.00377, None, 3.50),
    ("s1_motor_b", "all"): (16.9, 2.75, 2.43, 0.818, 5.51e-05, None, 3.58),
    ("s2_motor_b", "ideal"): (4.88, 1.57, 0.123, 0.0116, 0.607, None, 0.000850),
    ("s2_motor_b", "adc"): (7.62, 2.01, 0.192, 0.0371, 0.606, None, 0.00414),
    ("s2_motor_b", "hot"): (4.63, 1.48, 0.116, 0.00977, 0.655, None, 0.000999),
    ("s2_motor_b", "saturated"): (4.47, 1.46, 0.0972, 0.0109, 0.601, None, 0.000676),
    ("s2_motor_b", "adc+hot+saturated"): (6.52, 1.73, 0.159, 0.0350, 0.658, None, 0.00471),
    ("s2_motor_b", "deadtime"): (15.0, 2.70, 0.504, 0.0409, 0.584, None, 0.540),
    ("s2_motor_b", "imp"): (22.3, 4.98, 0.875, 0.0797, 0.617, None, 0.456),
    ("s2_motor_b", "all"): (23.2, 5.18, 0.947, 0.0941, 0.710, None, 0.424),
    ("s1_odrive_d5065", "ideal"): (110., 18.8, 4.97, 7.01, 0.0604, None, 19.4),
    ("s1_odrive_d5065", "adc"): (108., 18.6, 4.61, 7.02, 0.0639, None, 19.3),
    ("s1_odrive_d5065", "hot"): (98.1, 13.4, 4.51, 6.18, 0.0300, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (98.9, 12.8, 4.66, 10.3, 0.0261, None, 19.4),
    ("s1_odrive_d5065", "adc+hot+saturated"): (89.5, 11.8, 4.16, 8.54, 0.0174, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (68.6, 22.9, 3.23, 2.80, 0.153, None, 2.28),
    ("s2_odrive_d5065", "adc"): (71.7, 23.2, 3.30, 2.81, 0.160, None, 2.33),
    ("s2_odrive_d5065", "hot"): (56.0, 11.7, 2.72, 2.69, 0.128, None, 2.98),
    ("s2_odrive_d5065", "saturated"): (57.7, 10.7, 3.02, 4.58, 0.145, None, 3.15),
    ("s2_odrive_d5065", "adc+hot+saturated"): (43.3, 5.87, 2.52, 3.39, 0.131, None, 3.23),
    ("s1_teknic_m2310p", "ideal"): (73.6, 12.5, 0.669, 0.218, 0.0690, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (66.8, 12.4, 2.32, 0.320, 0.0974, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (70.5, 12.4, 1.62, 0.387, 0.0662, None, 4.34),
    ("s1_teknic_m2310p", "saturated"): (72.5, 12.7, 0.556, 0.168, 0.0949, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (61.4, 12.3, 4.14, 0.443, 0.0977, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (49.5, 3.99, 0.330, 0.0985, 0.0350, None, 1.09),
    ("s2_teknic_m2310p", "adc"): (46.5, 4.20, 0.273, 0.107, 0.0366, None, 1.08),
    ("s2_teknic_m2310p", "hot"): (49.5, 3.92, 0.346, 0.0782, 0.0266, None, 1.09),
    ("s2_teknic_m2310p", "saturated"): (46.5, 4.05, 0.344, 0.123, 0.0205, None, 1.09),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (48.9, 4.61, 0.449, 0.133, 0.0360, None, 1.08),
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
