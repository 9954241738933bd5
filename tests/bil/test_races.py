# SPDX-License-Identifier: MIT
"""target.loop.races: what comes between two accesses of the image to a register, and what a tick must not undo.

test_races.py IMAGE BOARD CLOCK [TEST...], as scenario.py.
"""

import re
import sys
import tomllib
import unittest
from pathlib import Path

import board

IMAGE, BOARD, CLOCK = (Path(argument) for argument in sys.argv[1:4])
FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))["board"]
MIDDLE = 2048
BUS = round(FILE["bus_nominal_v"] / FILE["bus_full_scale_v"] * 4096)
HALF_PERIOD = round(FILE["timer_clock_hz"] / FILE["pwm_frequency_hz"] / 2)
CALIBRATION_TICKS = 260
TEMPERATURE_TICKS = 1024
CLOSE = 32  # of the timer's counts: nearer to the peak than three compare registers take to be written
LATE_TICKS = 12  # more than the drive bears in a second
OVER = 4096 / 4  # counts at a comparator: beyond every level


def ready():
    made = board.Board(IMAGE, BOARD, CLOCK)
    made.set_inputs(MIDDLE, MIDDLE, BUS)
    made.boot()
    made.tick(CALIBRATION_TICKS)
    made.said()
    made.chip.usart.instant = True
    return made


def running():
    made = ready()
    made.type("run")
    made.take()
    made.tick(2)
    made.said()
    return made


def spike(made):
    """Of one comparator: gone at once, its flag stays."""
    rest = made.chip.pins["PA1"]
    made.chip.set_pins(PA1=OVER)
    made.chip.set_pins(PA1=rest)


def once(register, act, before=False):
    """At the next read of the register, `act`: behind it, or before."""
    hook = register.on_read

    def read():
        register.on_read = hook
        if before:
            act()
        value = register.value if hook is None else hook()
        if not before:
            act()
        return value

    register.on_read = read


def lock_up(made):
    """RM0440 28.6.5, SBIF: a break by the system opens the outputs and sets a flag of its own."""
    made.chip.timer["SR"] |= 1 << 13
    made.chip.timer["BDTR"] &= ~(1 << 15)


class Breaks(unittest.TestCase):
    def assert_broken(self, made):
        made.tick(2)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertIn("FAULT by BREAK", made.said())

    def test_one_behind_the_look_at_the_flags_is_seen_in_the_next_tick(self):
        """It comes between reading the flags and acknowledging them."""
        made = running()
        once(made.chip.timer.register("SR"), lambda: spike(made))
        self.assert_broken(made)

    def test_one_in_the_middle_of_a_tick_is_seen_in_the_next(self):
        made = running()
        once(made.chip.converters[0].register("JDR1"), lambda: spike(made))
        self.assert_broken(made)

    def test_one_that_is_pending_keeps_the_gates_open(self):
        """The drive asks for the gates in the very tick in which the break comes."""
        made = ready()
        made.type("run")
        made.tick_to_search()
        once(made.chip.converters[0].register("JDR1"), lambda: spike(made))
        made.tick()
        self.assertFalse(made.chip.timer.gates_on())
        self.assert_broken(made)

    def test_a_lockup_of_the_core_is_one(self):
        made = running()
        once(made.chip.timer.register("SR"), lambda: lock_up(made), before=True)
        self.assert_broken(made)


class LostTicks(unittest.TestCase):
    def test_behind_one_the_gates_stay_open_for_good(self):
        """Even if ticks come again, and somebody asks."""
        made = running()
        trigger = made.chip.timer.trigger
        made.chip.timer.trigger = lambda: setattr(made.chip.timer, "trigger", trigger)
        self.assertEqual(made.handle_next(), made.chip.system.SYSTICK)
        made.chip.watchdog.due = float("inf")  # what if it did not bite
        made.tick(3)
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        made.type("run")
        made.take()
        made.tick(4)
        self.assertFalse(made.chip.timer.gates_on())

    def test_one_in_the_tick_that_asks_for_the_gates_keeps_them_open(self):
        """That tick hangs for longer than its guard waits, and then goes on."""
        made = ready()
        made.type("run")
        made.tick_to_search()
        guard = made.chip.system
        once(made.chip.converters[0].register("JDR1"), lambda: made.chip.advance(guard.due - made.chip.now))
        self.assertEqual(made.handle_next(), guard.ADC1_2)
        self.assertIn(guard.SYSTICK, made.core.taken)
        self.assertFalse(made.chip.timer.gates_on())


