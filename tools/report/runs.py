# SPDX-License-Identifier: MIT
"""Read a run: its trace (NAME.csv) and its metrics (NAME.json)."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from whole_file import read_whole

TIME = "time_s"
WORDS = ("state", "fault")  # columns of names or codes, kept as text


class PlotError(Exception):
    """One line for the user: which file, what is wrong, what was expected."""


@dataclass(frozen=True)
class Trace:
    """The columns of one CSV file by name; all have the length of time_s."""

    path: Path
    columns: dict

    def __getitem__(self, name):
        if name not in self.columns:
            raise PlotError(f"{self.path}: no column '{name}'; expected it in the header, "
                            f"which has: {', '.join(self.columns)}")
        return self.columns[name]

    def has(self, names):
        return all(name in self.columns for name in names)

    def cut(self, start=None, end=None):
        """The samples from start to end, in seconds; None is the end of the trace."""
        time = self[TIME]
        start = time[0] if start is None else start
        end = time[-1] if end is None else end
        keep = (time >= start) & (time <= end)
        if np.count_nonzero(keep) < 2:
            raise PlotError(f"{self.path}: fewer than two samples from {start:g} s to {end:g} s; "
                            f"expected a part of {time[0]:g} s to {time[-1]:g} s")
        return Trace(self.path, {name: values[keep] for name, values in self.columns.items()})


@dataclass(frozen=True)
class Run:
    name: str
    trace: Trace
    metrics: dict

    @property
    def scenario(self):
        """The scenario's name in lower case, without its variant: `s2` for S2 and s2_robust."""
        name = Path(str(self.metrics.get("scenario") or self.name)).stem.lower()
        numbered = re.match(r"s\d+(?=[_-]|$)", name)
        return numbered[0] if numbered else name


def read_text(path, expected):
    try:
        return read_whole(path).decode()
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}; expected {expected}") from error
    except UnicodeDecodeError as error:
        raise PlotError(f"{path}: not a text file; expected {expected}") from error


def read_trace(path):
    rows = read_text(path, "the CSV trace of a run").splitlines()
    names = [name.strip() for name in rows[0].split(",")] if rows else []
    if TIME not in names:
        raise PlotError(f"{path}: no column '{TIME}'; expected a header line of column names")
    if len(set(names)) < len(names):
        raise PlotError(f"{path}: a column name appears twice; expected each name once")
    table = split_rows(path, rows[1:], len(names))
    cells = zip(*table) if table else [()] * len(names)
    trace = Trace(path, {name: column(path, name, column_cells) for name, column_cells in zip(names, cells)})
    if len(table) < 2 or not np.all(np.diff(trace[TIME]) > 0):
        raise PlotError(f"{path}: {TIME} does not rise; expected two or more samples in order")
    return trace


def split_rows(path, rows, width):
    table = [row.split(",") for row in rows]
    for number, row in enumerate(table, start=2):
        if len(row) != width:
            raise PlotError(f"{path}: line {number} has {len(row)} fields; "
                            f"expected {width}, as in the header")
    return table


def column(path, name, cells):
    if name in WORDS:
        return np.array([cell.strip() for cell in cells], dtype=str)
    try:
        values = np.array([float(cell) for cell in cells])
    except ValueError as error:
        raise PlotError(f"{path}: column '{name}': {error}; expected numbers") from error
    if not np.isfinite(values).all():
        line = 2 + int(np.isfinite(values).argmin())
        raise PlotError(f"{path}: column '{name}': {cells[line - 2]} in line {line}; "
                        "expected finite numbers")
    return values


def read_metrics(path):
    text = read_text(path, "the metrics of the run of the same name")
    try:
        metrics = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise PlotError(f"{path}: {error}; expected one JSON object") from error
    if not isinstance(metrics, dict):
        raise PlotError(f"{path}: holds no object; expected one JSON object")
    return metrics


def natural_key(name):
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


def read_runs(folder):
    """All runs of a folder: every NAME.csv with its NAME.json, in the order of their names."""
    if not folder.is_dir():
        raise PlotError(f"{folder}: no such folder; expected the runs, NAME.csv and NAME.json each")
    names = {path.stem for path in folder.iterdir() if path.suffix in (".csv", ".json")}
    if not names:
        raise PlotError(f"{folder}: no runs; expected NAME.csv and NAME.json "
                        "(`motorsim run SCENARIO --trace NAME.csv --json NAME.json`)")
    return [Run(name, read_trace(folder / f"{name}.csv"), read_metrics(folder / f"{name}.json"))
            for name in sorted(names, key=natural_key)]
