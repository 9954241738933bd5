# SPDX-License-Identifier: MIT
"""Files that a campaign leaves beside its results: all runs as CSV, the failures as commands."""

import csv

from whole_file import whole_file

from . import summary
from .campaign import CampaignError

CSV_FILE = "runs.csv"
FAILURES_FILE = "failures.txt"
HEAD = """\
# {name}: {count} of {runs} runs do not hold. A line is the command that makes that run again;
# with --trace FILE it writes every tick.
"""


def cell(value):
    if isinstance(value, list):
        return "; ".join(map(str, value))
    if isinstance(value, bool):
        return "true" if value else "false"
    return "" if value is None else value


def flat(metrics):
    """Those within a metric get its name before theirs."""
    for name, value in metrics.items():
        if isinstance(value, dict):
            yield from ((f"{name}.{inner}", found) for inner, found in flat(value))
        else:
            yield name, value


def table_of(campaign, rows):
    """Header and cells: the run, how it ended, what was varied, all metrics."""
    varied = list(campaign.values(0))
    found = [dict(flat(row["metrics"])) for row in rows]
    metrics = list({name: None for one in found for name in one})
    yield ["run", "outcome", *varied, *metrics]
    for row, one in zip(rows, found, strict=True):
        yield [row["run"], row["outcome"], *(row["values"][key] for key in varied),
               *(cell(one.get(name)) for name in metrics)]


def write(folder, campaign, rows, command_of):
    """Writes both; returns their paths."""
    table, failures = folder / CSV_FILE, folder / FAILURES_FILE
    failed = summary.failures(rows)
    try:
        with whole_file(table, newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table_of(campaign, rows))
        with whole_file(failures) as file:
            file.write(HEAD.format(name=campaign.name, count=len(failed), runs=len(rows)))
            file.writelines(failure_line(row, command_of) for row in failed)
    except OSError as error:
        raise CampaignError(f"{error.filename}: {error.strerror}; "
                            "expected a place to write to") from error
    return table, failures


def failure_line(row, command_of):
    varied = " ".join(f"{key}={text}" for key, text in row["values"].items())
    return (f"{command_of(row['run'])}  # {row['outcome']}: {summary.reason(row)}; {varied}\n")
