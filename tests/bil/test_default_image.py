# SPDX-License-Identifier: MIT
"""target.default_image: who asks for no motor and no board gets the image of the board as it is sold.

test_default_image.py FOLDER: the build folder of the preset stm32g431, configured without NF_MOTOR, NF_BOARD, NF_TUNING.
"""

import sys
import tomllib
import unittest
from pathlib import Path

import elf

FOLDER = Path(sys.argv[1])
DATA = Path(__file__).resolve().parents[2] / "host_sim"
FLASH = 0x08000000


def called(kind, name):
    """What the file calls itself, and so does an image that is made of it."""
    return tomllib.loads((DATA / f"{kind}s/{name}.toml").read_text(encoding="utf-8"))[kind]["name"]


def flashed(path):
    """The bytes of an image from the start of the flash on."""
    image = bytearray()
    for address, data in sorted(elf.segments(path)):
        start = address - FLASH
        image[start:start + len(data)] = data
    return bytes(image)


class TestDefaultImage(unittest.TestCase):
    def setUp(self):
        self.image = flashed(FOLDER / "neurofoc_g431.elf")

    def test_it_is_for_the_board_as_sold_with_a_motor_of_its_voltage(self):
        name = f"neurofoc: {called('motor', 'outrunner_24v')}, {called('board', 'b_g431b_esc1')}, "
        self.assertIn(name.encode(), self.image)

    def test_nothing_of_another_motor_or_board_is_in_it(self):
        for kind, name in (("motor", "motor_a"), ("board", "g431_bench")):
            self.assertNotIn(called(kind, name).encode(), self.image)

    def test_the_binary_for_programmers_that_want_no_elf_is_the_same(self):
        self.assertEqual((FOLDER / "neurofoc_g431.bin").read_bytes(), self.image)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
