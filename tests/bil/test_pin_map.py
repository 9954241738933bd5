# SPDX-License-Identifier: MIT
"""target.loop.pin_map: what the wiring of a board has to do, whatever its pins are: measure, switch, open, and be watched.

test_pin_map.py IMAGE BOARD CLOCK [TEST...], as scenario.py.
"""

import re
import sys
import unittest

import digital
from rig import (BUS, CALIBRATION_TICKS, FULL_SCALE_A, HAL, MIDDLE, STAGE, WIRING, answer, instant, lose_a_conversion,
                 run)

SHARE = 0.2            # of full scale, for a current that is seen
TOLERANCE = 0.02       # of that: a count of 410, and the offset of ideal parts
PHASES = re.compile(r"phases (-?\d+\.\d+) (-?\d+\.\d+) (-?\d+\.\d+) A, bus (\d+\.\d+) V")
BEYOND = 2040          # counts of a current at which each board trips
OPENING_US = 1         # hardware alone
WATCHDOG_TICKS = 100   # more than it takes


def currents(made):
    """Of the three phases and the bus, as the console says them."""
    found = PHASES.search(answer(made, "status"))
    return [float(text) for text in found.groups()]


def switches(made):
    """What is at both pins of each phase: (high gate, low gate or enable)."""
    return [(made.chip.timer.output(leg.channel, False), made.chip.timer.output(leg.channel, True)) for leg in WIRING.legs]


def over_current(phase):
    """Counts of phases a and b, at which a phase's pin is beyond the level of its comparator."""
    up = bool(WIRING.break_level) == (HAL["amplifier_gain"] > 0)  # into the motor
    return [MIDDLE + (BEYOND if up else -BEYOND) * (1 if phase == k else -1 if phase == 2 else -0.5) for k in (0, 1)]


class PinMap(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = instant()

    def settle(self):
        """Without current, and ready."""
        self.made.set_inputs(MIDDLE, MIDDLE, BUS)
        self.made.tick(3)

    def test_1_is_ready_with_its_pins_as_the_board_has_them(self):
        made = self.made
        self.assertTrue(made.chip.power.runs_at_full_speed())
        self.assertEqual(made.chip.power.runs_on_crystal(), bool(WIRING.crystal_hz))
        for pin in WIRING.alternates:
            self.assertTrue(made.chip.has_function(pin), pin)
        for pin, level in WIRING.held.items():
            self.assertEqual(made.chip.pin_level(pin), level, pin)
        if WIRING.led:
            self.assertIsNotNone(made.chip.pin_level(WIRING.led))
        self.assertFalse(made.chip.timer.gates_on())
        self.assertIn("READY", answer(made, "status"))

    def test_2_each_current_and_the_bus_is_that_of_its_pin(self):
        full = FULL_SCALE_A
        shown = round(SHARE * MIDDLE)
        self.assertTrue(all(abs(value) < TOLERANCE * SHARE * full for value in currents(self.made)[:3]))
        self.made.set_inputs(MIDDLE + shown, MIDDLE - shown // 4, BUS * 9 // 10)
        self.made.tick(3)
        *phases, bus = currents(self.made)
        self.settle()
        for value, share in zip(phases, (1, -0.25, -0.75)):
            self.assertAlmostEqual(value, share * SHARE * full, delta=TOLERANCE * SHARE * full)
        self.assertAlmostEqual(bus / STAGE["bus_nominal_v"], 0.9, delta=0.01)

    def test_3_run_switches_each_phase_and_stop_opens_it(self):
        run(self.made)
        self.assertTrue(self.made.chip.timer.gates_on())
        self.assertEqual(switches(self.made), [("pwm", 1 if WIRING.has_enables else "pwm")] * 3)
        self.made.type("stop")
        self.made.take()
        self.assertFalse(self.made.chip.timer.gates_on())
        self.made.tick(CALIBRATION_TICKS)

    def test_4_the_break_opens_each_phase_without_software(self):
        made = self.made
        phases = [None] if WIRING.break_line else range(len(WIRING.shunts))
        for phase in phases:
            with self.subTest(phase=phase):
                run(made)
                self.assertTrue(made.chip.timer.gates_on(), made.said())
                began = made.chip.now
                if phase is None:
                    made.chip.set_fault_line(WIRING.break_level)
                else:
                    made.set_inputs(*over_current(phase), BUS)
                self.assertFalse(made.chip.timer.gates_on())
                self.assertLessEqual(made.chip.now - began, OPENING_US * 1e-6 * digital.CLOCK_HZ)
                made.chip.set_fault_line(1 - WIRING.break_level)
                self.settle()
                self.assertIn("FAULT by BREAK", answer(made, "status"))
                made.type("clear")
                made.tick(2 * CALIBRATION_TICKS)
                self.assertIn("READY", answer(made, "status"))

    def test_5_without_ticks_the_watchdog_bites_and_the_gates_are_open(self):
        made = self.made
        run(made)
        self.assertTrue(made.chip.timer.gates_on())
        self.assertEqual(lose_a_conversion(made), made.chip.system.SYSTICK)
        self.assertFalse(made.chip.timer.gates_on())
        with self.assertRaises(digital.WatchdogBites):
            made.tick(WATCHDOG_TICKS)
        self.assertFalse(made.chip.timer.gates_on())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
