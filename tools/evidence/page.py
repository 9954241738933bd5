# SPDX-License-Identifier: MIT
"""evidence.page: the parts of the evidence as one page, build/report/evidence.html.

It holds when every part that is asked for is there and keeps all of its thresholds. The page is written in any case:
a part that is missing is shown as that.
"""

import argparse
import html
import json
import re
import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOOLS))

from report.document import anchor, document  # noqa: E402

BREAKS = re.compile(r"(?<=\w)[_/.](?=\w)")
FOLDED_FROM = 13  # rows; a longer table is closed until it is asked for
HEADS = ("Part", "Figure", "Value", "Threshold", "Verdict")
SAYS = ("What is known of the control core beside its simulated runs: each part with what it measures and what has to "
        "be kept. All of it is made by <code>ctest --preset host -L evidence</code>.")


def missing(name):
    """In place of a part that has not been written: its test did not run, or ended too early."""
    return {"part": name, "title": name.capitalize(), "says": "This part was not made.",
            "figures": [{"name": "made", "value": "no", "threshold": "yes", "ok": False}], "tables": []}


def read(folder, name):
    path = folder / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else missing(name)


def holds(part):
    return bool(part["figures"]) and all(figure["ok"] for figure in part["figures"])


def text(cell):
    """As HTML that can be broken within long names; a line of the cell is one of the page."""
    escaped = html.escape(cell).replace("\n", "<br>")
    return BREAKS.sub(r"\g<0><wbr>", escaped)


def verdict(ok):
    mark, word = ("good", "kept") if ok else ("bad", "not kept")
    return f'<span class="verdict {mark}">{word}</span>'


def row(cells, columns):
    """The first cell is the head of its row; the others carry the names of their columns for narrow screens."""
    head, *others = cells
    return (f"<tr><th scope=row>{head}</th>"
            + "".join(f'<td data-label="{html.escape(column)}"><span>{cell}</span></td>'
                      for column, cell in zip(columns[1:], others)) + "</tr>")


def rows_and_heads(columns, rows):
    heads = "".join(f"<th scope=col>{html.escape(column)}</th>" for column in columns)
    body = "\n".join(row(cells, columns) for cells in rows)
    return f'<table class="cards">\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>'


def summary(parts):
    cells = []
    for part in parts:
        for number, figure in enumerate(part["figures"]):
            name = anchor(part["part"], part["title"]) if number == 0 else ""
            cells.append([name, *(text(figure[key]) for key in ("name", "value", "threshold")),
                          verdict(figure["ok"])])
    return f"<section>\n<h2>Summary</h2>\n{rows_and_heads(HEADS, cells)}\n</section>"


def table(content):
    shown = rows_and_heads(content["columns"], [list(map(text, cells)) for cells in content["rows"]])
    if content["note"]:
        shown = f"<p class=muted>{html.escape(content['note'])}</p>\n{shown}"
    title = html.escape(content["title"])
    count = len(content["rows"])
    if count < FOLDED_FROM:
        return f"<h3>{title}</h3>\n{shown}"
    return f"<details>\n<summary>{title} <span class=muted>({count} rows)</span></summary>\n{shown}\n</details>"


def section(part):
    tables = "\n".join(map(table, part["tables"]))
    return (f'<section id="{html.escape(part["part"])}">\n<h2>{html.escape(part["title"])}</h2>\n'
            f"<p>{html.escape(part['says'])} {verdict(holds(part))}</p>\n{tables}\n</section>")


def page(parts):
    links = "".join(anchor(part["part"], part["title"]) for part in parts)
    header = f'<h1>Evidence</h1>\n<p>{SAYS}</p>\n<nav aria-label="Parts">{links}</nav>'
    return document("neurofoc: evidence", header, "\n".join([summary(parts), *map(section, parts)]))


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
