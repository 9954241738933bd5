# SPDX-License-Identifier: MIT
"""target.loop.hall_identify: the image learns the order and the edges of Hall signals at its pins.

test_hall_identify.py BOARD CLOCK BIL_MOTOR MOTORSIM NFCONFIG [TEST...]: as test_identify.py, on a board with pins for Hall sensors.
One identification takes a core a minute.
"""

import json
import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import machine
from own_image import SHIPPED, build_image, replaced

BOARD, CLOCK, BIL_MOTOR, MOTORSIM, NFCONFIG = (Path(argument).resolve() for argument in sys.argv[1:6])
SCENARIO, POLE_PAIRS = "s1_robust", 2
SENSORS = ((47.0, 171.0), (281.0, 186.0), (170.0, 177.0))  # middle and width of the high part, °, of the signals 1 to 3
HYSTERESIS_DEG = 3.0
PINS = ("PB6", "PB7", "PB8")
PLATE = """[motor]
name = "motor A, its name plate"
pole_pairs = 2
max_speed_rpm = 2000
max_current_a = 10
continuous_current_a = 8.4

[sensor]
kind = "hall"
"""


def apart(a, b):
    return math.remainder(a - b, 360)


def edges():
    """{pattern from the edge on: its angle}."""
    found = {}
    for middle, width in SENSORS:
        for at in (middle - width / 2, middle + width / 2):
            pattern = sum(1 << bit for bit, (m, w) in enumerate(SENSORS) if abs(apart(at + 1, m)) < w / 2)
            found[pattern] = at % 360
    return found


class Bench(machine.Bench):
    """With Hall sensors at the pins of the board."""

    levels = 0

    def _measure(self):
        super()._measure()
        for bit, (pin, (middle, width)) in enumerate(zip(PINS, SENSORS)):
            high = self.levels >> bit & 1
            half = width / 2 + (HYSTERESIS_DEG if high else -HYSTERESIS_DEG)
            now = abs(apart(math.degrees(self.angle_rad) * POLE_PAIRS, middle)) < half
            self.levels ^= (now ^ high) << bit
            self.board.chip.signals.set(pin, int(now))


class Learns(unittest.TestCase):
    def test_the_edges_are_within_their_bars_and_in_the_motor_file(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            board, plate, tuning = (folder / f"{part}.toml" for part in ("board", "plate", "tuning"))
            board.write_text(replaced(BOARD, ("[hal]", f"[hal]\nhall_pins = {json.dumps(PINS)}")), encoding="utf-8")
            plate.write_text(PLATE, encoding="utf-8")
            tuning.write_text((SHIPPED / "tunings/any.toml").read_text(encoding="utf-8") +
                              "\n[drive]\nangle_source = \"both\"\n", encoding="utf-8")
            motor = folder / "motor.toml"
            motor.write_text((SHIPPED / "motors/motor_a.toml").read_text(encoding="utf-8") +
                             "\n[sensor]\nkind = \"hall\"\n", encoding="utf-8")
            image = build_image(folder, NFCONFIG, motor, board, tuning)
            bench = Bench(image, board, CLOCK, [BIL_MOTOR, SCENARIO, f"board={board}"])
            self.addCleanup(bench.close)
            bench.board.type("identify")
            bench.go_to("backwards, then forwards")
            bench.go_to("identify (done|refused)")
            log, out, file = (folder / part for part in ("console.log", "found.json", "found.toml"))
            log.write_text(bench.said, newline="")
            run = subprocess.run([MOTORSIM, "identify", "--records", log, "--motor", plate, "--board", board, "--json", out,
                                  "-o", file], capture_output=True, text=True, check=False)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            found = json.loads(out.read_text())
            self.assertIn("hall_patterns", file.read_text(encoding="utf-8"))
        truth = edges()
        self.assertEqual({edge["pattern"] for edge in found["halls"]["edges_deg"]}, set(truth))
        for edge in found["halls"]["edges_deg"]:
            with self.subTest(edge):
                self.assertLessEqual(abs(apart(edge["value"], truth[edge["pattern"]])), edge["bar"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[6:]])
