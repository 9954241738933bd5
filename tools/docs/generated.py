# SPDX-License-Identifier: MIT
"""Tables of a page that are made of something else: compared with it by a test, written anew by --write.

A table stands between `<!-- NAME -->` and `<!-- end -->`.
"""
import re
import shlex
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TABLE = re.compile(r"^(<!-- (?!end)([^>]+) -->\n).*?(?=^<!-- end -->)", re.MULTILINE | re.DOTALL)


def table(heads, rows):
    lines = (heads, ["---"] * len(heads), *rows)
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)


def finish(page, made, source, write):
    """made: the text of each table by its name. source: what it is made of, as a sentence names it."""
    path = ROOT / page
    text = path.read_text(encoding="utf-8")
    names = [name for _, name in TABLE.findall(text)]
    if names != list(made):
        sys.exit(f"{page} has the tables {names}, expected {list(made)}")
    anew = TABLE.sub(lambda match: match[1] + made[match[2]], text)
    if write:
        path.write_text(anew, encoding="utf-8")
    elif anew != text:
        shown, now = next((pair for pair in zip(text.splitlines(), anew.splitlines()) if pair[0] != pair[1]))
        sys.exit(f"{page} is not what {source} has; run {shlex.join(sys.argv)} --write\n  shown: {shown}\n  now:   {now}")
