# SPDX-License-Identifier: MIT
"""chips.registers: the header of registers against facts of four chips that come from ST's data, not from this project.

test_registers.py COMPILER HEADER [TEST...]. Each macro of the header is compared, made of macros that are, or listed in
not_held.toml with the section of the manual.
"""

import dataclasses
import sys
import tempfile
import unittest
from pathlib import Path

import chip
import compare
import header

COMPILER, HEADER = sys.argv[1], Path(sys.argv[2])
PLANTED = ("address", "offset", "mask", "enable", "shift", "interrupt", "value")


class Registers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.chips = chip.read()
        cls.macros = header.read(COMPILER, HEADER)
        cls.not_held, _ = compare.listed(chip.HERE / "not_held.toml")

    def compared(self, macros, not_held=None):
        return compare.Comparison(self.chips, macros, self.not_held if not_held is None else not_held)

    def held(self):
        """{macro: what it is} of those that the facts hold."""
        found = {name: facts for name in self.macros for one in self.chips if (facts := one.explained(name))}
        return {name: facts[0].what for name, facts in found.items()}


class Header(Registers):
    def test_agrees_with_the_facts_of_each_chip(self):
        comparison = self.compared(self.macros)
        print(comparison.report())
        self.assertEqual(comparison.wrong, [])

    def test_is_compared_in_each_kind_of_thing(self):
        self.assertLessEqual(set(PLANTED), set(self.held().values()))

    def test_names_toml_has_no_row_that_no_chip_needs(self):
        self.compared(self.macros)
        self.assertEqual(self.chips[0].names.unused(), [])


class Planted(Registers):
    """What has to be found."""

    def wrong_with(self, text):
        """The differences of a copy of the header with some lines more."""
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / HEADER.name
            copy.write_text(HEADER.read_text(encoding="utf-8") + text, encoding="utf-8")
            return self.compared(header.read(COMPILER, copy)).wrong

    def test_a_wrong_value_in_the_header_is_found_whatever_it_is(self):
        held = self.held()
        for what in PLANTED:
            with self.subTest(what):
                name = next(name for name in self.macros if held.get(name) == what)
                value = self.macros[name].value ^ 1 << 3
                wrong = self.wrong_with(f"#undef {name}\n#define {name} ({value:#x}UL)\n")
                self.assertGreaterEqual(len(wrong), 1)
                self.assertTrue(all(line.startswith(f"{name} is {value:#x}; stm32g4") for line in wrong), wrong)

    def test_each_macro_that_is_compared_is_found_with_a_bit_that_is_wrong(self):
        for name in self.held():
            changed = dataclasses.replace(self.macros[name], value=self.macros[name].value ^ 2)
            wrong = self.compared({name: changed}, {}).wrong
            self.assertTrue([line for line in wrong if line.startswith(f"{name} is ")], name)

    def test_a_code_outside_of_its_field_is_found(self):
        name = next(name for name in self.not_held if self.chips[0].field_of(name))
        changed = dataclasses.replace(self.macros[name], value=0xFFFFFFFF)
        wrong = self.compared({**self.macros, name: changed}).wrong
        self.assertTrue(wrong and all("outside of the field" in line for line in wrong), wrong)

    def test_a_macro_that_is_neither_held_nor_listed_is_found(self):
        for line in ("#define TIM1_NOTHING (1U)", "#define FLASH_STRANGE(page) ((page) << 3)"):
            (wrong,) = self.wrong_with(f"{line}\n")
            self.assertIn("is neither held nor listed", wrong)

    def test_a_row_of_a_table_that_is_held_or_whose_macro_is_gone_is_found(self):
        held = next(iter(self.held()))
        (wrong,) = self.compared(self.macros, {**self.not_held, held: "RM0440"}).wrong
        self.assertIn(f"not_held.toml: {held} is held", wrong)
        (wrong,) = self.compared(self.macros, {**self.not_held, "GONE": "RM0440"}).wrong
        self.assertEqual(wrong, "not_held.toml: GONE is in the header no more")
        names = self.chips[0].names
        name = next(iter(names.values))
        wrong = self.compared({key: macro for key, macro in self.macros.items() if key != name}).wrong
        self.assertIn(f"names.toml, values: {name} is in the header no more", wrong)

    def test_an_error_of_the_crate_that_is_mended_is_found(self):
        names = chip.Names((chip.HERE / "names.toml").read_text(encoding="utf-8"))
        names.errors = {path: {**error, "crate": "0x80"} for path, error in names.errors.items()}
        with self.assertRaises(chip.WrongTable):
            chip.read(names=names)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
