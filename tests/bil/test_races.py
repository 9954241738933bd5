# SPDX-License-Identifier: MIT
"""target.loop.races: what comes between two accesses of the image to a register, and what a tick must not undo.

test_races.py IMAGE BOARD CLOCK [TEST...], as scenario.py.
"""

import re
import sys
import unittest

from rig import BUS, CALIBRATION_TICKS, FULL_SCALE_A, HALF_PERIOD, MIDDLE, answer, instant, lose_a_conversion, run, running

TEMPERATURE_TICKS = 1024
CLOSE = 32  # of the timer's counts: nearer to the peak than three compare registers take to be written
LATE_TICKS = 12  # more than the drive bears in a second
OVER = 4096 / 4  # counts at a comparator: beyond every level


def before_search():
    """The next tick asks for the gates."""
    made = instant()
    made.type("run")
    made.tick_to_search()
    return made


def spike(made):
    """Of one comparator: gone at once, its flag stays."""
    pin = made.wiring.shunts[0]
    rest = made.chip.pins[pin]
    made.chip.set_pins(**{pin: OVER})
    made.chip.set_pins(**{pin: rest})


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
        made = before_search()
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
        self.assertEqual(lose_a_conversion(made), made.chip.system.SYSTICK)
        made.chip.watchdog.due = float("inf")  # what if it did not bite
        made.tick(3)
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        run(made)
        made.tick(2)
        self.assertFalse(made.chip.timer.gates_on())

    def test_one_in_the_tick_that_asks_for_the_gates_keeps_them_open(self):
        """That tick hangs for longer than its guard waits, and then goes on."""
        made = before_search()
        guard = made.chip.system
        once(made.chip.converters[0].register("JDR1"), lambda: made.chip.advance(guard.due - made.chip.now))
        self.assertIn(made.handle_next(), guard.conversions)
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
        self.assertIn(" late 1,", answer(made, "status"))

    def test_behind_one_the_temperature_waits(self):
        """Its conversion could meet the next sequence of the shunts."""
        made = instant()
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
                made = instant()
                ends = self.ends_a(made)
                made.set_inputs(*counts, BUS)
                made.tick(TEMPERATURE_TICKS + 2)
                phases = re.search(r"phases (\S+) (\S+) (\S+) A", answer(made, "status"))
                for said, sign in zip(phases.groups(), shown):
                    self.assertAlmostEqual(float(said), ends[sign], delta=FULL_SCALE_A / 1024)

    @staticmethod
    def ends_a(made):
        """What the converter can show in either direction: an amplifier's zero away from mid-scale brings one nearer."""
        counts = sorted(made.sign * (raw - made.zero) for raw in (0, 4095))
        ampere = FULL_SCALE_A / MIDDLE
        return {-1: max(counts[0], -MIDDLE) * ampere, 1: min(counts[1], MIDDLE) * ampere}


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
