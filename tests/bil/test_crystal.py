# SPDX-License-Identifier: MIT
"""target.loop.crystal: a board whose clock comes from a crystal, and what the image does about one that is not as it should be.

test_crystal.py IMAGE BOARD CLOCK [TEST...], as scenario.py; the board file has to name a crystal (hal.crystal_hz).
"""

import sys
import unittest

import digital
import g4
from rig import CALIBRATION_TICKS, WIRING, answer, gates_are_inputs, instant, make, run, running

RIGHT_HZ = WIRING.crystal_hz
WRONG_HZ = 24e6 if RIGHT_HZ == 8e6 else 8e6
PATIENCE_S = 1         # more than the wait for a crystal; looked at in steps, for the console's loop is dear to emulate
STEP_S = 10e-3
START_S = 40e-3        # more than the start of the clock takes
RECOVERY_S = 2e-3      # more than the clock takes to full speed again, and the console to say why
OPENING_US = 3         # the crystal's watch, and nothing of the image
CANNOT_START = "cannot start:\r\n"


def refused(crystal_hz):
    """The board, and what its console has said until the reason is a whole line."""
    made, said = make(crystal_hz=crystal_hz), ""
    for _ in range(round(PATIENCE_S / STEP_S)):
        made.go_on(STEP_S)
        said += made.chip.usart.heard()
        if "\n" in said.partition(CANNOT_START)[2]:
            break
    return made, said


class Start(unittest.TestCase):
    def reason(self, crystal_hz):
        """Why the drive cannot start, from a console whose speed is right all the same."""
        made, said = refused(crystal_hz)
        self.assertNotIn("READY", said)
        self.assertEqual(made.chip.usart.unreadable, 0)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertFalse(made.chip.power.runs_on_crystal())
        self.assertTrue(made.chip.power.runs_at_full_speed())
        self.assertIn(CANNOT_START, said)
        return said.split(CANNOT_START)[1].splitlines()[0]

    def test_the_right_one_gives_the_clock_and_is_watched(self):
        made = make()
        made.boot()
        made.tick(CALIBRATION_TICKS)
        self.assertIn("READY", made.said())
        self.assertTrue(made.chip.power.runs_on_crystal())
        self.assertTrue(made.chip.power.runs_at_full_speed())
        self.assertTrue(made.chip.power.rcc["CR"] & digital.CSSON)

    def test_a_missing_one_is_named(self):
        self.assertIn("crystal", self.reason(0))

    def test_one_that_is_off_by_what_an_oscillator_may_be_is_taken_and_one_that_is_off_by_more_is_not(self):
        """By 2 % the oscillator in the chip can be off, by 4 % are 24 and 25 MHz apart."""
        for share, taken in ((0.98, True), (1.02, True), (0.96, False), (1.0417, False)):
            with self.subTest(share):
                made = make(crystal_hz=RIGHT_HZ)
                made.chip.power.crystal_32_hz = lambda made=made, share=share: share * RIGHT_HZ / 32
                made.chip.pace.sources[g4.HSE_32] = made.chip.power.crystal_32_hz
                made.go_on(START_S)
                self.assertEqual(made.chip.power.runs_on_crystal(), taken)

    def test_one_of_another_frequency_is_named_and_is_not_called_missing(self):
        reason = self.reason(WRONG_HZ)
        self.assertIn("crystal", reason)
        self.assertNotEqual(reason, self.reason(0))


class Dies(unittest.TestCase):
    def assert_named_and_open(self, made):
        """For good, on a console that can be read, and without a reset by the watchdog."""
        made.go_on(RECOVERY_S)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertTrue(gates_are_inputs(made))
        self.assertFalse(made.chip.power.runs_on_crystal())
        self.assertTrue(made.chip.power.runs_at_full_speed())
        self.assertFalse(made.chip.power.asks_for_nmi())
        said = made.said() + answer(made, "status")
        self.assertEqual(made.chip.usart.unreadable, 0)
        self.assertRegex(said, r"FAULT by BREAK[^\n]*, until a reset: [^\n]*crystal")

    def test_in_run_the_gates_open_without_the_image(self):
        made = running()
        died = made.chip.now
        made.chip.power.stop_crystal()
        made.go_on(RECOVERY_S)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertLessEqual(made.chip.timer.opened - died, OPENING_US * 1e-6 * digital.CLOCK_HZ)
        self.assert_named_and_open(made)

    def test_a_clear_does_not_bring_the_gates_back(self):
        made = running()
        made.chip.power.stop_crystal()
        made.go_on(RECOVERY_S)
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        run(made)
        self.assert_named_and_open(made)

    def test_in_the_tick_that_asks_for_the_gates_they_stay_open(self):
        """It is noticed between the measurements and the demand."""
        made = instant()
        made.type("run")
        made.tick_to_search()
        register = made.chip.converters[0].register("JDR1")

        def read():
            register.on_read = None
            made.chip.power.stop_crystal()
            made.chip.advance(digital.CRYSTAL_WATCH)
            return register.value

        register.on_read = read
        made.handle_next()
        self.assert_named_and_open(made)

    def test_while_the_drive_is_ready_it_is_named_too(self):
        made = instant()
        made.chip.power.stop_crystal()
        self.assert_named_and_open(made)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
