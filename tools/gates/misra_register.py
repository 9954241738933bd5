# SPDX-License-Identifier: MIT
"""gate.misra_register: deviation tags in the code and firmware/MISRA.md say the same.

A tag is a suppression with the id of its deviation, and more words where they help:
    // cppcheck-suppress misra-c2012-11.4 ; D1: the address is given by the chip
The register's row of D1 names that rule, each file:function that has the tag, and the reason.
"""

import argparse
import re
from pathlib import Path

import sources

REGISTER = Path("firmware/MISRA.md")
TAG = re.compile(r"cppcheck-suppress(?P<rest>.*?)(?=cppcheck-suppress|$)")
GOOD_TAG = re.compile(r"\s+misra-c2012-(?P<rule>\d+\.\d+)\s*;\s*(?P<id>D\d+)\b")
ROW = re.compile(r"^\|\s*(D\d+)\s*\|\s*(\d+\.\d+)\s*\|([^|]+)\|([^|]+)\|", re.MULTILINE)
OFF = re.compile(r"^\|\s*(\d+\.\d+(?:, \d+\.\d+)*)\s*\|\s*([^|]+?)\s*\|$", re.MULTILINE)


def disapplied(root):
    """Each rule that the register lays down for the whole firmware, and why."""
    text = (root / REGISTER).read_text(encoding="utf-8")
    return {rule: reason for rules, reason in OFF.findall(text) for rule in rules.split(", ")}


def tags(root, bad):
    """All (id, rule, file) in the code; malformed tags are added to `bad`."""
    found = set()
    for path in sources.files(root, "firmware/*.c", "firmware/*.h", "hal/*.c", "hal/*.h"):
        text = (root / path).read_text(encoding="utf-8")
        for number, line in enumerate(text.splitlines(), 1):
            for tag in TAG.finditer(line):
                good = GOOD_TAG.match(tag["rest"])
                if good:
                    found.add((good["id"], good["rule"], path.as_posix()))
                else:
                    bad.append(f"{path}:{number}: a tag reads "
                               "`cppcheck-suppress misra-c2012-<rule> ; D<n>`")
    return found


def rows(root, bad):
    """All (id, rule, file) of the register; rows that cannot be true are added to `bad`."""
    found, ids = set(), set()
    for name, rule, where, reason in ROW.findall((root / REGISTER).read_text(encoding="utf-8")):
        if name in ids:
            bad.append(f"{REGISTER}: {name} has two rows")
        ids.add(name)
        if not reason.strip():
            bad.append(f"{REGISTER}: {name} has no reason")
        for place in where.replace("`", "").split(","):
            file, _, function = place.strip().partition(":")
            found.add((name, rule, file))
            text = (root / file).read_text(encoding="utf-8") if (root / file).is_file() else ""
            if not function or not re.search(rf"\b{re.escape(function)}\b", text):
                bad.append(f"{REGISTER}: {name}: there is no {place.strip()}")
    return found


def findings(root):
    bad = []
    tagged, registered = tags(root, bad), rows(root, bad)
    bad += [f"{file}: {name} ({rule}) is tagged here but {REGISTER} does not say so"
            for name, rule, file in sorted(tagged - registered)]
    bad += [f"{REGISTER}: {name} ({rule}) has no tag in {file}"
            for name, rule, file in sorted(registered - tagged)]
    return bad


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, default=sources.ROOT)
    args = parser.parse_args()
    sources.finish("misra_register", findings(args.root),
                   f"Tag each deviation at its line and give it a row in {REGISTER}.")
