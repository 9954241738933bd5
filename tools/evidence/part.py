# SPDX-License-Identifier: MIT
"""The common shape of the evidence: what each part writes as JSON, and page.py shows.

    {"part": "coverage", "title": "Coverage", "says": "one or two sentences: what is shown, and how",
     "figures": [{"name": "statements", "value": "100 %", "threshold": "100 %", "ok": true}],
     "tables": [{"title": "...", "note": "", "columns": ["..."], "rows": [["..."]]}]}

All values and cells are text, as a reader is to see it; a newline begins a new line of the cell. What has no threshold is
no figure, but stands in a table or its note. A part has no date and no path outside the project in it: the same sources
give the same page, but for how far the fuzzing comes in its time.
"""

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def arguments(parser):
    """Parses the command line, with the option --out; what an earlier run has left there goes away."""
    parser.add_argument("--out", type=Path, help="write what is found there, as JSON for the page")
    args = parser.parse_args()
    if args.out:
        args.out.unlink(missing_ok=True)
    return args


def figure(name, value, threshold, ok):
    return {"name": name, "value": str(value), "threshold": str(threshold), "ok": bool(ok)}


def table(title, columns, rows, note=""):
    texts = [[str(cell) for cell in row] for row in rows]
    wrong = [row for row in texts if len(row) != len(columns)]
    if wrong:
        raise ValueError(f"table '{title}': {wrong[0]} has {len(wrong[0])} cells; expected {len(columns)}")
    return {"title": title, "note": note, "columns": list(columns), "rows": texts}


def end(out, name, title, says, figures, tables, findings=()):
    """Prints the findings (`file:line: what`) and the figures, writes the part, and gives the exit status.

    What is found beside the figures is one: the page knows nothing else.
    """
    figures = list(figures)
    if figures and findings and all(entry["ok"] for entry in figures):
        figures.append(figure("other findings", len(findings), 0, False))
    for finding in findings:
        print(finding)
    for entry in figures:
        print(f"evidence.{name}: {entry['name']}: {entry['value']} (threshold {entry['threshold']})"
              f"{'' if entry['ok'] else ': NOT MET'}")
    if out:
        shape = {"part": name, "title": title, "says": says, "figures": figures, "tables": list(tables)}
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(json.dumps(shape, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    sys.stdout.flush()
    return 0 if figures and all(entry["ok"] for entry in figures) else 1
