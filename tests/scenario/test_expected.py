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
    ("s1_robust", "ideal"): (10.3, 1.73, 0.964, 0.357, 0.0465, None, 8.41),
    ("s1_robust", "adc"): (19.2, 2.22, 1.29, 0.407, 0.0804, None, 8.37),
    ("s1_robust", "deadtime"): (15.9, 2.12, 0.975, 0.359, 0.0688, None, 8.41),
    ("s1_robust", "hot"): (10.5, 1.90, 0.957, 0.583, 0.0425, None, 8.49),
    ("s1_robust", "saturated"): (10.2, 1.73, 0.735, 0.297, 0.0440, None, 8.41),
    ("s1_robust", "imp"): (28.6, 3.42, 1.49, 0.947, 0.378, None, 8.38),
    ("s1_robust", "all"): (22.9, 4.02, 1.90, 0.663, 0.374, None, 8.45),
    ("s2_robust", "ideal"): (14.3, 1.60, 0.0801, 0.0226, 0.0266, None, 0.000700),
    ("s2_robust", "adc"): (16.3, 1.87, 0.108, 0.0534, 0.0586, None, 0.00685),
    ("s2_robust", "deadtime"): (17.5, 1.96, 0.170, 0.0524, 0.0768, None, 1.35),
    ("s2_robust", "hot"): (14.4, 1.56, 0.138, 0.0256, 0.0274, None, 0.00409),
    ("s2_robust", "saturated"): (14.2, 1.58, 0.0764, 0.0275, 0.0257, None, 0.000464),
    ("s2_robust", "imp"): (16.6, 2.24, 0.263, 0.0748, 0.0987, None, 1.37),
    ("s2_robust", "all"): (16.5, 3.04, 0.287, 0.118, 0.162, None, 1.37),
    ("s3_robust", "ideal"): (27.3, 4.66, 3.68, 1.47, None, 4.16e-05, 8.83),
    ("s3_robust", "adc"): (34.1, 4.58, 3.56, 1.42, None, 0.00314, 8.80),
    ("s3_robust", "deadtime"): (25.0, 4.65, 3.29, 1.34, None, 0.000318, 8.82),
    ("s3_robust", "hot"): (30.7, 5.10, 3.74, 1.35, None, 0.000289, 8.84),
    ("s3_robust", "saturated"): (24.2, 4.54, 3.65, 1.57, None, 2.58e-05, 8.81),
    ("s3_robust", "imp"): (27.3, 4.63, 3.79, 1.47, None, 0.000236, 8.81),
    ("s3_robust", "all"): (34.9, 5.33, 3.11, 1.19, None, 0.00541, 8.79),
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
    ("steady", "ideal"): (1.34, 0.318, 0.0416, 0.0213, 0.121, None, 0.000209),
    ("steady", "deadtime"): (20.7, 3.81, 0.615, 0.250, 1.89, None, 0.797),
    ("steady", "imp"): (21.6, 4.11, 0.746, 0.265, 1.95, None, 0.856),
    ("steady", "all"): (19.9, 3.94, 0.636, 0.276, 1.82, None, 0.688),
    ("campaign", "ideal"): (18.6, 1.90, 0.0823, 0.0514, 0.0265, None, 0.000468),
    ("campaign", "adc"): (19.6, 2.20, 0.147, 0.0775, 0.0691, None, 0.0104),
    ("campaign", "deadtime"): (17.5, 2.47, 0.398, 0.103, 0.0840, None, 1.35),
    ("campaign", "hot"): (18.4, 1.88, 0.179, 0.0510, 0.0243, None, 0.00624),
    ("campaign", "saturated"): (18.4, 1.90, 0.0730, 0.0569, 0.0246, None, 0.000135),
    ("campaign", "imp"): (20.8, 2.58, 0.274, 0.0852, 0.120, None, 1.38),
    ("campaign", "all"): (20.2, 3.71, 0.369, 0.121, 0.181, None, 1.39),
    ("any", "ideal"): (20.1, 1.94, 0.950, 0.185, 0.0454, None, 0.000654),
    ("any", "deadtime"): (22.3, 2.17, 0.963, 0.188, 0.0699, None, 3.49),
    ("any", "imp"): (21.9, 2.30, 2.71, 0.287, 0.154, None, 3.40),
    ("any", "all"): (22.8, 2.74, 2.77, 0.416, 0.195, None, 3.44),
    ("s1_motor_b", "ideal"): (4.01, 0.926, 1.79, 0.452, 0.00215, None, 3.55),
    ("s1_motor_b", "adc"): (6.28, 1.29, 2.08, 0.469, 0.00178, None, 3.53),
    ("s1_motor_b", "hot"): (22.0, 1.37, 2.02, 0.696, 0.00183, None, 3.60),
    ("s1_motor_b", "saturated"): (3.38, 0.826, 1.32, 0.378, 0.00168, None, 3.55),
    ("s1_motor_b", "adc+hot+saturated"): (20.0, 1.64, 1.77, 0.907, 0.00304, None, 3.58),
    ("s1_motor_b", "deadtime"): (18.0, 1.22, 1.80, 0.457, 0.00133, None, 3.55),
    ("s1_motor_b", "imp"): (21.9, 2.02, 2.99, 0.838, 0.00377, None, 3.50),
    ("s1_motor_b", "all"): (18.6, 1.75, 2.43, 0.823, 5.51e-05, None, 3.58),
    ("s2_motor_b", "ideal"): (3.74, 1.02, 0.114, 0.00897, 0.607, None, 0.00110),
    ("s2_motor_b", "adc"): (6.17, 1.62, 0.181, 0.0343, 0.611, None, 0.00406),
    ("s2_motor_b", "hot"): (3.40, 0.902, 0.112, 0.00967, 0.653, None, 0.000956),
    ("s2_motor_b", "saturated"): (3.34, 0.878, 0.0884, 0.0100, 0.602, None, 0.000568),
    ("s2_motor_b", "adc+hot+saturated"): (5.43, 1.27, 0.152, 0.0328, 0.658, None, 0.00475),
    ("s2_motor_b", "deadtime"): (19.1, 4.08, 0.867, 0.0454, 0.610, None, 0.588),
    ("s2_motor_b", "imp"): (19.5, 4.59, 0.705, 0.0628, 0.631, None, 0.553),
    ("s2_motor_b", "all"): (22.8, 4.33, 0.986, 0.104, 0.666, None, 0.574),
    ("s1_odrive_d5065", "ideal"): (91.0, 19.2, 4.00, 6.68, 0.0532, None, 19.4),
    ("s1_odrive_d5065", "adc"): (108., 19.1, 4.62, 6.89, 0.0540, None, 19.3),
    ("s1_odrive_d5065", "hot"): (95.2, 8.58, 4.49, 5.69, 0.0123, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (140., 13.8, 6.72, 10.8, 0.0138, None, 19.4),
    ("s1_odrive_d5065", "adc+hot+saturated"): (85.7, 7.52, 4.81, 7.50, 0.0130, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (78.5, 28.1, 3.19, 3.12, 0.126, None, 3.17),
    ("s2_odrive_d5065", "adc"): (76.1, 28.2, 3.32, 2.96, 0.133, None, 3.18),
    ("s2_odrive_d5065", "hot"): (39.6, 5.57, 2.16, 2.30, 0.130, None, 3.35),
    ("s2_odrive_d5065", "saturated"): (50.1, 6.01, 2.67, 3.10, 0.132, None, 3.38),
    ("s2_odrive_d5065", "adc+hot+saturated"): (45.5, 3.91, 2.57, 3.33, 0.132, None, 3.36),
    ("s1_teknic_m2310p", "ideal"): (26.0, 3.41, 0.796, 0.247, 0.0827, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (30.9, 3.82, 2.32, 0.320, 0.0972, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (25.0, 3.34, 1.47, 0.467, 0.0637, None, 4.34),
    ("s1_teknic_m2310p", "saturated"): (24.1, 3.80, 0.679, 0.195, 0.0896, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (30.1, 4.17, 4.14, 0.477, 0.101, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (47.7, 3.96, 0.288, 0.0996, 0.0329, None, 1.09),
    ("s2_teknic_m2310p", "adc"): (47.8, 4.20, 0.292, 0.115, 0.0323, None, 1.09),
    ("s2_teknic_m2310p", "hot"): (48.2, 3.93, 0.255, 0.0738, 0.0289, None, 1.09),
    ("s2_teknic_m2310p", "saturated"): (49.1, 4.06, 0.351, 0.113, 0.0309, None, 1.10),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (50.3, 4.70, 0.405, 0.131, 0.0414, None, 1.09),
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
