# SPDX-License-Identifier: MIT
"""target.loop.throttle: a potentiometer, servo pulses and DShot turn the motor of the image, without a PC.

test_throttle.py IMAGE BOARD CLOCK BIL_MOTOR NFCONFIG [TEST...]: the image starts with a stored configuration that has the input;
nobody types. A few runs of what draws, or many if they are asked for. An emulated second of the board takes a core 2.2 to 3 s.
"""

import random
import sys
import tomllib
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import machine
import many_runs
from board import Board
from copies import in_a_copy
from stored import stored
from throttles import ALL, FlightController, Potentiometer, Receiver
from wiring import Wiring

IMAGE, BOARD, CLOCK, BIL_MOTOR, NFCONFIG = (Path(argument).resolve() for argument in sys.argv[1:6])
FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))
WIRING = Wiring(FILE["hal"])
TICKS_PER_S = FILE["board"]["pwm_frequency_hz"]
MOTOR = "outrunner_24v"
MAX_RPM = tomllib.loads((BOARD.parent.parent / "motors" / f"{MOTOR}.toml").read_text(encoding="utf-8"))["motor"]["max_speed_rpm"]
ARM_S, TIMEOUT_S = 0.2, 0.1
SETTINGS = {"input.arm_s": ARM_S, "input.timeout_s": TIMEOUT_S, "input.slope_pct_s": 1000}
LATE_S = 0.07           # of the conversion of a throttle and of its low-pass, and of three servo pulses
RAMP_S = 1.5            # from any speed of these runs to open gates, with a start that is under way
THROTTLE = 0.4
STEADY = 0.03           # of the largest speed: the demand's steps, the drive's own error, the ripple
RUNS = many_runs.of(1, 20, 200)
DISTURBANCES = many_runs.of(3, 20, 200)
MIDDLE, BUS = 2048, round(FILE["board"]["bus_nominal_v"] / FILE["board"]["bus_full_scale_v"] * 4096)


class Bench(machine.Bench):
    """The board with its motor, and somebody who moves the throttle (throttles.py)."""

    def __init__(self, of, wanted=0.0, **settings):
        self.of, self.first, self.throttle = of, wanted, None
        super().__init__(IMAGE, BOARD, CLOCK, [BIL_MOTOR, "s1_robust", f"board={BOARD}", f"motor={MOTOR}"],
                         flashed=stored(NFCONFIG, WIRING.facts, MOTOR, BOARD, "any", SETTINGS | {"input.kind": of.kind} | settings))

    @property
    def wanted(self):
        return self.throttle.wanted

    @wanted.setter
    def wanted(self, wanted):
        self.throttle.wanted = wanted

    def _look(self):
        self.most_rpm = 0
        super()._look()
        self.rpm = self.most_rpm  # of this tick

    def tick(self, ticks=1):
        if self.throttle is None:
            self.throttle = self.of(self.board, TICKS_PER_S)
            self.wanted = self.first
        for _ in range(ticks):
            self.throttle.feed()
            super().tick()

    def lose(self, how):
        self.throttle.lost = how

    def wait(self, seconds):
        self.tick(round(seconds * TICKS_PER_S))

    def until(self, condition, seconds):
        """How long it takes, or None."""
        for tick in range(round(seconds * TICKS_PER_S)):
            if condition():
                return tick / TICKS_PER_S
            self.tick()
        return None


class Case(unittest.TestCase):
    def start(self, of, **settings):
        bench = Bench(of, **settings)
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
        bench.lose(of.LOSSES[0])
        told = bench.until(lambda: f"the input is lost: {of.REASONS[0]}: the drive stops" in bench.said, TIMEOUT_S + LATE_S)
        self.assertIsNotNone(told, bench.said)
        self.assert_ends(bench, RAMP_S)
        bench.lose(None)
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
        for of in ALL:
            bench = self.start(of, wanted=THROTTLE)
            bench.wait(ARM_S + 0.3)
            self.assertFalse(bench.gates_on(), bench.said)
            self.assertNotIn("RUN", bench.said)

    def test_lost_at_random_instants_it_stops_in_time(self):
        """From before the start on, whatever the drive is doing then; each loss goes on from the same run."""
        for of in ALL:
            draw = random.Random(of.kind)
            bench = self.start(of)
            bench.board.chip.usart.instant = True
            bench.wait(ARM_S + 0.2)
            bench.wanted = THROTTLE
            now = driven = 0
            for at in sorted(draw.uniform(0, 1.5) for _ in range(RUNS)):
                bench.wait(at - now)
                now = at
                driven += bench.gates_on()
                how = draw.choice(of.LOSSES)
                with self.subTest(kind=of.kind, at=at, how=how):
                    bench.keep()
                    self.assertEqual(in_a_copy(lambda: wrong_after_loss(bench, how)), "")  # pylint: disable=cell-var-from-loop
                    bench.back()
            print(f"{of.kind}: {RUNS} losses, {driven} of them of a drive whose gates were on")


