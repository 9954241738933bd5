# SPDX-License-Identifier: MIT
"""evidence.board: the tests in the emulator take each branch of the board's own code both ways.

Of what of hal/stm32g4 no PC runs (evidence.coverage has the rest), in the image as it is flashed: each conditional branch
and each `it` of its machine code that a line of these files makes, each copy of what was inlined by itself. The loop tests
record which way each goes (tests/bil/decisions.py). The compiler makes a branch of its own of each condition of && and ||
that it does not merge, so both ways of each are condition and decision coverage; as a condition behind one that decides is
not looked at, each condition then has been seen to decide, which is MC/DC by masking. It is not shown for what the compiler
has merged into arithmetic or has found to be constant: that has no branch.

What cannot go both ways stands in tests/evidence/board_justified.toml with its reason; one that nothing needs is a finding.
"""

import argparse
import json
import sys
import tomllib
from collections import Counter
from pathlib import Path

import part

sys.path.insert(0, str(part.ROOT / "tests" / "bil"))
import decisions  # noqa: E402

REGISTER = Path("tests/evidence/board_justified.toml")
KEYS = {"file", "function", "text", "caller", "way", "reason"}


def counts(image, records):
    """How often each decision went each way, and what is wrong with the records."""
    print_, total, bad = decisions.fingerprint(image), Counter(), []
    for path in records:
        found = json.loads(path.read_text(encoding="utf-8")).get(print_) if path.is_file() else None
        if found is None:
            bad.append(f"{path.name}: no record of this image; its test of target.loop writes it")
        for address, ways in (found or {}).items():
            for way, count in enumerate(ways):
                total[int(address, 16), way] += count
    return total, bad


def text_at(root, file, line):
    return " ".join((root / file).read_text(encoding="utf-8").splitlines()[line - 1].split())


def gaps(listed, total, root):
    """(key of the register, line, address) of each way that nothing went."""
    for decision in listed:
        (function, file, line), *callers = decision.where
        for way in (0, 1):
            if not total[decision.address, way]:
                caller = f"{callers[0][0]}: {text_at(root, *callers[0][1:])}" if callers else ""
                name = "never" if way else "always"
                yield (file, function, text_at(root, file, line), caller, name), line, decision


def justified(register):
    entries, bad = {}, []
    for entry in tomllib.loads(register.read_text(encoding="utf-8")).get("justified", []):
        if set(entry) != KEYS or not entry["reason"].strip():
            bad.append(f"{REGISTER}: {entry}: an entry has {', '.join(sorted(KEYS))}")
            continue
        key = tuple(entry[name] for name in ("file", "function", "text", "caller", "way"))
        if key in entries:
            bad.append(f"{REGISTER}: {entry['file']} ({entry['function']}): '{entry['text']}' stands there twice")
        entries[key] = entry["reason"]
    return entries, bad


def judge(listed, total, root, register):
    """The findings, the reasons that are used, and how many ways they excuse by file."""
    reasons, bad = justified(register)
    used, excused = set(), Counter()
    for key, line, decision in gaps(listed, total, root):
        file, function, text, caller, way = key
        condition = (*decisions.CONDITIONS, "zero", "not zero")[decision.condition]
        if key in reasons:
            used.add(key)
            excused[file] += 1
        else:
            bad.append(f"{file}:{line}: {function}{caller and f', in {caller}'}: '{text}': the branch at "
                       f"{decision.address:#x} on '{condition}' is {way} taken")
    bad += [f"{REGISTER}: {key[0]} ({key[1]}): '{key[2]}' needs no justification" for key in reasons if key not in used]
    return bad, {key: reasons[key] for key in sorted(used)}, excused


def report(listed, total, excused):
    whole, gone = Counter(), Counter()
    for decision in listed:
        file = decision.where[0][1]
        whole[file] += 2
        gone[file] += sum(total[decision.address, way] > 0 for way in (0, 1))
    ways, all_ways = sum(gone.values()) + sum(excused.values()), sum(whole.values())
    figures = [part.figure("ways of the branches of the board's code taken or justified", f"{ways} of {all_ways}", "all",
                           0 < ways == all_ways)]
    return figures, [[file, f"{gone[file]} of {whole[file]}", excused[file]] for file in sorted(whole)]


SAYS = ("The board's own code that no PC runs, in the image as it is flashed and in an emulator: its tests take each "
        "conditional branch of the machine code both ways. The compiler makes a branch of each condition that it does not "
        "merge or find constant; of those this is condition and decision coverage, and MC/DC by masking.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--image", type=Path, required=True)
    parser.add_argument("records", type=Path, nargs="+", help="what the tests of target.loop have recorded")
    args = part.arguments(parser)
    root = part.ROOT
    listed = decisions.listed(args.image)
    total, bad = counts(args.image, args.records)
    wrong, reasons, excused = judge(listed, total, root, root / REGISTER)
    figures, rows = report(listed, total, excused)
    tables = [part.table("Ways taken, by file", ["file", "ways", "justified"], rows)]
    if reasons:
        tables.append(part.table("Justified", ["file", "function", "text", "called by", "way", "reason"],
                                 [[*key, reason] for key, reason in reasons.items()]))
    return part.end(args.out, "board", "Branches of the board's code", SAYS, figures, tables, bad + wrong)


if __name__ == "__main__":
    sys.exit(main())
