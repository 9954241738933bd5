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
    ("s1_robust", "ideal"): (10.0, 1.72, 0.963, 0.356, 0.0424, None, 8.40),
    ("s1_robust", "adc"): (17.8, 2.17, 1.28, 0.407, 0.0792, None, 8.36),
    ("s1_robust", "deadtime"): (12.9, 2.15, 0.966, 0.357, 0.0893, None, 8.40),
    ("s1_robust", "hot"): (11.3, 1.93, 0.985, 0.599, 0.0423, None, 8.41),
    ("s1_robust", "saturated"): (9.95, 1.65, 0.803, 0.311, 0.0417, None, 8.40),
    ("s1_robust", "imp"): (33.2, 3.88, 1.13, 0.709, 0.454, None, 8.40),
    ("s1_robust", "all"): (15.8, 3.17, 1.64, 0.608, 0.316, None, 8.36),
    ("s2_robust", "ideal"): (14.6, 1.62, 0.0682, 0.0254, 0.0270, None, 0.000181),
    ("s2_robust", "adc"): (16.6, 1.87, 0.121, 0.0570, 0.0558, None, 0.00726),
    ("s2_robust", "deadtime"): (15.8, 1.93, 0.161, 0.0538, 0.0759, None, 1.35),
    ("s2_robust", "hot"): (14.7, 1.63, 0.0799, 0.0246, 0.0279, None, 0.000422),
    ("s2_robust", "saturated"): (14.2, 1.60, 0.0620, 0.0276, 0.0265, None, 0.000355),
    ("s2_robust", "imp"): (16.8, 2.24, 0.256, 0.0713, 0.0967, None, 1.38),
    ("s2_robust", "all"): (19.5, 3.03, 0.332, 0.130, 0.154, None, 1.38),
    ("s3_robust", "ideal"): (25.0, 4.44, 3.61, 1.44, None, 4.23e-05, 8.81),
    ("s3_robust", "adc"): (27.4, 4.56, 3.55, 1.40, None, 0.00311, 8.78),
    ("s3_robust", "deadtime"): (30.3, 4.54, 3.49, 1.35, None, 0.000262, 8.81),
    ("s3_robust", "hot"): (25.6, 4.86, 3.57, 1.27, None, 0.000289, 8.84),
    ("s3_robust", "saturated"): (23.9, 4.46, 3.67, 1.57, None, 2.50e-05, 8.83),
    ("s3_robust", "imp"): (28.4, 4.85, 3.77, 1.47, None, 0.000252, 8.82),
    ("s3_robust", "all"): (28.3, 5.06, 3.31, 1.18, None, 0.00543, 8.77),
    ("s4", "ideal"): (7.70, 0.725, 0.0737, 0.0249, 0.992, None, 9.68e-05),
    ("s4", "adc"): (7.68, 0.722, 0.0732, 0.0245, 0.990, None, 0.00763),
    ("s4", "encoder"): (8.45, 0.748, 0.144, 0.0422, 0.991, None, 0.000116),
    ("s4", "adc+encoder"): (8.11, 0.748, 0.112, 0.0377, 0.992, None, 0.00763),
    ("s4", "hot"): (7.74, 0.712, 0.0743, 0.0186, 0.954, None, 0.000466),
    ("s4", "deadtime"): (7.45, 0.549, 0.0726, 0.0547, 1.09, None, 6.86e-05),
    ("s4", "imp"): (7.42, 0.535, 0.0711, 0.743, 1.01, None, 7.97e-05),
    ("s4", "all"): (7.45, 0.561, 0.0718, 0.675, 1.18, None, 0.00819),
    ("s4", "saturated"): (7.56, 0.701, 0.0720, 0.812, 0.446, None, 0.000640),
    ("s5", "ideal"): (4.85, 1.08, 0.117, 0.0155, 1.02, None, 0.00151),
    ("s5", "adc"): (7.42, 1.94, 0.380, 0.0458, 1.01, None, 0.0113),
    ("s5", "deadtime"): (6.74, 1.33, 0.232, 0.0239, 1.13, None, 0.00254),
    ("s5", "hot"): (4.99, 0.833, 0.106, 0.0109, 1.09, None, 0.00166),
    ("s5", "saturated"): (4.78, 0.854, 0.0725, 0.0135, 0.479, None, 0.000793),
    ("s5", "imp"): (9.65, 2.04, 0.361, 0.0423, 1.08, None, 0.00322),
    ("s5", "all"): (8.87, 2.09, 0.447, 0.0513, 1.22, None, 0.0173),
    ("steady", "ideal"): (1.33, 0.321, 0.0408, 0.0207, 0.139, None, 0.000171),
    ("steady", "deadtime"): (21.1, 3.69, 0.597, 0.250, 1.78, None, 0.763),
    ("steady", "imp"): (20.8, 4.02, 0.757, 0.239, 1.93, None, 0.803),
    ("steady", "all"): (22.1, 3.83, 0.650, 0.306, 1.75, None, 0.693),
    ("campaign", "ideal"): (18.9, 1.95, 0.0995, 0.0302, 0.0307, None, 0.00118),
    ("campaign", "adc"): (18.3, 2.19, 0.169, 0.0610, 0.0710, None, 0.0131),
    ("campaign", "deadtime"): (20.3, 2.33, 0.285, 0.0738, 0.0729, None, 1.35),
    ("campaign", "hot"): (19.2, 1.98, 0.103, 0.0297, 0.0245, None, 0.00114),
    ("campaign", "saturated"): (18.8, 1.96, 0.0880, 0.0353, 0.0261, None, 0.000252),
    ("campaign", "imp"): (19.9, 2.41, 0.247, 0.0873, 0.0932, None, 1.37),
    ("campaign", "all"): (19.9, 3.67, 0.431, 0.131, 0.159, None, 1.38),
    ("any", "ideal"): (20.2, 1.93, 0.960, 0.187, 0.0585, None, 0.000279),
    ("any", "deadtime"): (22.7, 2.14, 0.953, 0.186, 0.0666, None, 3.49),
    ("any", "imp"): (24.8, 2.30, 2.66, 0.234, 0.134, None, 3.40),
    ("any", "all"): (26.0, 2.69, 2.60, 0.358, 0.148, None, 3.43),
    ("s1_motor_b", "ideal"): (4.03, 0.926, 1.81, 0.454, 0.000933, None, 3.54),
    ("s1_motor_b", "adc"): (6.71, 1.30, 2.11, 0.484, 0.00242, None, 3.52),
    ("s1_motor_b", "hot"): (11.1, 1.30, 2.03, 0.631, 0.00166, None, 3.53),
    ("s1_motor_b", "saturated"): (3.42, 0.777, 1.44, 0.399, 0.000322, None, 3.54),
    ("s1_motor_b", "adc+hot+saturated"): (12.4, 1.55, 1.87, 0.832, 0.00329, None, 3.52),
    ("s1_motor_b", "deadtime"): (6.54, 1.04, 1.83, 0.463, 0.000939, None, 3.53),
    ("s1_motor_b", "imp"): (20.7, 1.94, 2.63, 0.752, 0.00507, None, 3.54),
    ("s1_motor_b", "all"): (12.3, 1.69, 2.46, 0.767, 0.00, None, 3.52),
    ("s2_motor_b", "ideal"): (3.75, 1.03, 0.0912, 0.00962, 0.605, None, 0.000161),
    ("s2_motor_b", "adc"): (6.16, 1.59, 0.185, 0.0333, 0.617, None, 0.00327),
    ("s2_motor_b", "hot"): (3.60, 0.918, 0.0798, 0.00910, 0.652, None, 0.000105),
    ("s2_motor_b", "saturated"): (3.47, 0.855, 0.0671, 0.00998, 0.607, None, 0.000186),
    ("s2_motor_b", "adc+hot+saturated"): (5.48, 1.25, 0.147, 0.0330, 0.661, None, 0.00348),
    ("s2_motor_b", "deadtime"): (18.0, 3.80, 0.641, 0.0464, 0.602, None, 0.562),
    ("s2_motor_b", "imp"): (15.1, 3.77, 0.517, 0.0504, 0.599, None, 0.578),
    ("s2_motor_b", "all"): (27.4, 4.45, 0.876, 0.0966, 0.679, None, 0.567),
    ("s1_odrive_d5065", "ideal"): (110., 19.9, 4.76, 6.82, 0.0469, None, 19.5),
    ("s1_odrive_d5065", "adc"): (88.0, 18.4, 3.87, 5.20, 0.0561, None, 19.3),
    ("s1_odrive_d5065", "hot"): (58.9, 4.68, 2.82, 5.34, 0.0165, None, 19.5),
    ("s1_odrive_d5065", "saturated"): (159., 14.6, 7.56, 11.8, 0.0141, None, 19.5),
    ("s1_odrive_d5065", "adc+hot+saturated"): (84.1, 6.57, 4.50, 7.61, 0.0140, None, 19.3),
    ("s2_odrive_d5065", "ideal"): (70.9, 27.4, 3.25, 2.84, 0.130, None, 3.24),
    ("s2_odrive_d5065", "adc"): (76.5, 28.3, 3.21, 3.15, 0.132, None, 3.18),
    ("s2_odrive_d5065", "hot"): (44.7, 4.43, 2.47, 2.20, 0.130, None, 3.39),
    ("s2_odrive_d5065", "saturated"): (47.4, 3.72, 2.63, 2.95, 0.129, None, 3.35),
    ("s2_odrive_d5065", "adc+hot+saturated"): (49.1, 3.57, 2.65, 3.06, 0.132, None, 3.38),
    ("s1_teknic_m2310p", "ideal"): (25.5, 3.36, 0.843, 0.255, 0.0656, None, 4.33),
    ("s1_teknic_m2310p", "adc"): (32.6, 3.80, 1.93, 0.269, 0.0843, None, 4.31),
    ("s1_teknic_m2310p", "hot"): (26.5, 3.37, 1.52, 0.449, 0.0618, None, 4.33),
    ("s1_teknic_m2310p", "saturated"): (21.8, 3.68, 1.03, 0.184, 0.0839, None, 4.33),
    ("s1_teknic_m2310p", "adc+hot+saturated"): (37.5, 4.18, 3.75, 0.451, 0.0854, None, 4.31),
    ("s2_teknic_m2310p", "ideal"): (46.8, 3.96, 0.317, 0.127, 0.0248, None, 1.10),
    ("s2_teknic_m2310p", "adc"): (48.3, 4.20, 0.350, 0.143, 0.0312, None, 1.09),
    ("s2_teknic_m2310p", "hot"): (48.8, 4.08, 0.308, 0.108, 0.0235, None, 1.10),
    ("s2_teknic_m2310p", "saturated"): (46.9, 3.95, 0.271, 0.120, 0.0251, None, 1.10),
    ("s2_teknic_m2310p", "adc+hot+saturated"): (48.3, 4.83, 0.325, 0.137, 0.0317, None, 1.09),
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
