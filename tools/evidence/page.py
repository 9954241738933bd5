# SPDX-License-Identifier: MIT
"""The parts of the evidence as one page. A part that is missing is shown as that."""

import json
import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOOLS))

from report.render import render  # noqa: E402


def missing(name):
    """In place of a part that has not been written: its test did not run, or ended too early."""
    return {"part": name, "title": name.capitalize(), "says": "This part was not made.",
            "figures": [{"name": "made", "value": "no", "threshold": "yes", "ok": False}], "tables": []}


def read(folder, name):
    path = folder / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else missing(name)


def holds(part):
    return bool(part["figures"]) and all(figure["ok"] for figure in part["figures"])


def page(parts):
    return render("evidence/page.jinja", links=[(part["part"], part["title"]) for part in parts],
                  parts=[{**part, "holds": holds(part)} for part in parts])
