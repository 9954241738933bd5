# SPDX-License-Identifier: MIT
"""The tables of docs/equations.md, out of the register of traceability.

equations.py           says whether the page is as the register has it; exit status 1 if not
equations.py --write   writes the tables anew

A table stands between `<!-- register: PAPER -->` and `<!-- end -->`.
"""
import argparse
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/equations.md"
sys.path.append(str(ROOT / "tools/evidence"))
import traceability  # pylint: disable=wrong-import-position

TABLE = re.compile(r"(<!-- register: (\w) -->\n).*?(?=<!-- end -->)", re.DOTALL)
HEAD = "| equation | what | in the code | remark |\n| --- | --- | --- | --- |\n"


def entries(paper):
    register = tomllib.loads((ROOT / traceability.REGISTER).read_text(encoding="utf-8"))
    for entry in register["entry"]:
        ids = entry["id"] if isinstance(entry["id"], list) else [entry["id"]]
        if ids[0].startswith(f"{paper} "):
            yield [identity.removeprefix(f"{paper} ") for identity in ids], entry


def place(name, defined):
    return ", ".join(f"`{path.name}:{name}`" for path in sorted(defined[name]))


def remark(entry):
    departs = "departs: " if entry.get("status") == traceability.DEPARTS else ""
    return departs + entry.get("note", "")


def table(paper, defined):
    rows = (f"| {', '.join(ids)} | {entry['title']} | {'; '.join(place(name, defined) for name in entry['functions'])} |"
            f" {remark(entry)} |\n" for ids, entry in entries(paper))
    return HEAD + "".join(rows)


def page_anew(text):
    defined = traceability.functions(ROOT)
    return TABLE.sub(lambda match: match[1] + table(match[2], defined), text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables anew")
    write = parser.parse_args().write
    text = PAGE.read_text(encoding="utf-8")
    anew = page_anew(text)
    if write:
        PAGE.write_text(anew, encoding="utf-8")
    elif anew != text:
        sys.exit("docs/equations.md is not what the register has; run tools/docs/equations.py --write")


if __name__ == "__main__":
    main()
