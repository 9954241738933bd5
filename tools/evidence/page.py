# SPDX-License-Identifier: MIT
"""evidence.page: the parts of the evidence as one page, build/report/evidence.html.

It holds when every part that is asked for is there and keeps all of its thresholds. The page is written in any case:
a part that is missing is shown as that.
"""

import argparse
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where the parts are, PART.json each")
    parser.add_argument("page", type=Path, help="the HTML file to write")
    parser.add_argument("parts", nargs="+", help="the parts that have to be there, in the order of the page")
    args = parser.parse_args()
    parts = [read(args.folder, name) for name in args.parts]
    args.page.parent.mkdir(parents=True, exist_ok=True)
    args.page.write_text(page(parts), encoding="utf-8")
    bad = [part["part"] for part in parts if not holds(part)]
    print(f"evidence.page: {args.page}" + (f": not kept: {', '.join(bad)}" if bad else ""))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
