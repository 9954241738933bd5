# SPDX-License-Identifier: MIT
"""target.loop.own_board: an image for a board and a motor of one's own, whose files lie outside of the project.

test_own_board.py NFCONFIG CLOCK: the board has external amplifiers, so that the chip's own ones are off. cmake is
called in the folder of the two files, by a path relative to it.
"""

import sys
import tempfile
import unittest
from pathlib import Path

import board
from own_image import SHIPPED, build_image, replaced

NFCONFIG, CLOCK = (Path(argument).resolve() for argument in sys.argv[1:3])
MIDDLE = 2048
CALIBRATION_TICKS = 260


def own_files(folder):
    (folder / "mine").mkdir()
    (folder / "mine/motor.toml").write_text(
        replaced(SHIPPED / "motors/motor_a.toml", ('name = "motor A (paper A, table 1)"', 'name = "my motor"')),
        encoding="utf-8")
    (folder / "mine/board.toml").write_text(
        replaced(SHIPPED / "boards/g431_bench.toml", ('name = "STM32G431 with 310 V bench inverter"',
                                                      'name = "my board"'), ("pga_gain = 16", "pga_gain = 1"),
                                                      ('shunt_ground_pins = ["PA3", "PA5", "PB2"]\n', "")),
        encoding="utf-8")


class OwnBoard(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        made = tempfile.TemporaryDirectory()
        cls.addClassCleanup(made.cleanup)
        folder = Path(made.name)
        own_files(folder)
        image = build_image(folder, NFCONFIG, "mine/motor.toml", "mine/board.toml")
        cls.board = board.Board(image, folder / "mine/board.toml", CLOCK)
        cls.bus = round(310 / 450 * 4096)
        cls.board.set_inputs(MIDDLE, MIDDLE, cls.bus)
        cls.board.boot()
        cls.board.tick(CALIBRATION_TICKS)
        cls.greeting = cls.board.said()

    def test_it_is_the_image_of_the_files_that_were_named(self):
        self.assertIn("neurofoc: my motor, my board, any motor", self.greeting)

    def test_with_external_amplifiers_the_chips_own_ones_are_off(self):
        amplifiers = self.board.chip.amplifiers
        self.assertEqual({amplifiers[f"{number}_CSR"] for number in self.board.wiring.amplifiers}, {0})

    def test_the_current_is_that_of_the_shunt(self):
        self.board.set_inputs(MIDDLE + 410, MIDDLE - 205, self.bus)  # of 2048 for 20 A
        self.board.tick(3)
        while self.board.said():  # of the test before: what does not fit beside it is cut
            self.board.tick(3)
        self.board.type("status")
        self.board.tick(3)
        said = self.board.said()
        self.board.set_inputs(MIDDLE, MIDDLE, self.bus)
        self.assertRegex(said, r"\b4\.0\d* ")
        self.assertRegex(said, r"-2\.0\d* ")

    def test_the_comparators_trip_at_the_level_of_the_board_file(self):
        self.board.type("run")
        self.board.take()
        self.board.tick(2)
        for ampere, on in ((18.8, True), (19.2, False)):
            self.board.set_inputs(MIDDLE - round(ampere / 20 * MIDDLE), MIDDLE, self.bus)
            self.assertEqual(self.board.chip.timer.gates_on(), on, f"{ampere} A")
            self.board.set_inputs(MIDDLE, MIDDLE, self.bus)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
