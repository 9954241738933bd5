# SPDX-License-Identifier: MIT
"""target.loop.first_hour: a name plate, a motor and the image as it is flashed; all the rest at the line of `motorsim live`.

test_first_hour.py IMAGE BOARD CLOCK BIL_MOTOR MOTORSIM: the image has the example motor of its board, the machine is another one.
An emulated second of the board takes a core 2.2 to 3 s; the identification is some 20 s of the board. The board is no faster than the
pace that live is told: it stops its motor where nobody is heard for a second, and that second is the board's.
"""

import math
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

from port import ReadPort

IMAGE, BOARD, CLOCK, BIL_MOTOR, MOTORSIM = (Path(argument).resolve() for argument in sys.argv[1:6])
EXAMPLE = "outrunner_24v"
# What is measured, its key, and of how much more the machine has than the example.
SCALES = {"resistance": ("resistance_ohm", 1.6), "inductance_d": ("inductance_d_h", 1.5),
          "flux_linkage": ("flux_linkage_wb", 0.7), "inertia": ("inertia_kg_m2", 2)}
MACHINE = [f"motor={EXAMPLE}", "plant.resistance_scale=1.6", "plant.inductance_scale=1.5", "plant.flux_scale=0.7",
           "plant.inertia_scale=2", "plant.coulomb_friction_nm=0.003"]
PLATE = """[motor]
name = "out of the drawer"
pole_pairs = 7
max_speed_rpm = 5000
continuous_current_a = 15
max_current_a = 30
"""
PACE = 0.2  # seconds of the board in a second


def converse(lines, options=(), flashed=()):
    """A board from its power-up on. What was said to these lines, and what is in its flash afterwards."""
    port = ReadPort(IMAGE, BOARD, CLOCK, BIL_MOTOR, MACHINE, flashed)
    port.pace = PACE
    try:
        live = subprocess.Popen([MOTORSIM, "live", port.name, "--script", "-", "--pace", str(PACE), *options],
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        port.reader = live
        live.stdin.write("\n".join(lines) + "\n")
        live.stdin.close()
        while live.poll() is None:
            port.tick()
        said = live.stdout.read()
        if live.returncode:
            raise AssertionError(f"exit status {live.returncode}:\n{said}")
        return said, port.board.chip.power.flash.content()
    finally:
        port.close()


def in_force(said):
    """The answer to the last `get`. The board says its state at any time, with "board: " or a time in front."""
    lines = said.rpartition("> get\n")[2].splitlines()
    return "\n".join(line for line in lines if not re.match(r"board: |[0-9.]+ s: ", line))


class FirstHour(unittest.TestCase):
    def test_from_a_name_plate_to_a_stored_configuration_and_a_second_board_all_is_done_at_the_line(self):
        with tempfile.TemporaryDirectory() as folder:
            plate, measured, block = (Path(folder) / name for name in ("plate.toml", "measured.toml", "mine.nfb"))
            plate.write_text(PLATE, encoding="utf-8")
            said, flash = converse([f"identify {plate} {measured}", f"adopt {measured}", "store", "get"])
            self.assert_measured(tomllib.loads(measured.read_text(encoding="utf-8")))
            again, _ = converse(["get", "unlock", "set motor.max_speed_rpm=4000 tuning.command_timeout_s=2 observer.kappa=0.02",
                                 f"dump {block}", "get"], ["--motor", measured], flash)
            self.assertIn(in_force(said).strip(), again)
            other, _ = converse([f"load {block}", "get"])
            self.assertEqual(in_force(again), in_force(other))

    def assert_measured(self, found):
        motors = BOARD.parent.parent / "motors"
        example = tomllib.loads((motors / f"{EXAMPLE}.toml").read_text(encoding="utf-8"))["motor"]
        for what, (key, scale) in SCALES.items():
            bars = [found["measured"].get(f"{what}_{kind}_pct", 0) / 100 for kind in ("std", "bound")]
            with self.subTest(what):
                self.assertAlmostEqual(found["motor"][key] / (example[key] * scale), 1, delta=math.hypot(2 * bars[0], bars[1]))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
