# SPDX-License-Identifier: MIT
"""Tables of a page that are made of something else: compared with it by a test, written anew by --write.

A table stands between `<!-- NAME -->` and `<!-- end -->`.
"""
import re
import sys
from itertools import zip_longest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TABLE = re.compile(r"^(<!-- (?!end)([^>]+) -->\n)(.*?)(?=^<!-- end -->)", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"\d+\.?\d*")


def table(heads, rows):
    lines = (heads, ["---"] * len(heads), *rows)
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)


def tables(page):
    """The text of each table that the page has, by its name."""
    return {name: shown for _, name, shown in TABLE.findall((ROOT / page).read_text(encoding="utf-8"))}


def near(shown, now, margin, rounded):
    """Whether two rows have the same first cell, and the same words and numbers within their margin in the others."""
    (one, *cells), (other, *values) = (line.strip("|\n").split("|") for line in (shown, now))
    shown, now = "|".join(cells), "|".join(values)
    return one == other and NUMBER.sub("", shown) == NUMBER.sub("", now) and all(
        abs(old - new) <= margin * new + rounded
        for old, new in zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(now))))


def kept(page, made, margin, rounded=0.0):
    """made, but each row that the page shows within its margin as it is shown: only what has moved is written anew."""
    def row(shown, now):
        return next((old for old in shown if near(old, now, margin, rounded)), now)

    shown = {name: text.splitlines(True) for name, text in tables(page).items()}
    return {name: "".join(row(shown.get(name, ()), now) for now in text.splitlines(True)) for name, text in made.items()}


def departure(page, made):
    """The first row of the page's tables that is not as it is made, as a sentence; None without one."""
    shown = tables(page)
    for name, text in made.items():
        if name not in shown:
            return f"{page} has no table '{name}'; it has {', '.join(shown) or 'none'}"
        for old, new in zip_longest(shown[name].splitlines(), text.splitlines(), fillvalue="nothing"):
            if old != new:
                return f"{page}, {name}: shown: {old}  now: {new}"
    return None


def finish(page, made, source, write):
    """made: the text of each table by its name. source: what it is made of, as a sentence names it."""
    found = departure(page, made)
    if found and (not write or set(made) - set(tables(page))):
        sys.exit(f"{found}\n{page} is not what {source} has; `tools/dev figures --help` says how to renew it")
    if found:
        path = ROOT / page
        anew = TABLE.sub(lambda match: match[1] + made.get(match[2], match[3]), path.read_text(encoding="utf-8"))
        path.write_text(anew, encoding="utf-8")
