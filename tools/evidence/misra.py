# SPDX-License-Identifier: MIT
"""evidence.misra: the compliance of the firmware with each guideline of MISRA C:2012.

Made of four things: the list of guidelines (tests/evidence/misra_rules.toml), the rules that the checker decides (asked
of its addon), what gate.misra found in its last run, and the deviations in the register firmware/MISRA.md. It holds
when no rule is violated, each guideline has something that decides it, no mandatory rule has a deviation, only advisory
ones are not followed, and what is called not applicable has no match in the code.
"""

import argparse
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import ctested
import part

sys.path.insert(0, str(part.ROOT / "tools" / "gates"))

import misra_register  # noqa: E402
import sources  # noqa: E402

RULES = Path("tests/evidence/misra_rules.toml")
DIRECTIVES = {1: 1, 2: 1, 3: 1, 4: 14}
FOUND = re.compile(r"\[misra-c2012-(\d+\.\d+)\]")
ASKED = """
import json, pathlib, sys, cppcheck
sys.path.insert(0, str(pathlib.Path(cppcheck.__file__).parent / "data" / "addons"))
import misra
print(json.dumps({"addon": misra.getAddonRules(), "cppcheck": misra.getCppcheckRules()}))
"""
SAYS = ("Each guideline of MISRA C:2012 with amendments 1 and 2: whether the firmware and the HALs of targets comply, by "
        "what this is known, or why not. From the output of cppcheck's addon, its list of rules and the register of "
        "deviations; the texts of the guidelines belong to MISRA.")


def in_order(rule):
    return rule.startswith("Dir"), *map(int, rule.removeprefix("Dir ").split("."))


def spread(names):
    """["21.3-21.5", "2.6"] as each rule of them."""
    for name in names:
        first, _, last = name.partition("-")
        chapter, number = first.rsplit(".", 1)
        for k in range(int(number), int((last or first).rsplit(".", 1)[1]) + 1):
            yield f"{chapter}.{k}"


def decided_by_checker():
    """Rule → what of the checker decides it."""
    run = subprocess.run([sys.executable, "-c", ASKED], capture_output=True, text=True, check=True)
    answer = json.loads(run.stdout)
    return {**dict.fromkeys(answer["cppcheck"], "cppcheck"), **dict.fromkeys(answer["addon"], "cppcheck's addon")}


class Guidelines:
    """What misra_rules.toml says."""

    def __init__(self, path):
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        rules = {f"{chapter}.{k}": words for chapter, (words, count) in content["chapters"].items()
                 for k in range(1, count + 1)}
        self.subjects = {**rules, **{f"Dir {chapter}.{k}": "directive" for chapter, count in DIRECTIVES.items()
                                     for k in range(1, count + 1)}}
        self.categories = {rule: category for category, names in content["categories"].items() for rule in names}
        self.absent = [{**entry, "rules": list(spread(entry["rules"]))} for entry in content["absent"]]
        self.held, self.not_followed = {}, {}
        for entry in content["held"]:
            for rule in spread(entry["rules"]):
                self.held.setdefault(rule, []).append((entry["means"], entry.get("test")))
        for entry in content["not_followed"]:
            self.not_followed |= dict.fromkeys(spread(entry["rules"]), entry["reason"])

    def category(self, rule):
        return self.categories.get(rule, "required")


def deviations(root):
    """Rule → its rows in the register, as text."""
    found = {}
    text = (root / misra_register.REGISTER).read_text(encoding="utf-8").replace("`", "")
    for name, rule, where, reason in misra_register.ROW.findall(text):
        found.setdefault(rule, []).append(f"{name}, {where.strip()}: {reason.strip()}")
    return found


def matches(root, pattern, checked):
    """file:line of each place in the code that matches."""
    for path in checked:
        code = sources.strip((root / path).read_text(encoding="utf-8"))
        for match in re.finditer(pattern, code):
            yield f"{path}:{code.count(chr(10), 0, match.start()) + 1}"


