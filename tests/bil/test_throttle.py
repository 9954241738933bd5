# SPDX-License-Identifier: MIT
"""target.loop.throttle: a potentiometer, servo pulses and DShot turn the motor of the image, without a PC.

test_throttle.py IMAGE BOARD CLOCK BIL_MOTOR NFCONFIG [TEST...]: the image starts with a stored configuration that has the input;
nobody types. A few runs of what draws, or many if they are asked for. An emulated second of the board takes a core 2.2 to 3 s.
"""

import binascii
import random
import struct
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import digital
import machine
import many_runs
from flash import store_of
from wiring import Wiring

IMAGE, BOARD, CLOCK, BIL_MOTOR, NFCONFIG = (Path(argument).resolve() for argument in sys.argv[1:6])
FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))
WIRING = Wiring(FILE["hal"])
TICKS_PER_S = FILE["board"]["pwm_frequency_hz"]
MOTOR = "outrunner_24v"
MAX_RPM = tomllib.loads((BOARD.parent.parent / "motors" / f"{MOTOR}.toml").read_text(encoding="utf-8"))["motor"]["max_speed_rpm"]
STAMPS = 192 * 8        # bytes of a slot of the store before its stamp, store.h
ARM_S, TIMEOUT_S = 0.2, 0.1
SETTINGS = {"input.arm_s": ARM_S, "input.timeout_s": TIMEOUT_S, "input.slope_pct_s": 1000}
LATE_S = 0.07           # of the conversion of a throttle and of its low-pass, and of three servo pulses
RAMP_S = 1.5            # from any speed of these runs to open gates, with a start that is under way
THROTTLE = 0.4
STEADY = 0.03           # of the largest speed: the demand's steps, the drive's own error, the ripple
RUNS = 200 if many_runs.are_asked() else 1
FRAMES_HZ = 1000


