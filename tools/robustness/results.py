# SPDX-License-Identifier: MIT
"""The results of a campaign on disk: a line of JSON a run, written as runs end, in any order.

The first line says what they are results of. A line is one write to the end of the file; what an
interrupted write left is dropped by the next start.
"""

import fcntl
import json
import os

from whole_file import read_whole

from .campaign import CampaignError

FILE = "runs.jsonl"
HEAD_KEYS = {"settings", "files"}
ROW_KEYS = {"run", "outcome", "values", "metrics"}


def as_line(content):
    return (json.dumps(content, ensure_ascii=False) + "\n").encode()


def whole_lines(path):
    """The objects of the file's complete lines, and how many bytes those take."""
    content = read_whole(path)
    size = content.rfind(b"\n") + 1
    try:
        lines = [json.loads(line) for line in content[:size].splitlines()]
    except (ValueError, RecursionError) as error:
        raise CampaignError(f"{path}: {error}; expected a line of JSON a run") from error
    for number, line in enumerate(lines, start=1):
        if not isinstance(line, dict) or not line.keys() >= (ROW_KEYS if number > 1 else HEAD_KEYS):
            raise CampaignError(f"{path}: line {number} is none of `tools/campaign run`; expected "
                                "its results")
    return lines, size


def read(folder):
    """Head and rows, sorted by run, of a campaign that has run before."""
    path = folder / FILE
    try:
        lines, _ = whole_lines(path)
    except OSError as error:
        raise CampaignError(f"{path}: {error.strerror}; expected results of "
                            "`tools/campaign run`") from error
    if not lines:
        raise CampaignError(f"{path}: is empty; expected results of `tools/campaign run`")
    return lines[0], sorted(lines[1:], key=lambda row: row["run"])


def changed_setting(head, settings):
    """The first setting of the campaign that is not what it was, or None."""
    for name in {**head["settings"], **settings}:
        before, now = head["settings"].get(name, "none"), settings.get(name, "none")
        if before != now:
            return f"{name} was {before}, is {now}"
    return None


def difference(old, new):
    """The first thing in which two heads differ, or None."""
    setting = changed_setting(old, new["settings"])
    if setting:
        return setting
    for name, text in new["files"].items():
        if old["files"].get(name) != text:
            return f"the {name} changed"
    return None


class Store:
    """Appends to the results; the only writer as long as it is open."""

    def __init__(self, folder, head, fresh=False):
        self.path = folder / FILE
        self.rows = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        except OSError as error:
            raise CampaignError(f"{self.path}: {error.strerror}; "
                                "expected a place to write to") from error
        try:
            self.begin(head, fresh)
        except BaseException:
            os.close(self.file)
            raise

    def begin(self, head, fresh):
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise CampaignError(f"{self.path}: another campaign writes there; "
                                "expected its end, or another --out") from error
        if fresh:
            os.ftruncate(self.file, 0)
        lines, size = whole_lines(self.path)
        os.ftruncate(self.file, size)
        if not lines:
            self.write(head)
            return
        differs = difference(lines[0], head)
        if differs:
            raise CampaignError(f"{self.path}: cannot be continued: {differs}; expected the same "
                                "campaign, simulator and data files, or --fresh to begin anew")
        self.rows = lines[1:]

    def write(self, content):
        line = as_line(content)
        try:
            written = os.write(self.file, line)
        except OSError as error:
            raise CampaignError(f"{self.path}: {error.strerror}; expected to write there") from error
        if written != len(line):
            raise CampaignError(f"{self.path}: is cut short; expected room on the disk")

    def add(self, row):
        self.write(row)
        self.rows.append(row)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.file)


def head_of(campaign, files):
    return {"campaign": campaign.name, "settings": campaign.settings(), "files": files}


def row_of(run, outcome, values, metrics):
    return {"run": run, "outcome": outcome, "values": values, "metrics": metrics}
