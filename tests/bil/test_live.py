# SPDX-License-Identifier: MIT
"""target.loop.live: `motorsim live` follows the image in the emulator, and shows what the timer of its chip did.

test_live.py IMAGE BOARD CLOCK BIL_MOTOR MOTORSIM: the USART of the image is on a pseudo-terminal, MOTORSIM on its other end commands
the drive; the machine is that of BIL_MOTOR with motor A. It starts, takes a load and has a fault.
"""

import csv
import os
import subprocess
import sys
import tempfile
import tomllib
import tty
import unittest
from pathlib import Path

import machine

IMAGE, BOARD, CLOCK, BIL_MOTOR, MOTORSIM = (Path(argument).resolve() for argument in sys.argv[1:6])

FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))["board"]
TICKS_PER_S = FILE["pwm_frequency_hz"]
HALF_PERIOD = round(FILE["timer_clock_hz"] / TICKS_PER_S / 2)
SCENARIO = "s1_robust"  # motor A
SCRIPT = "speed 600\nrun\n"
LOAD_NM = 2.0
LOAD_TICK = 8000    # 0.8 s: it runs in its loop
FAULT_TICK = 11000
OPEN_PHASE = 1
SHOWN_S = 1.5
LONGEST_TICKS = 40000
AT_ONCE = 4096


class Port(machine.Bench):
    """The bench, whose console is on a pseudo-terminal."""

    def __init__(self):
        self.master, self.port = os.openpty()
        tty.setraw(self.port)
        os.set_blocking(self.master, False)
        self.name = os.ttyname(self.port)
        self.acted = []  # what the timer has been given in each tick
        super().__init__(IMAGE, BOARD, CLOCK, [BIL_MOTOR, SCENARIO, f"board={BOARD}"], instant=False)

    def close(self):
        super().close()
        os.close(self.master)
        os.close(self.port)

    def hear(self):
        usart = self.board.chip.usart
        try:
            os.write(self.master, bytes(usart.said))
        except BlockingIOError:
            pass  # nobody reads: it is lost, as on a line
        usart.said.clear()

    def pass_on(self):
        try:
            self.board.chip.usart.receive(os.read(self.master, AT_ONCE))
        except BlockingIOError:
            pass  # nothing is there

    def tick(self, ticks=1):
        for _ in range(ticks):
            self.pass_on()
            super().tick()
            self.acted.append((self.board.chip.timer.preloaded(), self.gates_on()))


def run(port, folder):
    """What `motorsim live` says, and its exit status."""
    script, said = folder / "script.txt", folder / "said.txt"
    script.write_text(SCRIPT, encoding="utf-8")
    with said.open("w", encoding="utf-8") as out:
        live = subprocess.Popen([MOTORSIM, "live", port.name, "--script", script, "--trace", folder / "trace.csv",
                                 "--for", str(SHOWN_S)], stdout=out, stderr=subprocess.STDOUT)
        begin = len(port.acted)
        while live.poll() is None and len(port.acted) < begin + LONGEST_TICKS:
            port.tick()
            at = len(port.acted) - begin
            port.load_nm = LOAD_NM if at >= LOAD_TICK else 0.0
            port.broken = OPEN_PHASE if at >= FAULT_TICK else 0
        live.kill()
        return said.read_text(encoding="utf-8"), live.wait()


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        port = Port()
        cls.addClassCleanup(port.close)
        with tempfile.TemporaryDirectory() as folder:
            cls.said, cls.status = run(port, Path(folder))
            with open(Path(folder) / "trace.csv", encoding="utf-8", newline="") as trace:
                cls.rows = list(csv.DictReader(trace))
        cls.acted = port.acted

    def test_each_state_is_that_of_the_image_and_no_tick_is_missing(self):
        self.assertEqual(self.status, 0, self.said)
        self.assertNotIn("missing", self.said)
        times = [round(float(row["time_s"]) * TICKS_PER_S) for row in self.rows]
        self.assertEqual(times, list(range(times[0], times[0] + len(times))))
        self.assertGreaterEqual(len(times), SHOWN_S * TICKS_PER_S)

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