class LateTicks(unittest.TestCase):
    def test_the_drive_hears_of_each(self):
        made = running()
        register = made.chip.converters[0].register("JDR1")
        for _ in range(LATE_TICKS):
            once(register, lambda: made.chip.advance(2 * HALF_PERIOD))
            made.tick(2)
        self.assertIn("FAULT by LATE", made.said())

    def test_one_that_is_so_close_to_the_peak_that_it_could_be_torn_is_late(self):
        made = running()
        timer = made.chip.timer
        once(timer.register("CNT"), lambda: made.chip.advance(timer.next_update() - CLOSE - made.chip.now), before=True)
        made.tick()
        made.type("status")
        self.assertIn(" late 1,", made.said())

    def test_behind_one_the_temperature_waits(self):
        """Its conversion could meet the next sequence of the shunts."""
        made = ready()
        converter = made.chip.converters[0]
        made.tick(TEMPERATURE_TICKS - 1 - made.ticks)
        once(converter.register("JDR1"), lambda: made.chip.advance(2 * HALF_PERIOD))
        made.handle_next()
        converted = converter.converted
        made.tick(3)
        self.assertEqual(converter.converted, converted)
        made.tick(TEMPERATURE_TICKS)
        self.assertGreater(converter.converted, converted)


class Measurements(unittest.TestCase):
    def test_beyond_the_converters_ends_they_stay_there(self):
        """For a period of the temperature, so that each way through a tick meets them."""
        for counts, shown in (((0, 0), (-1, -1, 1)), ((4095, 4095), (1, 1, -1))):
            with self.subTest(counts):
                made = ready()
                ends = self.ends_a(made)
                made.set_inputs(*counts, BUS)
                made.tick(TEMPERATURE_TICKS + 2)
                made.said()
                made.type("status")
                phases = re.search(r"phases (\S+) (\S+) (\S+) A", made.said())
                for said, sign in zip(phases.groups(), shown):
                    self.assertAlmostEqual(float(said), ends[sign], delta=FILE["current_full_scale_a"] / 1024)

    @staticmethod
    def ends_a(made):
        """What the converter can show in either direction: an amplifier's zero away from mid-scale brings one nearer."""
        counts = sorted(made.sign * (raw - made.zero) for raw in (0, 4095))
        ampere = FILE["current_full_scale_a"] / MIDDLE
        return {-1: max(counts[0], -MIDDLE) * ampere, 1: min(counts[1], MIDDLE) * ampere}


class Phases(unittest.TestCase):
    def test_each_is_shown_from_its_own_register(self):
        """Values far apart, none of them the other's negative."""
        made = ready()
        made.set_inputs(MIDDLE + 300, MIDDLE - 700, BUS)
        made.tick(2)  # what is converted when the inputs change belongs to the tick before
        made.said()
        made.type("status")
        said = made.said()
        shown = [float(part) for part in said.split("phases ")[1].split(" A")[0].split()]
        amperes = FILE["current_full_scale_a"] / MIDDLE
        for value, counts in zip(shown, (300, -700, 400)):
            self.assertAlmostEqual(value, counts * amperes, delta=1.01 * amperes)


class Speeds(unittest.TestCase):
    def test_both_limits_are_the_last_that_are_taken(self):
        made = ready()
        made.type("speed x")
        limit = int(made.said().split("at most ")[1].split()[0])
        for rpm, taken in ((limit, True), (limit + 1, False), (-limit, True), (-limit - 1, False)):
            made.type(f"speed {rpm}")
            self.assertEqual(made.said() == "ok\r\n", taken, rpm)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
