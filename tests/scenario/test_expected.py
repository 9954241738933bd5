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
    ("s1_robust", "ideal"): (10.1, 1.67, 0.963, 0.356, 0.0528, None, 8.40),
    ("s1_robust", "adc"): (18.4, 2.32, 1.29, 0.407, 0.0815, None, 8.36),
    ("s1_robust", "deadtime"): (35.5, 2.92, 1.11, 0.410, 0.142, None, 8.40),
    ("s1_robust", "hot"): (13.9, 1.98, 0.985, 0.613, 0.0372, None, 8.41),
    ("s1_robust", "saturated"): (10.3, 1.58, 0.803, 0.311, 0.0325, None, 8.40),
    ("s1_robust", "imp"): (34.2, 3.45, 1.70, 0.994, 0.147, None, 8.40),
    ("s1_robust", "all"): (24.6, 3.47, 1.82, 0.689, 0.285, None, 8.36),
    ("s2_robust", "ideal"): (8.85, 0.861, 0.0530, 0.0194, 0.0328, None, 0.000306),
    ("s2_robust", "adc"): (11.3, 1.61, 0.107, 0.0502, 0.0800, None, 0.00735),
    ("s2_robust", "deadtime"): (11.5, 1.54, 0.142, 0.0807, 0.0660, None, 2.02),
    ("s2_robust", "hot"): (9.10, 0.867, 0.0662, 0.0218, 0.0284, None, 0.000484),
    ("s2_robust", "saturated"): (9.19, 0.840, 0.0552, 0.0273, 0.0262, None, 0.000318),
    ("s2_robust", "imp"): (11.5, 1.98, 0.176, 0.0671, 0.129, None, 2.03),
    ("s2_robust", "all"): (13.6, 2.91, 0.193, 0.127, 0.142, None, 2.01),
    ("s3_robust", "ideal"): (25.0, 4.40, 3.44, 1.39, None, 4.90e-05, 8.83),
    ("s3_robust", "adc"): (25.0, 4.57, 3.78, 1.53, None, 0.00307, 8.80),
    ("s3_robust", "deadtime"): (27.7, 4.61, 3.29, 1.30, None, 0.000286, 8.82),
    ("s3_robust", "hot"): (25.2, 4.82, 3.44, 1.26, None, 0.000288, 8.85),
    ("s3_robust", "saturated"): (22.6, 4.17, 3.43, 1.49, None, 2.57e-05, 8.84),
    ("s3_robust", "imp"): (29.4, 4.79, 3.84, 1.50, None, 0.000250, 8.82),
    ("s3_robust", "all"): (26.9, 4.88, 3.48, 1.31, None, 0.00543, 8.80),
    ("s4", "ideal"): (7.70, 0.725, 0.0737, 0.0249, 0.992, None, 9.68e-05),
    ("s4", "adc"): (7.67, 0.721, 0.0735, 0.0242, 0.988, None, 0.00764),
    ("s4", "encoder"): (8.45, 0.748, 0.144, 0.0422, 0.991, None, 0.000116),
    ("s4", "adc+encoder"): (8.16, 0.750, 0.123, 0.0405, 0.990, None, 0.00765),
    ("s4", "hot"): (7.74, 0.712, 0.0743, 0.0186, 0.954, None, 0.000466),
    ("s4", "deadtime"): (7.45, 0.548, 0.0717, 0.0473, 1.09, None, 3.67e-05),
    ("s4", "imp"): (7.43, 0.535, 0.0708, 0.743, 1.01, None, 8.14e-05),
    ("s4", "all"): (7.46, 0.560, 0.0707, 0.671, 1.17, None, 0.00826),
    ("s4", "saturated"): (7.56, 0.701, 0.0720, 0.812, 0.446, None, 0.000640),
    ("s5", "ideal"): (5.25, 1.09, 0.116, 0.0147, 1.01, None, 0.00149),
    ("s5", "adc"): (7.76, 1.95, 0.387, 0.0436, 1.01, None, 0.0113),
    ("s5", "deadtime"): (5.18, 1.61, 0.292, 0.0224, 1.13, None, 0.00249),
    ("s5", "hot"): (4.98, 0.827, 0.110, 0.0107, 1.09, None, 0.00160),
    ("s5", "saturated"): (4.45, 0.855, 0.0764, 0.0145, 0.482, None, 0.000770),
    ("s5", "imp"): (10.2, 2.18, 0.382, 0.0417, 1.04, None, 0.00427),
    ("s5", "all"): (8.32, 2.06, 0.388, 0.0547, 1.22, None, 0.0113),
    ("steady", "ideal"): (1.49, 0.277, 0.0407, 0.0180, 0.114, None, 0.000175),
    ("steady", "deadtime"): (13.1, 1.84, 0.433, 0.119, 1.24, None, 1.66),
    ("steady", "imp"): (15.8, 2.61, 0.624, 0.160, 1.39, None, 1.68),
    ("steady", "all"): (13.9, 2.50, 0.466, 0.164, 1.41, None, 1.62),
    ("campaign", "ideal"): (11.8, 1.04, 0.0774, 0.0239, 0.0280, None, 0.000795),
    ("campaign", "adc"): (12.7, 1.96, 0.174, 0.0546, 0.0924, None, 0.0120),
    ("campaign", "deadtime"): (13.0, 1.55, 0.114, 0.0592, 0.0996, None, 2.02),
    ("campaign", "hot"): (11.9, 1.03, 0.0783, 0.0248, 0.0264, None, 0.00123),
    ("campaign", "saturated"): (11.2, 0.997, 0.0684, 0.0254, 0.0275, None, 0.000148),
    ("campaign", "imp"): (17.4, 2.22, 0.289, 0.0808, 0.138, None, 2.03),
    ("campaign", "all"): (16.3, 3.14, 0.232, 0.131, 0.122, None, 2.01),
    ("any", "ideal"): (20.3, 1.92, 0.960, 0.187, 0.0635, None, 0.000262),
    ("any", "deadtime"): (22.6, 2.06, 0.953, 0.186, 0.0697, None, 3.53),
    ("any", "imp"): (22.2, 2.10, 2.16, 0.248, 0.134, None, 3.42),
    ("any", "all"): (23.8, 2.52, 2.92, 0.452, 0.127, None, 3.50),
    ("s_torque", "ideal"): (7.34, 1.39, 3.12, 1.18, None, None, 0.00140),
    ("s_torque", "deadtime"): (94.3, 4.79, 3.83, 1.10, None, None, 2.10),
    ("s_torque", "imp"): (59.7, 3.86, 3.56, 1.06, None, None, 2.10),
    ("s_torque", "all"): (65.3, 5.04, 4.88, 1.13, None, None, 2.10),
    ("s1_motor_b", "ideal"): (4.03, 0.891, 1.81, 0.205, 0.000933, None, 3.54),
    ("s1_motor_b", "adc"): (3.97, 0.974, 2.11, 0.239, 0.00244, None, 3.52),
    ("s1_motor_b", "hot"): (5.49, 1.66, 7.31, 0.750, 0.00166, None, 3.53),
    ("s1_motor_b", "saturated"): (3.42, 0.752, 1.53, 0.169, 0.000322, None, 3.54),
    ("s1_motor_b", "adc+hot+saturated"): (5.74, 1.62, 6.91, 0.700, 0.00408, None, 3.52),
    ("s1_motor_b", "deadtime"): (4.08, 0.893, 1.83, 0.208, 0.000939, None, 3.53),
    ("s1_motor_b", "imp"): (3.98, 1.04, 4.14, 0.349, 0.00549, None, 3.54),
    ("s1_motor_b", "all"): (5.29, 1.50, 6.48, 0.697, 0.00, None, 3.52),
    ("s2_motor_b", "ideal"): (8.59, 1.91, 0.218, 0.0159, 0.512, None, 0.0558),
    ("s2_motor_b", "adc"): (8.74, 1.95, 0.248, 0.0255, 0.509, None, 0.0523),
    ("s2_motor_b", "hot"): (8.87, 2.07, 0.249, 0.0170, 0.544, None, 0.0654),
    ("s2_motor_b", "saturated"): (8.59, 1.91, 0.217, 0.0186, 0.513, None, 0.0446),
    ("s2_motor_b", "adc+hot+saturated"): (8.99, 2.10, 0.270, 0.0272, 0.543, None, 0.0484),
    ("s2_motor_b", "deadtime"): (9.06, 1.99, 0.265, 0.0253, 0.522, None, 1.77),
    ("s2_motor_b", "imp"): (9.09, 1.93, 0.273, 0.0784, 0.494, None, 1.76),
    ("s2_motor_b", "all"): (9.43, 2.15, 0.343, 0.0395, 0.558, None, 1.75),
    ("s1_odrive_d5065", "ideal"): (7.50, 1.26, 1.41, 1.95, 0.0129, None, 19.5),
    ("s1_odrive_d5065", "adc"): (7.48, 1.31, 1.98, 1.99, 0.0135, None, 19.3),
    ("s1_odrive_d5065", "hot"): (10.6, 1.33, 3.95, 2.79, 0.00870, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (7.67, 1.29, 1.62, 2.66, 0.0140, None, 19.5),
    ("s1_odrive_d5065", "adc+hot+saturated"): (6.83, 1.39, 5.79, 2.78, 0.00818, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (21.7, 3.27, 0.553, 1.41, 0.121, None, 8.44),
    ("s2_odrive_d5065", "adc"): (22.0, 3.27, 0.570, 1.43, 0.120, None, 8.43),
    ("s2_odrive_d5065", "hot"): (21.8, 3.35, 0.569, 1.47, 0.120, None, 8.45),
    ("s2_odrive_d5065", "saturated"): (22.5, 3.33, 1.11, 1.79, 0.121, None, 8.43),
    ("s2_odrive_d5065", "adc+hot+saturated"): (22.1, 3.39, 1.20, 1.72, 0.122, None, 8.44),
    ("s1_teknic_m2310p", "ideal"): (23.2, 2.70, 0.841, 0.158, 0.0590, None, 4.34),
    ("s1_teknic_m2310p", "adc"): (25.0, 2.87, 1.98, 0.268, 0.0654, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (28.3, 2.68, 3.19, 0.477, 0.0503, None, 4.33),
    ("s1_teknic_m2310p", "saturated"): (22.4, 2.81, 1.08, 0.162, 0.0592, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (30.5, 3.05, 5.07, 0.520, 0.0658, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (50.7, 3.88, 0.325, 0.0708, 0.0344, None, 1.49),
    ("s2_teknic_m2310p", "adc"): (51.9, 4.10, 0.298, 0.0937, 0.0269, None, 1.49),
    ("s2_teknic_m2310p", "hot"): (53.3, 4.05, 0.381, 0.0640, 0.0212, None, 1.49),
    ("s2_teknic_m2310p", "saturated"): (52.3, 3.89, 0.366, 0.0866, 0.0212, None, 1.49),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (53.6, 4.25, 0.447, 0.105, 0.0271, None, 1.48),
    ("s_weakening", "ideal"): (18.4, 2.51, 3.77, 1.83, 0.0310, None, 8.32),
    ("s_weakening", "deadtime"): (77.0, 6.06, 3.19, 1.34, 0.698, None, 8.42),
    ("s_weakening", "imp"): (45.6, 4.68, 3.63, 1.70, 0.582, None, 8.45),
    ("s_weakening", "all"): (39.0, 7.73, 1.74, 0.695, 0.506, None, 11.1),
    ("s_weakening_motor_b", "ideal"): (10.9, 1.20, 5.41, 0.879, 0.0446, None, 2.05),
    ("s_weakening_motor_b", "deadtime"): (16.7, 1.59, 5.22, 0.853, 0.0439, None, 2.04),
    ("s_weakening_motor_b", "imp"): (12.9, 1.49, 5.17, 0.888, 0.0481, None, 2.08),
    ("s_weakening_motor_b", "all"): (12.9, 1.55, 5.68, 0.879, 0.0483, None, 2.32),
    ("s_weakening_compressor", "ideal"): (31.1, 4.18, 5.73, 0.979, 0.0190, None, 2.63),
    ("s_weakening_compressor", "deadtime"): (37.3, 4.75, 5.67, 0.953, 0.0276, None, 2.63),
    ("s_weakening_compressor", "imp"): (37.2, 4.71, 5.76, 0.896, 0.0341, None, 2.64),
    ("s_weakening_compressor", "all"): (34.8, 4.49, 6.69, 1.07, 0.0260, None, 3.07),
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
