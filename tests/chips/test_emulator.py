# SPDX-License-Identifier: MIT
"""chips.emulator: the models of tests/bil against facts of the chips that come from ST's data, not from this project.

Base addresses, offsets, bits that can be written, clocks, the interrupt, and the pins of amplifiers and comparators. No image runs.
"""

import re
import sys
import tomllib
import unittest
from pathlib import Path

import chip
import compare

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bil"))
import analogue  # noqa: E402
import board  # noqa: E402
import registers  # noqa: E402
import wiring  # noqa: E402

BOARDS = sorted((chip.HERE.parents[1] / "host_sim" / "boards").glob("*.toml"))

NUMBERED = re.compile(r"(\d+)_(\w+)")  # a block of several peripherals with one register each: COMP and 1_CSR
WORD = 0xFFFFFFFF


def name_of(block, key):
    """As a header names the register."""
    numbered = NUMBERED.fullmatch(key)
    return f"{block.name}{numbered[1]}_{numbered[2]}" if numbered else f"{block.name}_{key}"


def wrong_addresses(block, one):
    """What the facts of a chip say otherwise of a block's registers."""
    for address, (key, register) in block.by_address.items():
        name = name_of(block, key)
        expected = {fact.value for fact in one.named.get(name, [])}
        if expected != {address}:
            yield f"{name} is at {address:#x}; {one.name}: {', '.join(map(hex, sorted(expected))) or 'no such register'}"


def wrong_bits(block, one):
    """Bits that can be written and do not exist. A register that keeps all bits is a model of none of them."""
    for address, (key, register) in block.by_address.items():
        known = 0
        for there in one.at.get(address, []):
            known |= there.mask
        if register.writable != WORD and register.writable & ~known:
            yield f"{name_of(block, key)} takes {register.writable:#x}; {one.name}: not the bits {register.writable & ~known:#x}"


def models():
    """(facts of its chip, model) of each shipped board with a chip of this family."""
    chips = {one.name: one for one in chip.read()}
    for path in BOARDS:
        hal = tomllib.loads(path.read_text(encoding="utf-8")).get("hal", {})
        if hal.get("chip") in chips:
            wires = wiring.Wiring(hal)
            yield chips[hal["chip"]], board.Chip(wires, board.PIN_FLAG, analogue.Parts(analogue.ideal), 115200, wires.crystal_hz)


class Emulator(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        _, cls.without = compare.listed(chip.HERE / "not_held.toml")
        cls.models = list(models())
        cls.blocks = [(one, block) for one, model in cls.models for block in model.blocks if block.name not in cls.without]

    def test_each_register_is_where_it_is_on_each_chip(self):
        count = sum(len(block.by_address) for _, block in self.blocks)
        wrong = [line for one, block in self.blocks for line in wrong_addresses(block, one)]
        print(f"{count} registers of {len(self.blocks)} blocks, {len(self.models)} boards: {len(wrong)} addresses differ")
        self.assertEqual(wrong, [])

    def test_no_register_takes_bits_that_do_not_exist(self):
        count = sum(register.writable != WORD for _, block in self.blocks for _, register in block.by_address.values())
        wrong = [line for one, block in self.blocks for line in wrong_bits(block, one)]
        print(f"{count} masks, {len(self.models)} boards: {len(wrong)} with bits that do not exist")
        self.assertEqual(wrong, [])

    def test_the_blocks_that_are_no_peripherals_are_there(self):
        for _, model in self.models:
            self.assertLessEqual(set(self.without), {block.name for block in model.blocks})

    def clocked(self):
        """(model, block, peripheral, register and bit of its clock) of each peripheral with one."""
        for one, model in self.models:
            for block in model.blocks:
                peripherals = {there.peripheral for address in block.by_address for there in one.at.get(address, [])}
                for peripheral in sorted(peripherals):
                    if enable := one.enable(peripheral):
                        yield model, block, peripheral, *enable

    def test_a_block_acts_with_the_bit_of_its_clock_and_with_no_other(self):
        count = 0
        for model, block, peripheral, register, mask in self.clocked():
            rcc = model.power.rcc
            enables = [key for key, _ in rcc.by_address.values() if "ENR" in key]
            with self.subTest(chip=model.facts.name, peripheral=peripheral):
                count += 1
                if rcc.register(register).reset & mask:
                    continue  # on after reset, as the flash's: the models leave it so
                for values, acts in (((0, 0), False), ((WORD, WORD & ~mask), False), ((0, mask), True)):
                    for key in enables:
                        rcc[key] = values[0]
                    rcc[register] = values[1]
                    self.assertEqual(bool(block.clocked()), acts)
        print(f"{count} clocks, {len(self.models)} boards")
        self.assertGreater(count, 0)


class Planted(unittest.TestCase):
    """What has to be found."""

    def setUp(self):
        self.one = chip.read()[0]

    def block(self, base, offset, writable):
        return registers.Block("IWDG", base, {"PR": (offset, registers.Register(0, writable))})

    def test_a_wrong_base_or_offset(self):
        self.assertEqual(list(wrong_addresses(self.block(0x40003000, 4, 7), self.one)), [])
        for base, offset in ((0x40003400, 4), (0x40003000, 8)):
            self.assertEqual(len(list(wrong_addresses(self.block(base, offset, 7), self.one))), 1)

    def test_a_bit_that_does_not_exist(self):
        self.assertEqual(list(wrong_bits(self.block(0x40003000, 4, 7), self.one)), [])
        self.assertEqual(len(list(wrong_bits(self.block(0x40003000, 4, 0xF), self.one))), 1)


if __name__ == "__main__":
    unittest.main()