class Table:
    """Status and reason of each guideline; what is wrong with that is in `bad`."""

    def __init__(self, root, guidelines, checked, run_by_ctest):
        self.guidelines = guidelines
        self.deviations = deviations(root)
        self.not_followed = misra_register.disapplied(root) | guidelines.not_followed
        self.checker, self.run_by_ctest = decided_by_checker(), run_by_ctest
        self.violated, self.absent, self.bad = {}, {}, []
        for line in checked["findings"]:
            match = FOUND.search(line)
            if match:
                self.violated.setdefault(match[1], []).append(line)
            else:
                self.bad.append(line)  # of cppcheck itself, which decides some rules under names of its own
        for entry in guidelines.absent:
            places = list(matches(root, entry["pattern"], checked["files"]))
            self.bad += [f"{place}: not so: {entry['reason']} ({entry['rules'][0]})" for place in places]
            if not places:
                self.absent |= dict.fromkeys(entry["rules"], entry["reason"])
        self.bad += [f"{RULES}: rule {rule} of the checker is missing"
                     for rule in sorted(set(self.checker) - set(guidelines.subjects), key=in_order)]

    def means(self, rule):
        """By what compliance is known."""
        found = [self.checker[rule]] if rule in self.checker else []
        for means, test in self.guidelines.held.get(rule, []):
            if test and test not in self.run_by_ctest:
                self.bad.append(f"{RULES}: {rule}: ctest runs no test {test}")
            found.append(f"{means} ({test})" if test else means)
        return "; ".join(found)

    def status(self, rule):
        """Status and reason."""
        category = self.guidelines.category(rule)
        if rule in self.violated:
            self.bad += self.violated[rule]
            return "violated", "\n".join(self.violated[rule])
        if rule in self.deviations:
            if category == "mandatory":
                self.bad.append(f"{misra_register.REGISTER}: {rule} is mandatory and has a deviation")
            return "deviation", "\n".join(self.deviations[rule])
        if rule in self.not_followed:
            if category != "advisory":
                self.bad.append(f"{misra_register.REGISTER}: {rule} is {category} and is not followed")
            return "not followed", self.not_followed[rule]
        if rule in self.absent:
            return "not applicable", self.absent[rule]
        known = self.means(rule)
        if not known:
            self.bad.append(f"{RULES}: nothing decides {rule}")
            return "undecided", ""
        return "compliant", known

    def rows(self):
        for rule in sorted(self.guidelines.subjects, key=in_order):
            yield rule, self.guidelines.subjects[rule], self.guidelines.category(rule), *self.status(rule)


def result(rows, bad):
    """Figures and tables."""
    count = {status: len([row for row in rows if row[3] == status])
             for status in ("compliant", "not applicable", "deviation", "not followed", "violated", "undecided")}
    deviating = [row for row in rows if row[3] == "deviation" and row[2] == "mandatory"]
    ignored = [row for row in rows if row[3] == "not followed" and row[2] != "advisory"]
    figures = [
        part.figure("rules violated", count["violated"], 0, not count["violated"]),
        part.figure("guidelines that nothing decides", count["undecided"], 0, not count["undecided"]),
        part.figure("deviations from mandatory rules", len(deviating), 0, not deviating),
        part.figure("guidelines not followed that are not advisory", len(ignored), 0, not ignored),
        part.figure("guidelines with a status",
                    f"{len(rows)}: {count['compliant']} compliant, {count['not applicable']} not applicable, "
                    f"{count['deviation']} with a deviation, {count['not followed']} not followed",
                    "all", not bad and len(rows) == sum(count.values())),
    ]
    columns = ("Guideline", "About", "Category", "Status", "By what, or why")
    special = [row for row in rows if row[3] not in ("compliant", "not applicable")]
    return figures, [part.table("Deviations, and what is not followed", columns, special),
                     part.table("All guidelines", columns, rows)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, default=part.ROOT)
    parser.add_argument("--checked", type=Path, required=True, help="what gate.misra wrote with its option --out")
    parser.add_argument("--build", type=Path, default=part.ROOT / "build" / "host", help="the build whose tests count")
    args = part.arguments(parser)
    if not args.checked.is_file():
        sys.exit(f"{args.checked}: no such file; gate.misra writes it")
    checked = json.loads(args.checked.read_text(encoding="utf-8"))
    table = Table(args.root, Guidelines(part.ROOT / RULES), checked, set(ctested.listed(args.build)))
    rows = list(table.rows())
    return part.end(args.out, "misra", "MISRA C:2012", SAYS, *result(rows, table.bad), table.bad)


if __name__ == "__main__":
    sys.exit(main())
