# SPDX-License-Identifier: MIT
"""The tables of docs/equations.md, out of the register of traceability.

equations.py           says whether the page is as the register has it; exit status 1 if not
equations.py --write   writes the tables anew
"""
import argparse
import sys
import tomllib

import generated

sys.path.append(str(generated.ROOT / "tools/evidence"))
import traceability  # pylint: disable=wrong-import-position

HEADS = ["equation", "what", "in the code", "remark"]
PAPERS = "A", "B"


def entries(paper):
    register = tomllib.loads((generated.ROOT / traceability.REGISTER).read_text(encoding="utf-8"))
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
    return generated.table(HEADS, (
        [", ".join(ids), entry["title"], "; ".join(place(name, defined) for name in entry["functions"]), remark(entry)]
        for ids, entry in entries(paper)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables anew")
    write = parser.parse_args().write
    defined = traceability.Sources(generated.ROOT).functions
    generated.finish("docs/equations.md", {f"register: {paper}": table(paper, defined) for paper in PAPERS}, "the register",
                     write)


if __name__ == "__main__":
    main()
