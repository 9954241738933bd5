# SPDX-License-Identifier: MIT
"""Run the simulator at a point and measure what it leaves: a trace at the control rate."""

import json
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from deadtime import harmonics
from deadtime.points import SETS, SHOWN, Point, pairs
from report.runs import TIME, PlotError, read_metrics, read_text, read_trace

BAD_INPUT = 2
SHOWN_TURNS = 4     # electrical ones


@dataclass(frozen=True)
class Result:
    """Of the steady part of a run, in whole electrical turns. Currents are those in the motor."""

    point: Point
    turns: int
    fundamental_a: float        # amplitude of phase a's
    thd_pct: float              # of phase a, orders 2 to harmonics.ORDERS
    distortion_pct: float       # of phase a: all but mean and fundamental
    iq_ripple_a: float          # rms about the mean
    speed_ripple_rpm: float     # likewise
    angle_mean_deg: float       # actual − estimated, electrical
    angle_max_deg: float
    held: bool                  # motorsim's `locked`


@dataclass(frozen=True)
class Wave:
    """What is drawn of a run."""

    point: Point
    time_s: list
    current_a: list             # phase a
    angle_error_deg: list
    shares_pct: list            # of each order in the fundamental


def evaluate(point, trace, held):
    """The Result of a steady trace, and its Wave."""
    try:
        whole, turns = harmonics.whole_turns(trace["angle_el_deg"])
    except ValueError as error:
        raise PlotError(f"{trace.path}: {error}") from error
    angle, current = trace["angle_el_deg"][whole], trace["i_a_a"][whole]
    found = harmonics.orders(angle, current)
    error = trace["angle_error_el_deg"][whole]
    result = Result(point, turns, found.fundamental, found.thd_pct, found.distortion_pct,
                    float(trace["i_q_a"][whole].std()), float(trace["speed_rpm"][whole].std()),
                    float(error.mean()), float(np.abs(error).max()), held)
    count = len(angle) * min(SHOWN_TURNS, turns) // turns
    wave = Wave(point, *(values[:count].tolist() for values in (trace[TIME][whole], current, error)),
                found.shares_pct.tolist())
    return result, wave


def run(program, point):
    """Simulates a point; its Result and Wave."""
    with tempfile.TemporaryDirectory() as folder:
        trace, metrics = (Path(folder) / f"run.{suffix}" for suffix in ("csv", "json"))
        command = [str(program), *point.arguments(), "--trace", str(trace), "--json", str(metrics)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except OSError as error:
            raise PlotError(f"{program}: {error.strerror}; expected motorsim: run tools/dev build") from error
        if done.returncode == BAD_INPUT or not trace.exists():
            raise PlotError(done.stderr.strip() or f"{program}: wrote no trace; expected motorsim")
        return evaluate(point, read_trace(trace).cut(start=0.0),
                        bool(read_metrics(metrics).get("locked")))


@dataclass(frozen=True)
class Measurement:
    """Results as (with, without) compensation, and the waves of the points that are drawn."""

    results: list
    waves: list

    def sets(self):
        """The imperfections that were measured, in their order."""
        return list(dict.fromkeys(pair[0].point.imperfections for pair in self.results))


def measure(program, sets=SETS):
    wanted = pairs(sets)
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        done = list(pool.map(lambda point: run(program, point),
                             [point for pair in wanted for point in pair]))
    both = list(zip(done[::2], done[1::2]))
    waves = [tuple(wave for _, wave in pair) for pair in both if where(pair[0][0]) in SHOWN]
    return Measurement([tuple(result for result, _ in pair) for pair in both], waves)


def where(result):
    return result.point.imperfections, result.point.speed_rpm, result.point.load_nm


def write(measurement, path):
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(asdict(measurement)), encoding="utf-8")
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}; expected a place to write to") from error


def read(path):
    text = read_text(path, "what `tools/plot.py deadtime` has measured")
    try:
        table = json.loads(text)
        return Measurement(*([tuple(known(kind, entry) for entry in pair) for pair in table[key]]
                             for kind, key in ((Result, "results"), (Wave, "waves"))))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise PlotError(f"{path}: {type(error).__name__} {error}; expected what "
                        "`tools/plot.py deadtime` has measured") from error


def known(kind, entry):
    return kind(**{**entry, "point": Point(**entry["point"])})