def wrong_after_loss(bench, how):
    """What does not hold after a loss, in words; the throttle comes back where it was, and nothing may start."""
    was_on, bench.said = bench.gates_on(), ""
    bench.lose(how)
    bench.wait(TIMEOUT_S + LATE_S)
    lost = [f"the input is lost: {reason}: the drive stops" for reason in bench.of.REASONS]
    if was_on and not any(line in bench.said for line in lost):
        return f"nothing is said of the loss: {bench.said}"
    if bench.until(lambda: not bench.gates_on(), RAMP_S) is None:
        return f"the gates are not open in time: {bench.said}"
    bench.lose(None)
    bench.wait(ARM_S + 0.1)
    if bench.gates_on() or "FAULT" in bench.said:
        return f"gates {bench.gates_on()}: {bench.said}"
    return ""


class Disturbed(unittest.TestCase):
    """Without a motor: nothing may start. Many disturbances go on from the same board that is armed, or whose throttle is high."""

    def board(self, of, wanted):
        made = Board(IMAGE, BOARD, CLOCK, flashed=stored(NFCONFIG, WIRING.facts, MOTOR, BOARD, "any", SETTINGS | {"input.kind": of.kind}))
        made.chip.usart.instant = True
        made.set_inputs(MIDDLE, MIDDLE, BUS)
        made.boot()
        throttle = of(made, TICKS_PER_S)
        throttle.wanted = wanted
        for _ in range(round((ARM_S + 0.25) * TICKS_PER_S)):
            throttle.feed()
            made.tick()
        self.assertFalse(made.chip.timer.gates_on())
        return made, throttle

    def assert_starts(self, of, wanted, moves):
        """So many disturbances begin no start. `moves`: a throttle that then comes to rest and moves starts the motor: it is armed."""
        made, throttle = self.board(of, wanted)
        for seed in range(DISTURBANCES):
            with self.subTest(kind=of.kind, seed=seed):
                self.assertEqual(in_a_copy(lambda: wrong_when_disturbed(made, throttle, seed, moves)), "")  # pylint: disable=cell-var-from-loop
        print(f"{of.kind}: {DISTURBANCES} disturbances of a throttle at {wanted}")

    def test_no_disturbance_starts_an_armed_board(self):
        for of in ALL:
            self.assert_starts(of, 0.0, moves=True)

    def test_no_disturbance_starts_a_board_whose_throttle_was_high_at_power_up(self):
        for of in ALL:
            self.assert_starts(of, THROTTLE, moves=False)


def wrong_when_disturbed(made, throttle, seed, moves):
    """Losses, gaps, jitter and what else a line bears, in pieces of 1 to 150 ms; then a sound line."""
    throttle.draw = draw = random.Random(seed)

    def starts(seconds, feed):
        for _ in range(round(seconds * TICKS_PER_S)):
            feed()
            made.tick()
            if made.chip.timer.gates_on():
                return True
        return False

    story = []
    for _ in range(4):
        throttle.lost = draw.choice((None, None, *throttle.LOSSES))
        story.append((throttle.lost, draw.uniform(1e-3, 0.15)))
        if starts(story[-1][1], throttle.disturb):
            return f"it starts in {story}"
    throttle.lost = None
    if starts(0.1, throttle.feed):
        return f"it starts after {story}"
    if moves:
        if starts(ARM_S + 0.2, throttle.feed):
            return f"it starts at rest after {story}"
        throttle.wanted = THROTTLE
        if not starts(0.3, throttle.feed):
            return f"it does not start any more after {story}: {made.said()}"
    return ""


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[6:]])
