# SPDX-License-Identifier: MIT
"""What the scenarios measure: tests/scenario/expected.toml, and the tables of docs/results.md and docs/voltage_drive.md.

expected.py MOTORSIM RUNS           says whether they are what is measured now; exit status 1 if not
expected.py MOTORSIM RUNS --write   writes what is not anew

RUNS is a file with a line SCENARIO:SET for each run. Of a set with noise a figure of the table is the mean over four seeds.
A figure that is within a fifth of what is measured stays as it is: only what has moved is written.
"""
import argparse
import functools
import json
import math
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import generated

TABLE = "tests/scenario/expected.toml"
RESULTS, VOLTAGE_DRIVE = "docs/results.md", "docs/voltage_drive.md"
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
ROUNDED = {RESULTS: 0.05, VOLTAGE_DRIVE: 0.005}  # half of the last digit
HEADER = f"""\
# What the scenarios measure: of each scenario, for each set of imperfections,
# [{', '.join(METRICS)}].
# nan: does not apply. Written by `tools/dev figures --write`; say in the commit why a figure has moved.
"""


def expected():
    """The table: (scenario, set) → the value of each of METRICS, None where it does not apply."""
    document = tomllib.loads((generated.ROOT / TABLE).read_text(encoding="utf-8"))
    return {(scenario, name): [None if math.isnan(value) else value for value in values]
            for scenario, sets in document.items() for name, values in sets.items()}


def runs_of(path):
    return [tuple(line.split(":")) for line in path.read_text(encoding="utf-8").split()]


def seeds_of(imperfection):
    return SEEDS if NOISY & set(imperfection.split("+")) else SEEDS[:1]


def near(mean, value, metric):
    """Whether a figure of the table is what is measured."""
    return mean == value if None in (mean, value) else abs(mean - value) <= MARGIN * value + FINEST[metric]


