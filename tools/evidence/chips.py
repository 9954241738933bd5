# SPDX-License-Identifier: MIT
"""evidence.chips: the files of tests/chips hold what the crate stm32-metapac says of the chips.

The tests that compare the binding and the emulator with these files (chips.*) rest on it. It needs cargo.
"""

import argparse
import sys

import part

sys.path.insert(0, str(part.ROOT / "tools/chips"))

import facts  # noqa: E402

SAYS = ("Memories, interrupts, pins, registers and codes of each chip that the binding serves, as a crate has them that was made from "
        "ST's data by other people. The tests chips.* compare the binding and the emulator with them.")


def compared(names):
    """(chip, number of facts, differences) of each chip that could be asked for, and what is wrong beside."""
    rows, findings = [], []
    try:
        for chip, now in facts.each(names, lambda text: print(text, flush=True)):
            wrong = facts.compared(chip, now)
            rows.append((chip, len(facts.flat(now)), len(wrong)))
            findings += wrong[:facts.SHOWN]
    except facts.Unable as reason:
        findings.append(f"tools/chips/facts.py: {reason}")
    return rows, findings


def result(names, rows):
    """Figures and tables."""
    wrong = sum(row[2] for row in rows)
    return ([part.figure("chips compared", f"{len(rows)} of {len(names)}", "all", len(rows) == len(names)),
             part.figure("facts that differ", wrong, 0, not wrong)],
            [part.table(f"Facts, from {facts.crate()}", ["chip", "facts", "that differ"], rows)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    args = part.arguments(parser)
    names = facts.chips()
    rows, findings = compared(names)
    return part.end(args.out, "chips", "Chips", SAYS, *result(names, rows), findings)


if __name__ == "__main__":
    sys.exit(main())
