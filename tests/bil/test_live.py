# SPDX-License-Identifier: MIT
"""target.loop.live: `motorsim live` follows the image in the emulator, and shows what the timer of its chip did.

test_live.py IMAGE BOARD CLOCK BIL_MOTOR MOTORSIM: the USART of the image is on a pseudo-terminal, MOTORSIM on its other end commands
the drive; the machine is that of BIL_MOTOR with motor A. It starts, takes a load and has a fault.
"""

import csv
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

from port import ReadPort

IMAGE, BOARD, CLOCK, BIL_MOTOR, MOTORSIM = (Path(argument).resolve() for argument in sys.argv[1:6])

FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))["board"]
TICKS_PER_S = FILE["pwm_frequency_hz"]
HALF_PERIOD = round(FILE["timer_clock_hz"] / TICKS_PER_S / 2)
SCRIPT = b"unlock\nset tuning.command_timeout_s=0\nspeed 600\nrun\n"  # a second of this board is no second of the PC
LAST = b"wait 0.2\n"  # what is shown is up to two segments behind the board
LOAD_NM = 2.0
LOOK_TICKS = 100     # from one look at what is said to the next
LOAD_TICKS = 3000    # behind the begin of RUN
FAULT_TICKS = 5000
END_TICKS = 7000
OPEN_PHASE = 1
PACE = 0.2  # seconds of the board in a second


class WatchedPort(ReadPort):
    """Of this image; remembers what its timer was given."""

    pace = PACE

    def __init__(self):
        self.acted = []  # in each tick
        super().__init__(IMAGE, BOARD, CLOCK, BIL_MOTOR)

    def tick(self, ticks=1):
        for _ in range(ticks):
            super().tick()
            self.acted.append((self.board.chip.timer.preloaded(), self.gates_on()))


class Session:
    """`motorsim live` on a port, and what happens to the motor meanwhile."""

    def __init__(self, port, folder):
        self.port = port
        self.text = folder / "said.txt"
        with self.text.open("wb") as out:
            self.live = subprocess.Popen([MOTORSIM, "live", port.name, "--script", "-", "--trace", folder / "trace.csv",
                                          "--pace", str(PACE)],
                                         stdin=subprocess.PIPE, stdout=out, stderr=subprocess.STDOUT)
        port.reader = self.live
        self.live.stdin.write(SCRIPT)
        self.live.stdin.flush()

    def said(self):
        return self.text.read_text(encoding="utf-8")

    def go_to_run(self):
        while "RUN, speed" not in self.said() and self.live.poll() is None:
            self.port.tick(LOOK_TICKS)

    def all(self):
        """What it says, and its exit status."""
        self.go_to_run()
        self.port.tick(LOAD_TICKS)
        self.port.load_nm = LOAD_NM
        self.port.tick(FAULT_TICKS - LOAD_TICKS)
        self.port.broken = OPEN_PHASE
        self.port.tick(END_TICKS - FAULT_TICKS)
        self.live.stdin.write(LAST)
        self.live.stdin.close()
        while self.live.poll() is None:
            self.port.tick()
        return self.said(), self.live.wait()


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        port = WatchedPort()
        cls.addClassCleanup(port.close)
        with tempfile.TemporaryDirectory() as folder:
            cls.said, cls.status = Session(port, Path(folder)).all()
            if cls.status:
                raise AssertionError(f"exit status {cls.status}: {cls.said}")
            with open(Path(folder) / "trace.csv", encoding="utf-8", newline="") as trace:
                cls.rows = list(csv.DictReader(trace))
        cls.acted = port.acted
        if not cls.rows:
            raise AssertionError(f"nothing was shown:\n{cls.said}")

    def test_each_state_is_that_of_the_image_and_no_tick_is_missing(self):
        self.assertEqual(self.status, 0, self.said)
        self.assertNotIn("missing", self.said)
        times = [round(float(row["time_s"]) * TICKS_PER_S) for row in self.rows]
        self.assertEqual(times, list(range(times[0], times[0] + len(times))))
        self.assertGreaterEqual(len(times), END_TICKS)

    def test_it_shows_start_load_and_fault(self):
        states = [row["state"] for row in self.rows]
        self.assertIn("RUN", states)
        self.assertEqual(states[-1], "FAULT", self.said)
        self.assertNotEqual(self.rows[-1]["fault"], "NONE")
        loaded = [float(row["i_q_estimated_a"]) for row in self.rows if row["state"] == "RUN"]
        self.assertGreater(max(loaded), 2 * LOAD_NM / 3 / 2 / 0.387)  # torque over 3/2 · pole pairs · flux

    def test_what_it_shows_is_what_the_timer_was_given(self):
        for row in self.rows:
            compare, gates = self.acted[round(float(row["time_s"]) * TICKS_PER_S)]
            if gates and row["state"] != "FAULT":
                shown = tuple(round(float(row[f"duty_{phase}"]) * HALF_PERIOD) for phase in "abc")
                self.assertEqual(shown, compare, row["time_s"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
