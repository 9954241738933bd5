# SPDX-License-Identifier: MIT
"""A header of registers against the facts of chips: each macro is compared, made of others that are, or listed.

not_held.toml lists what the facts do not hold: {macro: section of the manual and what it is}.
"""

import tomllib
from collections import Counter

COMPARED = ("address", "offset", "mask", "enable", "shift", "interrupt", "memory", "value")


class Comparison:
    """`counts`: how many comparisons of each kind; `wrong`: one line for each difference or gap."""

    def __init__(self, chips, macros, not_held):
        self.chips, self.macros, self.not_held = chips, macros, not_held
        self.counts, self.wrong = Counter(), []
        for macro in macros.values():
            self._judge(macro)
        self._find_stale()

    def _judge(self, macro):
        found = [] if macro.has_arguments else [(chip, chip.explained(macro.name)) for chip in self.chips]
        is_held = any(facts for _, facts in found)
        listed = macro.name in self.not_held
        if is_held and listed:
            self.wrong.append(f"not_held.toml: {macro.name} is held: {next(f for _, f in found if f)[0].path}")
        elif is_held:
            for chip, facts in found:
                self._compare(macro, chip, facts)
        elif listed:
            self._fit(macro)
        elif macro.parts() and all(part in self.macros for part in macro.parts()):
            self.counts["composed"] += 1
        else:
            self.wrong.append(f"{macro.name} is neither held nor listed: add it to names.toml or to not_held.toml")

    def _compare(self, macro, chip, facts):
        if not facts:
            self.counts["not on this chip"] += 1
        for fact in facts:
            self.counts[fact.what] += 1
            if macro.value != fact.value:
                self.wrong.append(f"{macro.name} is {macro.value:#x}; {chip.name}: {fact.path}: {fact.what} {fact.value:#x}")

    def _fit(self, macro):
        """What is not held but belongs to a field by its name lies within that field."""
        self.counts["listed"] += 1
        for chip in self.chips if macro.value is not None else ():
            for fact in chip.field_of(macro.name):
                self.counts["within a field"] += 1
                if macro.value & ~fact.value:
                    self.wrong.append(f"{macro.name} is {macro.value:#x}, outside of the field; {chip.name}: {fact.path}: {fact.value:#x}")

    def _find_stale(self):
        names = self.chips[0].names
        for name in sorted({*self.not_held, *names.values} - self.macros.keys()):
            table = "not_held.toml" if name in self.not_held else "names.toml, values"
            self.wrong.append(f"{table}: {name} is in the header no more")
        for name in sorted(name for name, what in self.not_held.items() if not what.strip()):
            self.wrong.append(f"not_held.toml: {name} has no section of the manual")

    def report(self):
        counted = ", ".join(f"{self.counts[what]} of {what}" for what in COMPARED)
        return (f"{len(self.macros)} macros, {len(self.chips)} chips: compared: {counted}; {self.counts['composed']} made of others, "
                f"{self.counts['listed']} listed ({self.counts['within a field']} of them seen to lie within their field, on each chip), "
                f"{self.counts['not on this chip']} of things that a chip lacks; {len(self.wrong)} differences")


def listed(path):
    """not_held.toml: {macro: text}, and what the emulator has."""
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    return {name: text for rows in content["header"].values() for name, text in rows.items()}, content["emulator"]
