# SPDX-License-Identifier: MIT
"""target.default_image: who asks for no motor and no board gets the image of the board as it is sold, and in it what the
simulator runs and certifies.

test_default_image.py FOLDER MOTORSIM NFCONFIG; FOLDER is the build folder of the preset stm32g4, configured without
NF_MOTOR, NF_BOARD, NF_TUNING.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import elf

FOLDER = Path(sys.argv[1])
DATA = Path(__file__).resolve().parents[2] / "host_sim"
MOTORSIM, NFCONFIG = sys.argv[2:4]
MOTOR, BOARD = "outrunner_24v", "b_g431b_esc1"
DEFAULT = "any"
FLASH = 0x08000000
BEFORE_CONFIGURATION = 4 * (3 + 1 + 1 + 3) + 96  # bytes of a block, as docs/stored_configuration.md lists them
CRC = 4


def called(kind, name):
    """What the file calls itself, and so does an image that is made of it."""
    return tomllib.loads((DATA / f"{kind}s/{name}.toml").read_text(encoding="utf-8"))[kind]["name"]


def said(command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def flashed(path):
    """The bytes of an image from the start of the flash on."""
    image = bytearray()
    for address, data in sorted(elf.segments(path)):
        start = address - FLASH
        image[start:start + len(data)] = data
    return bytes(image)


class TestDefaultImage(unittest.TestCase):
    def setUp(self):
        self.image = flashed(FOLDER / "neurofoc_g4.elf")

    def test_it_is_for_the_board_as_sold_with_a_motor_of_its_voltage_and_the_default_tuning(self):
        name = f"neurofoc: {called('motor', MOTOR)}, {called('board', BOARD)}, {called('tuning', DEFAULT)}"
        self.assertIn(name.encode(), self.image)

    def test_its_configuration_is_what_nfconfig_makes_of_motor_and_board_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "x.nfb"
            said([NFCONFIG, "block", "--motor", MOTOR, "--board", BOARD, "-o", str(file)])
            self.assertTrue(file.read_bytes()[BEFORE_CONFIGURATION:-CRC] in self.image)  # neither is to be printed

    def test_the_simulator_runs_and_certifies_the_same_tuning_unless_asked_for_another(self):
        machine = ["--motor", MOTOR, "--board", BOARD]
        self.assertIn(f"{called('motor', MOTOR)}, tuning {called('tuning', DEFAULT)}, ",
                      said([MOTORSIM, "run", "any", *machine]))
        certificate = json.loads(said([MOTORSIM, "certify", MOTOR, "--board", BOARD, "--runs", "1", "--json", "-"]))
        self.assertEqual(list(certificate["tunings"]), [DEFAULT])
        self.assertIn(f", tuning {called('tuning', DEFAULT)}: holds ", said([NFCONFIG, "alike", *machine]))

    def test_nothing_of_another_motor_or_board_is_in_it(self):
        for kind, name in (("motor", "motor_a"), ("board", "g431_bench")):
            self.assertNotIn(called(kind, name).encode(), self.image)

    def test_the_binary_for_programmers_that_want_no_elf_is_the_same(self):
        self.assertEqual((FOLDER / "neurofoc_g4.bin").read_bytes(), self.image)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
