# SPDX-License-Identifier: MIT
"""target.loop.commanded: scenarios of the simulator, and the image is commanded through each of its sources.

test_commanded.py IMAGE BOARD CLOCK BIL_PLANT NFCONFIG GDB [TEST...]: a potentiometer, a receiver, a flight controller, a PC
and a person command the same steps. The plant, and the judgement, are those of bil_plant, whose drive is commanded as the image's
is by its background, and has to demand the same in each tick.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import scenario
from board import Board
from image_mailbox import Mailbox
from link import SteadyLink
from stored import stored
from throttles import FlightController, Potentiometer, Receiver
from wiring import Wiring

HERE = Path(__file__).resolve().parent
IMAGE, BOARD, CLOCK, BIL_PLANT, NFCONFIG, GDB = (Path(argument).resolve() for argument in sys.argv[1:7])
FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))
FACTS = Wiring(FILE["hal"]).facts
TICKS_PER_S = FILE["board"]["pwm_frequency_hz"]
MOTOR = "outrunner_24v"
PLATE = tomllib.loads((BOARD.parent.parent / "motors" / f"{MOTOR}.toml").read_text(encoding="utf-8"))["motor"]
MAX_RPM, RATED_RPM = PLATE["max_speed_rpm"], PLATE["rated_speed_rpm"]
DEAD_BAND = 0.03  # input.dead_band_pct
SLOPE_PER_S = 2   # input.slope_pct_s, of the largest speed
SLOW_S = 10 / TICKS_PER_S  # a command is taken once in a slow period
BAND = 0.02       # of a step: settled, metrics.h
SETTINGS = {"input.arm_s": 0.2}
RUN, POSITION = 1, 1
# From the throttle's move to its demand: two conversions and the low-pass to within the band, ln(1/0.02) of 10 ms; the period that
# is under way, and the second good pulse, which the median lets pass; likewise of frames.
LATE_S = {Potentiometer: 256 / TICKS_PER_S + 0.04, Receiver: 3 / 50, FlightController: 3 / 1000}
MESSAGE_S = 1e-3   # a question of the link at 921600 baud, and the answer before it
SETTLES_S = 0.04   # a step of 4/9 of rated speed that a person types: the speed loop and the ramp, found 0.037
SPREAD_RPM = 2     # the rotor's angle at a step, and the noise, move a figure by so much; found 1
TRUNCATIONS = 5    # of Q15, towards zero: range, dead band, curve, share, speed


class Typist:
    """At the console."""

    kind = None

    def __init__(self, board):
        self.board, self.asked, self.left = board, (0, 0), b""

    def feed(self, speed_rpm, target, mode):
        asked = (speed_rpm, int(speed_rpm != 0))
        if asked != self.asked:
            self.left += f"speed {speed_rpm}\r".encode() + (b"run\r" if self.asked[1] == 0 else b"\r")
            self.asked = asked
        if self.left and self.board.core.asleep:
            self.left = self.board.send_at_once(self.left)


class Computer:
    """By the link."""

    kind = None

    def __init__(self, board):
        self.link = SteadyLink(board)

    def feed(self, speed_rpm, target, mode):
        runs = RUN if target or mode == POSITION else 0
        self.link.wanted = (runs, mode, target)
        self.link.feed()


class Thrower:
    """With a throttle of throttles.py."""

    def __init__(self, of):
        self.of, self.kind = of, of.kind

    def __call__(self, board):
        self.throttle = self.of(board, TICKS_PER_S)
        return self

    def feed(self, speed_rpm, target, mode):
        share = speed_rpm / MAX_RPM
        self.throttle.wanted = DEAD_BAND + (1 - DEAD_BAND) * share if share else 0
        self.throttle.feed()


class Lap:
    """What came of a scenario. The figures are those of `motorsim run --json`."""

    def __init__(self, name, source, parts="ideal"):
        made = Thrower(source) if source in LATE_S else source
        flashed = stored(NFCONFIG, FACTS, MOTOR, BOARD, "any", SETTINGS | {"input.kind": made.kind}) if made.kind else ()
        self.board = Board(IMAGE, BOARD, CLOCK, flashed=flashed, choose=scenario.PARTS[parts], kept=scenario.COLD)
        self.source, self.mailbox = made(self.board), Mailbox(self.board, IMAGE, GDB)
        self.missed_rpm = 0.0
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "figures.json"
            with subprocess.Popen([BIL_PLANT, HERE / f"{name}.toml", scenario.imperfections(self.board, parts, folder), "--json", file,
                                   f"board={BOARD}"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE) as plant:
                self.loop(plant, spikes=parts != "ideal")
                self.told = plant.stderr.read().decode()
            assert file.exists(), f"{self.told}\n{self.board.said()}\n{self.mailbox.command()} {self.board.ticks}"
            self.figures = json.loads(file.read_text(encoding="utf-8"))

    def commanded(self):
        """After a tick: what the source does then the background has posted before the next one."""
        self.source.feed(*self.wanted)
        return (*self.mailbox.command(), 1)

    def loop(self, plant, spikes):
        ticks = 0
        while record := plant.stdout.read(scenario.ASKED.size):
            asked = scenario.ASKED.unpack(record)
            if ticks == 0:
                self.board.set_measured(*asked[:scenario.MEASURED])
                self.board.boot()
            assert self.board.ticks == ticks, f"a tick came upon the background before tick {ticks}: it was not the plant's"
            self.wanted = asked[-3:]
            scenario.answer(plant, self.board, asked, spikes, self.commanded)
            ticks += 1
        self.compare(*asked[-3:])

    def compare(self, speed_rpm, target, mode):
        """What the image was commanded last with what was wanted."""
        if mode != POSITION:
            self.missed_rpm = speed_rpm * (self.mailbox.command()[0] / target - 1)


def resolution_rpm(of):
    """Of a throttle: a step of it, and what the firmware cuts off."""
    return MAX_RPM / (1 - DEAD_BAND) / of.STEPS + TRUNCATIONS / 32767 * MAX_RPM


class Case(unittest.TestCase):
    def assert_is_commanded(self, lap, of):
        self.assertTrue(lap.figures["accepted"], lap.told)
        self.assertLessEqual(abs(lap.missed_rpm), resolution_rpm(of))

    def assert_settles(self, lap, of, settles_s, step_rpm):
        """As fast as the demand's slope lets it, and no faster."""
        slope_s = step_rpm / MAX_RPM / SLOPE_PER_S
        self.assertGreaterEqual(lap.figures["settling_time_s"], (1 - BAND) * slope_s)
        self.assertLessEqual(lap.figures["settling_time_s"], slope_s + LATE_S[of] + settles_s)