def stored(settings):
    """The store's pages with a configuration that has these settings."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.nfb"
        words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        subprocess.run([NFCONFIG, "block", "--motor", MOTOR, "--board", BOARD, "--tuning", "any", *words, "-o", file], check=True)
        data = file.read_bytes()
    stamp = struct.pack("<I", 2)
    stamp += struct.pack("<I", binascii.crc32(stamp + data[-4:]))
    address = store_of(WIRING.facts)
    return [(address, data), (address + STAMPS, stamp)]


class Bench(machine.Bench):
    """The board with its motor, and somebody who moves the throttle: `wanted`, 0 to 1, or None when its wire is cut."""

    kind = ""

    def __init__(self, wanted=0.0, **settings):
        self.wanted = wanted
        self.next = 0
        super().__init__(IMAGE, BOARD, CLOCK, [BIL_MOTOR, "s1_robust", f"board={BOARD}", f"motor={MOTOR}"],
                         flashed=stored(SETTINGS | {"input.kind": self.kind} | settings))

    def _look(self):
        self.most_rpm = 0
        super()._look()
        self.rpm = self.most_rpm  # of this tick

    def tick(self, ticks=1):
        for _ in range(ticks):
            self.feed()
            super().tick()

    def wait(self, seconds):
        self.tick(round(seconds * TICKS_PER_S))

    def until(self, condition, seconds):
        """How long it takes, or None."""
        for tick in range(round(seconds * TICKS_PER_S)):
            if condition():
                return tick / TICKS_PER_S
            self.tick()
        return None


class Potentiometer(Bench):
    kind = "voltage"
    reason = "its voltage is below its range"

    def feed(self):
        share = 0 if self.wanted is None else 0.05 + 0.9 * self.wanted
        self.board.chip.set_pins(**{WIRING.throttle: round(share * 4095)})


class Pulses(Bench):
    reason = "no signal"

    def send(self, pulses):
        """(start, width) in seconds from now."""
        now = self.board.chip.now
        self.board.chip.signals.play(WIRING.pulse.name, [
            (now + round(at * digital.CLOCK_HZ), level) for start, width in pulses for at, level in ((start, 1), (start + width, 0))])

    def feed(self):
        self.next -= 1
        if self.next < 0:
            self.next += round(TICKS_PER_S / self.rate_hz)
            if self.wanted is not None:
                self.send(self.command())


class Receiver(Pulses):
    """A servo tester: 1 to 2 ms, 50 Hz."""

    kind = "rc_pulse"
    rate_hz = 50

    def command(self):
        return [(1e-4, 1e-3 + 1e-3 * self.wanted)]


class FlightController(Pulses):
    """DShot300."""

    kind = "dshot"
    rate_hz = FRAMES_HZ
    bit_s = 1 / 300e3

    def command(self):
        data = (48 + round(1999 * self.wanted) if self.wanted else 0) << 1
        frame = data << 4 | (data ^ data >> 4 ^ data >> 8) & 0xF
        return [(1e-5 + k * self.bit_s, (0.75 if frame >> 15 - k & 1 else 0.375) * self.bit_s) for k in range(16)]


class Case(unittest.TestCase):
    def start(self, of, **settings):
        bench = of(**settings)
        self.addCleanup(bench.close)
        return bench

    def run_up(self, bench):
        """Seen at rest, then moved."""
        bench.wait(ARM_S + 0.2)
        self.assertFalse(bench.gates_on(), bench.said)
        bench.wanted = THROTTLE
        self.assertIsNotNone(bench.until(lambda: "RUN, speed" in bench.said, 4), bench.said)

    def assert_ends(self, bench, seconds):
        """With open gates, in time, and without a fault."""
        self.assertIsNotNone(bench.until(lambda: not bench.gates_on(), seconds), bench.said)
        bench.wait(0.01)
        self.assertNotIn("FAULT", bench.said)

    def assert_turns_and_is_lost(self, of):
        bench = self.start(of)
        self.run_up(bench)
        bench.wait(0.5)
        share = (THROTTLE - 0.03) / 0.97  # behind the dead band
        bench.board.type("status")
        self.assertIn("by input, input: runs the motor", bench.board.said() + bench.said)
        self.assertLess(abs(bench.rpm / MAX_RPM - share), STEADY, bench.said)
        bench.wanted = None
        told = bench.until(lambda: f"the input is lost: {bench.reason}: the drive stops" in bench.said, TIMEOUT_S + LATE_S)
        self.assertIsNotNone(told, bench.said)
        self.assert_ends(bench, RAMP_S)
        bench.wanted = THROTTLE
        bench.wait(ARM_S + 0.2)
        self.assertFalse(bench.gates_on(), bench.said)


class Potentiometers(Case):
    def test_a_potentiometer_turns_the_motor_and_an_open_wire_stops_it(self):
        self.assert_turns_and_is_lost(Potentiometer)


class Throttles(Case):
    def test_servo_pulses_turn_the_motor_and_a_receiver_that_is_off_stops_it(self):
        self.assert_turns_and_is_lost(Receiver)

    def test_dshot_turns_the_motor_and_a_flight_controller_that_is_off_stops_it(self):
        self.assert_turns_and_is_lost(FlightController)

    def test_a_throttle_that_is_high_at_power_up_starts_nothing(self):
        for of in (Potentiometer, Receiver, FlightController):
            bench = self.start(of, wanted=THROTTLE)
            bench.wait(ARM_S + 0.3)
            self.assertFalse(bench.gates_on(), bench.said)
            self.assertNotIn("RUN", bench.said)

    def test_lost_at_random_instants_it_stops_in_time(self):
        """From the start on, whatever the drive is doing then."""
        for seed in range(RUNS):
            draw = random.Random(seed)
            of = draw.choice((Potentiometer, Receiver, FlightController))
            with self.subTest(seed=seed, kind=of.kind):
                bench = self.start(of)
                bench.wait(ARM_S + 0.2)
                bench.wanted = THROTTLE
                bench.wait(draw.uniform(0.25, 1.5))
                was_on = bench.gates_on()
                bench.wanted = None
                bench.wait(TIMEOUT_S + LATE_S)
                if was_on:
                    self.assertIn(bench.reason, bench.said)
                self.assert_ends(bench, RAMP_S)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[6:]])
