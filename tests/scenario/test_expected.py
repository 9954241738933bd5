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
    ("s1", "adc"): (9.13, 2.19, 0.352, 0.0836, 0.156, None, 0.00110),
    ("s2", "ideal"): (6.94, 0.744, 0.105, 0.0475, 0.0449, None, 0.000129),
    ("s2", "adc"): (10.7, 2.46, 0.120, 0.0630, 0.131, None, 0.00850),
    ("s3", "ideal"): (3.33, 0.702, 0.587, 0.0347, None, 0.00437, 0.000261),
    ("s3", "adc"): (9.00, 2.19, 0.626, 0.0655, None, 0.00467, 0.00118),
    ("s1_robust", "ideal"): (10.4, 1.67, 0.963, 0.356, 0.0359, None, 8.40),
    ("s1_robust", "adc"): (18.6, 2.33, 1.29, 0.407, 0.0899, None, 8.36),
    ("s1_robust", "deadtime"): (34.0, 2.63, 0.966, 0.357, 0.203, None, 8.40),
    ("s1_robust", "hot"): (14.1, 1.97, 0.985, 0.618, 0.0530, None, 8.41),
    ("s1_robust", "saturated"): (10.5, 1.58, 0.803, 0.311, 0.0371, None, 8.40),
    ("s1_robust", "imp"): (33.8, 3.49, 1.67, 0.985, 0.130, None, 8.40),
    ("s1_robust", "all"): (21.4, 3.36, 1.82, 0.655, 0.274, None, 8.36),
    ("s2_robust", "ideal"): (8.91, 0.863, 0.0517, 0.0200, 0.0277, None, 0.000177),
    ("s2_robust", "adc"): (11.1, 1.62, 0.111, 0.0534, 0.0815, None, 0.00722),
    ("s2_robust", "deadtime"): (13.1, 1.42, 0.112, 0.0578, 0.0609, None, 2.02),
    ("s2_robust", "hot"): (9.37, 0.867, 0.0581, 0.0212, 0.0307, None, 0.000385),
    ("s2_robust", "saturated"): (9.04, 0.835, 0.0578, 0.0255, 0.0270, None, 0.000423),
    ("s2_robust", "imp"): (11.6, 2.04, 0.183, 0.0689, 0.115, None, 2.03),
    ("s2_robust", "all"): (13.5, 2.96, 0.242, 0.142, 0.136, None, 2.01),
    ("s3_robust", "ideal"): (25.0, 4.42, 3.39, 1.36, None, 4.47e-05, 8.82),
    ("s3_robust", "adc"): (25.0, 4.67, 3.87, 1.56, None, 0.00308, 8.80),
    ("s3_robust", "deadtime"): (28.5, 4.53, 3.19, 1.26, None, 4.47e-05, 8.82),
    ("s3_robust", "hot"): (26.9, 4.96, 3.86, 1.38, None, 0.000289, 8.86),
    ("s3_robust", "saturated"): (24.8, 4.31, 3.89, 1.67, None, 2.62e-05, 8.82),
    ("s3_robust", "imp"): (29.5, 4.75, 3.69, 1.45, None, 0.000236, 8.82),
    ("s3_robust", "all"): (26.9, 5.04, 3.49, 1.33, None, 0.00543, 8.80),
    ("s4", "ideal"): (7.70, 0.725, 0.0737, 0.0249, 0.992, None, 9.68e-05),
    ("s4", "adc"): (7.67, 0.721, 0.0735, 0.0242, 0.988, None, 0.00764),
    ("s4", "encoder"): (8.45, 0.748, 0.144, 0.0422, 0.991, None, 0.000116),
    ("s4", "adc+encoder"): (8.16, 0.750, 0.123, 0.0405, 0.990, None, 0.00765),
    ("s4", "hot"): (7.74, 0.712, 0.0743, 0.0186, 0.954, None, 0.000466),
    ("s4", "deadtime"): (7.45, 0.549, 0.0726, 0.0547, 1.09, None, 6.86e-05),
    ("s4", "imp"): (7.43, 0.535, 0.0699, 0.743, 1.01, None, 7.18e-05),
    ("s4", "all"): (7.45, 0.560, 0.0721, 0.667, 1.17, None, 0.00826),
    ("s4", "saturated"): (7.56, 0.701, 0.0720, 0.812, 0.446, None, 0.000640),
    ("s5", "ideal"): (5.18, 1.10, 0.116, 0.0147, 1.01, None, 0.00153),
    ("s5", "adc"): (8.03, 1.95, 0.384, 0.0445, 1.01, None, 0.0113),
    ("s5", "deadtime"): (6.45, 1.50, 0.260, 0.0215, 1.14, None, 0.00240),
    ("s5", "hot"): (5.11, 0.826, 0.103, 0.0115, 1.08, None, 0.00161),
    ("s5", "saturated"): (4.89, 0.875, 0.0821, 0.0152, 0.475, None, 0.000768),
    ("s5", "imp"): (9.72, 2.02, 0.372, 0.0418, 1.04, None, 0.00428),
    ("s5", "all"): (9.47, 2.02, 0.381, 0.0503, 1.22, None, 0.0114),
    ("steady", "ideal"): (1.13, 0.274, 0.0340, 0.0195, 0.150, None, 0.000193),
    ("steady", "deadtime"): (15.2, 2.15, 0.478, 0.153, 1.33, None, 1.67),
    ("steady", "imp"): (14.8, 2.60, 0.598, 0.147, 1.33, None, 1.68),
    ("steady", "all"): (14.2, 2.49, 0.457, 0.152, 1.40, None, 1.62),
    ("campaign", "ideal"): (11.2, 1.01, 0.0712, 0.0248, 0.0332, None, 0.00143),
    ("campaign", "adc"): (12.5, 1.98, 0.195, 0.0573, 0.0955, None, 0.0147),
    ("campaign", "deadtime"): (14.2, 1.66, 0.105, 0.0730, 0.0806, None, 2.02),
    ("campaign", "hot"): (11.9, 1.04, 0.0762, 0.0235, 0.0284, None, 0.000167),
    ("campaign", "saturated"): (11.4, 1.00, 0.0741, 0.0271, 0.0279, None, 0.000165),
    ("campaign", "imp"): (15.5, 2.19, 0.275, 0.0818, 0.142, None, 2.03),
    ("campaign", "all"): (17.6, 3.13, 0.234, 0.131, 0.133, None, 2.01),
    ("any", "ideal"): (20.1, 1.92, 0.960, 0.187, 0.0503, None, 0.000213),
    ("any", "deadtime"): (21.8, 2.04, 0.953, 0.186, 0.0691, None, 3.53),
    ("any", "imp"): (26.2, 2.24, 2.50, 0.248, 0.135, None, 3.42),
    ("any", "all"): (25.2, 2.52, 2.87, 0.452, 0.131, None, 3.50),
    ("s_torque", "ideal"): (7.55, 1.40, 3.09, 1.17, None, None, 0.00138),
    ("s_torque", "deadtime"): (73.6, 4.91, 2.54, 0.848, None, None, 2.10),
    ("s_torque", "imp"): (47.4, 3.55, 3.53, 1.04, None, None, 2.10),
    ("s_torque", "all"): (60.1, 4.83, 4.28, 1.07, None, None, 2.10),
    ("s1_motor_b", "ideal"): (4.03, 0.895, 1.81, 0.205, 0.000933, None, 3.54),
    ("s1_motor_b", "adc"): (3.97, 0.975, 2.11, 0.239, 0.00244, None, 3.52),
    ("s1_motor_b", "hot"): (5.39, 1.66, 7.32, 0.752, 0.00166, None, 3.53),
    ("s1_motor_b", "saturated"): (3.42, 0.753, 1.53, 0.169, 0.000322, None, 3.54),
    ("s1_motor_b", "adc+hot+saturated"): (5.70, 1.62, 6.91, 0.702, 0.00408, None, 3.52),
    ("s1_motor_b", "deadtime"): (4.08, 0.907, 1.83, 0.208, 0.000939, None, 3.53),
    ("s1_motor_b", "imp"): (3.98, 1.04, 4.09, 0.349, 0.00549, None, 3.54),
    ("s1_motor_b", "all"): (5.24, 1.50, 6.48, 0.697, 0.00, None, 3.52),
    ("s2_motor_b", "ideal"): (8.61, 1.91, 0.219, 0.0161, 0.512, None, 0.000568),
    ("s2_motor_b", "adc"): (8.72, 1.95, 0.249, 0.0260, 0.509, None, 0.00341),
    ("s2_motor_b", "hot"): (8.87, 2.07, 0.246, 0.0169, 0.547, None, 0.000560),
    ("s2_motor_b", "saturated"): (8.57, 1.91, 0.214, 0.0184, 0.511, None, 0.000258),
    ("s2_motor_b", "adc+hot+saturated"): (8.99, 2.10, 0.271, 0.0270, 0.544, None, 0.00362),
    ("s2_motor_b", "deadtime"): (8.94, 1.98, 0.260, 0.0259, 0.522, None, 1.77),
    ("s2_motor_b", "imp"): (9.09, 1.92, 0.277, 0.0764, 0.494, None, 1.76),
    ("s2_motor_b", "all"): (9.44, 2.15, 0.351, 0.0389, 0.559, None, 1.75),
    ("s1_odrive_d5065", "ideal"): (7.38, 1.27, 1.41, 1.96, 0.0137, None, 19.5),
    ("s1_odrive_d5065", "adc"): (7.50, 1.32, 1.98, 2.00, 0.0134, None, 19.3),
    ("s1_odrive_d5065", "hot"): (10.7, 1.32, 3.95, 2.80, 0.00871, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (7.78, 1.31, 1.62, 2.70, 0.0130, None, 19.5),
    ("s1_odrive_d5065", "adc+hot+saturated"): (6.83, 1.40, 5.79, 2.78, 0.00838, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (21.5, 3.38, 1.60, 1.95, 0.125, None, 7.33),
    ("s2_odrive_d5065", "adc"): (21.5, 3.33, 1.68, 3.70, 0.122, None, 7.63),
    ("s2_odrive_d5065", "hot"): (22.0, 3.35, 0.569, 1.45, 0.121, None, 8.45),
    ("s2_odrive_d5065", "saturated"): (22.3, 3.39, 1.59, 2.66, 0.128, None, 8.25),
    ("s2_odrive_d5065", "adc+hot+saturated"): (21.9, 3.39, 1.21, 1.72, 0.122, None, 8.44),
    ("s1_teknic_m2310p", "ideal"): (23.5, 2.69, 0.841, 0.167, 0.0529, None, 4.34),
    ("s1_teknic_m2310p", "adc"): (24.5, 2.86, 1.98, 0.268, 0.0669, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (28.3, 2.67, 3.19, 0.475, 0.0505, None, 4.33),
    ("s1_teknic_m2310p", "saturated"): (22.3, 2.80, 1.08, 0.163, 0.0631, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (30.7, 3.04, 5.07, 0.520, 0.0630, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (51.0, 3.86, 0.338, 0.0641, 0.0295, None, 1.49),
    ("s2_teknic_m2310p", "adc"): (51.7, 4.12, 0.294, 0.0967, 0.0253, None, 1.49),
    ("s2_teknic_m2310p", "hot"): (53.0, 4.08, 0.377, 0.0660, 0.0198, None, 1.49),
    ("s2_teknic_m2310p", "saturated"): (51.8, 3.89, 0.353, 0.0927, 0.0219, None, 1.49),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (53.5, 4.27, 0.449, 0.103, 0.0262, None, 1.48),
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