class Measured:
    """The results of the runs. What is in `folder` the tests of the scenarios have left there, with the first seed."""

    def __init__(self, motorsim, runs, folder=None):
        self.motorsim, self.runs, self.folder = motorsim, runs, folder

    def one(self, scenario, imperfection, seed):
        if self.folder and seed == SEEDS[0]:
            result = json.loads((self.folder / f"{scenario}.{imperfection}.json").read_text(encoding="utf-8"))
            assert result["seed"] == seed, f"{scenario} has the seed {result['seed']}"
            return result
        sets = [word for name in imperfection.split("+") for word in ("--with", name)]
        done = subprocess.run([self.motorsim, "run", scenario, *sets, "--json", "-", "--set", f"scenario.seed={seed}"],
                              text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
        return json.loads(done.stdout)

    @functools.cached_property
    def results(self):
        """Of each run a list over the seeds."""
        jobs = [(run, seed) for run in self.runs for seed in seeds_of(run[1])]
        with ThreadPoolExecutor(JOBS) as pool:
            results = list(pool.map(lambda job: self.one(*job[0], job[1]), jobs))
        found = {run: [] for run in self.runs}
        for (run, _), result in zip(jobs, results):
            found[run].append(result)
        return found

    def means(self, run):
        """Each of METRICS, its mean over the seeds; None where it does not apply."""
        results = self.results[run]
        return [None if results[0][metric] is None else
                sum(result[metric] for result in results) / len(results) for metric in METRICS]

    def largest(self, run, metric):
        return max(result[metric] for result in self.results[run])

    def first(self, run):
        return self.results[run][0]


# --- The table ---

def moved(measured, table):
    """A sentence for each figure of the table that is not what is measured, and for each run that is on one side only."""
    for run in measured.runs:
        name = f"{TABLE}, {run[0]} with {run[1]}"
        if run not in table:
            yield f"{name}: is not there"
            continue
        for metric, mean, value in zip(METRICS, measured.means(run), table[run], strict=True):
            if not near(mean, value, metric):
                yield f"{name}, {metric}: shown: {digits(value)}  now: {digits(mean)}"
    yield from (f"{TABLE}, {scenario} with {name}: no such run" for scenario, name in table.keys() - set(measured.runs))


def digits(value):
    """Three, as TOML."""
    text = "nan" if value is None else f"{value:#.3g}"
    return f"{text}0" if text.endswith(".") else text


def written(measured, table):
    """The table as text; what is near stays."""
    text = HEADER
    for scenario in dict.fromkeys(scenario for scenario, _ in measured.runs):
        text += f"\n[{scenario}]\n"
        for run in (run for run in measured.runs if run[0] == scenario):
            means = measured.means(run)
            values = [value if near(mean, value, metric) else mean
                      for metric, mean, value in zip(METRICS, means, table.get(run, means))]
            text += f"{json.dumps(run[1]) if '+' in run[1] else run[1]} = [{', '.join(map(digits, values))}]\n"
    return text


# --- The pages ---

def pair(result):
    return f"{result['speed_error_max_pct']:.2g}, {result['angle_error_max_deg']:.1f}°"


def scenarios_table(measured, suffix, sets):
    """S1 to S3 of motor A: speed error in % and angle error, and where S3 ends; of the first seed."""
    def cells(name):
        results = [measured.first((f"s{number}{suffix}", name)) for number in (1, 2, 3)]
        return [*map(pair, results), f"{math.degrees(results[2]['position_error_final_rad']):.2f}°"]

    return generated.table(["`--with`", "S1", "S2", "S3", "S3, end"], ([f"`{name}`", *cells(name)] for name in sets))


def motors_table(measured):
    """Speed errors of S1 and S2 in %, of the first seed."""
    motors = {"motor_b": "motor B", "odrive_d5065": "ODrive D5065", "teknic_m2310p": "Teknic M-2310P"}
    sets = {name: f"`{name}`" for name in ("ideal", "adc", "hot", "saturated")} | {"adc+hot+saturated": "all three"}
    rows = ([shown, *(", ".join(f"{measured.first((f'{scenario}_{motor}', name))['speed_error_max_pct']:.2g}"
                                for scenario in ("s1", "s2")) for motor in motors)] for name, shown in sets.items())
    return generated.table(["`--with`", *motors.values()], rows)


def voltage_drive_table(measured):
    columns = {"speed_error_max_pct": "{:.2f} %", "angle_error_max_deg": "{:.2f}°", "command_error_settled_pct": "{:.2f} %",
               "id_settled_a": "{:.3f} A"}
    rows = ([f"`{name}`", *(text.format(measured.largest(("s5", name), metric)) for metric, text in columns.items())]
            for name in ("deadtime", "imp", "all"))
    return generated.table(["set", "speed error", "angle error", "speed against command", "i_d"], rows)


def pages(measured):
    """The tables of each page; a row that it shows within the margin as it is shown."""
    robust = ("ideal", "adc", "deadtime", "hot", "saturated", "imp", "all")
    made = {RESULTS: {"published": scenarios_table(measured, "", ("ideal", "adc")),
                      "robust": scenarios_table(measured, "_robust", robust),
                      "other motors": motors_table(measured)},
            VOLTAGE_DRIVE: {"voltage drive": voltage_drive_table(measured)}}
    return {page: generated.kept(page, tables, MARGIN, ROUNDED[page]) for page, tables in made.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("motorsim", type=Path, metavar="MOTORSIM", help="the simulator")
    parser.add_argument("runs", type=Path, metavar="RUNS", help="file of the runs")
    parser.add_argument("--write", action="store_true", help="write what is not as measured anew")
    args = parser.parse_args()
    measured, table = Measured(args.motorsim.resolve(), runs_of(args.runs)), expected()
    found = list(moved(measured, table))
    if args.write and found:
        (generated.ROOT / TABLE).write_text(written(measured, table), encoding="utf-8")
    elif found:
        sys.exit("\n".join(found))
    for page, tables in pages(measured).items():
        generated.finish(page, tables, "the simulator", args.write)


if __name__ == "__main__":
    main()