S1_STEP_RPM = RATED_RPM * 800 / 1800


class Servo(Case):
    def test_s1_by_servo_pulses(self):
        lap = Lap("esc1_s1", Receiver)
        self.assert_is_commanded(lap, Receiver)
        self.assert_settles(lap, Receiver, SETTLES_S, S1_STEP_RPM)


class Table(Case):
    """Each source beside a person at the console."""

    def laps(self, name, lowest_rpm):
        """(source, lap, console's lap). A settled error is a share of the command, the lowest one at most."""
        console = Lap(name, Typist)
        self.assertTrue(console.figures["accepted"], console.told)
        show(name, "console", console)
        for of in (Computer, *LATE_S):
            with self.subTest(name=name, source=of.__name__):
                lap = Lap(name, of)
                show(name, of.__name__, lap)
                missed = 0 if of is Computer else resolution_rpm(of)
                self.assertTrue(lap.figures["accepted"], lap.told)
                self.assertLessEqual(abs(lap.missed_rpm), missed)
                self.assertLessEqual(lap.figures["command_error_settled_pct"],
                                     console.figures["command_error_settled_pct"] + 100 * (missed + SPREAD_RPM) / lowest_rpm)
                yield of, lap, console

    def test_s1(self):
        for of, lap, console in self.laps("esc1_s1", RATED_RPM * 1000 / 1800):
            settles_s = console.figures["settling_time_s"]
            if of is Computer:
                self.assertAlmostEqual(lap.figures["settling_time_s"], settles_s, delta=SLOW_S + MESSAGE_S)
            else:
                self.assert_settles(lap, of, settles_s, S1_STEP_RPM)

    def test_s2(self):
        for of, lap, console in self.laps("esc1_s2", RATED_RPM):
            missed = 0 if of is Computer else resolution_rpm(of)
            self.assertAlmostEqual(lap.figures["speed_dip_rpm"], console.figures["speed_dip_rpm"], delta=missed + SPREAD_RPM)
            self.assertAlmostEqual(lap.figures["recovery_time_s"], console.figures["recovery_time_s"], delta=SLOW_S)

    def test_s3_by_the_link(self):
        lap = Lap("esc1_s3", Computer)
        show("esc1_s3", "Computer", lap)
        self.assertTrue(lap.figures["accepted"], lap.told)


SHOWN = ("speed_error_max_pct", "command_error_settled_pct", "settling_time_s", "speed_dip_rpm", "recovery_time_s", "angle_error_max_deg",
         "position_error_final_rad")


def show(name, source, lap):
    print(name, source, f"missed {lap.missed_rpm:.2f} rpm", *(f"{key} {lap.figures[key]:.4g}" for key in SHOWN if lap.figures[key] is not None),
          flush=True)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[7:]])
