# SPDX-License-Identifier: MIT
"""The image of the board with a machine behind its registers: that of bil_motor."""

import random
import re
import struct
import subprocess

import board

ORDER = struct.Struct("<8H2d")  # bil_motor.cpp
SEEN = struct.Struct("<4H2I2d")
STEP, KEEP, BACK = range(3)
MIDDLE = 2048
CALIBRATION_TICKS = 260
LONGEST_TICKS = 250_000  # 25 s


class Bench:
    """The image with its machine, and what is wrong with that."""

    def __init__(self, image, board_file, clock, machine, instant=True, flashed=()):
        """`machine`: the command line of bil_motor. `flashed`: what another start has left in the store's pages."""
        self.board = board.Board(image, board_file, clock, flashed=flashed)
        self.board.chip.usart.instant = instant
        self.plant = subprocess.Popen(machine, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.random = random.Random(1)
        self.broken = self.blocked = 0
        self.load_nm = self.noise = 0.0
        self.sees = (0, 1)  # the phases whose currents the sensors a and b see
        self.said = ""
        self.trips = self.most_rpm = 0
        self._look()
        self._measure()
        self.board.boot()
        self.tick(CALIBRATION_TICKS)

    def close(self):
        self.plant.stdin.close()
        self.plant.wait()
        self.plant.stdout.close()

    def _look(self):
        *self.counts, self.trips, _, self.angle_rad, speed = SEEN.unpack(self.plant.stdout.read(SEEN.size))
        self.most_rpm = max(self.most_rpm, abs(speed) * 9.549296586)

    def _order(self, compare=(0, 0, 0), gates=0, act=STEP):
        self.plant.stdin.write(ORDER.pack(*compare, gates, self.broken, self.blocked, act, 0, self.load_nm, 0.0))
        self.plant.stdin.flush()
        self._look()

    def _measure(self):
        phase_a, phase_b, bus, temperature = self.counts
        phases = (phase_a, phase_b, 3 * MIDDLE - phase_a - phase_b)
        a, b = (min(max(phases[phase] + round(self.random.gauss(0, self.noise)), 0), 4095) for phase in self.sees)
        self.board.set_measured(a, b, bus, temperature)

    def gates_on(self):
        return self.board.chip.timer.gates_on()

    def tick(self, ticks=1):
        for _ in range(ticks):
            self._measure()
            self.board.tick()
            self._order(self.board.chip.timer.preloaded(), self.gates_on())
            if self.board.chip.usart.said:
                self.hear()

    def hear(self):
        """What the board has sent."""
        self.said += self.board.chip.usart.heard()

    def go_to(self, words):
        """Until a whole line with these words has been said."""
        for _ in range(LONGEST_TICKS):
            if re.search(rf"{words}[^\n]*\n", self.said):
                return
            self.tick()
        raise AssertionError(f"it has not said \"{words}\":\n{self.said[-1000:]}")

    def keep(self):
        self._order(act=KEEP)

    def back(self):
        self._order(act=BACK)
