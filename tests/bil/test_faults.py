# SPDX-License-Identifier: MIT
"""target.loop.faults: what the image does when something goes wrong, and that the models notice.

test_faults.py IMAGE BOARD CLOCK [TEST...], as scenario.py; all tests, or those named.
"""

import functools
import itertools
import re
import struct
import sys
import unittest

import analogue
import board
import console
import core
from digital import NEVER, CLOCK_HZ, Configuration, WatchdogBites
from flash import BOR_LEVEL, NO_PARITY, store_of
from registers import WrongAccess
from rig import (BOARD, BUS, CALIBRATION_TICKS, FULL_SCALE_A, HAL, HALF_PERIOD, MIDDLE, STAGE, WIRING, address_of, answer, booted,
                 lose_a_conversion, make, ready, run, running)



def count_at(celsius):
    """What the temperature sensor of the board gives."""
    points = list(zip(STAGE["temperature_points_c"], STAGE["temperature_points_pct"]))
    (low, below), (high, above) = next(pair for pair in itertools.pairwise(points) if pair[1][0] >= celsius)
    return round((below + (above - below) * (celsius - low) / (high - low)) * 40.96)


REST = (HALF_PERIOD // 2,) * 3
WATCHDOG_S = (8 * 4 + 1) / 29.5e3  # 8 counts of 4 cycles and one of uncertainty, of the slowest oscillator
GIVING_UP_S = 0.2          # more than the image tests its RAM, waits for a register, and then says so
HOT = count_at(STAGE["temperature_max_c"] + 5)
BEYOND = 4000             # hotter than the last point of board.temperature_points_pct
TEMPERATURE_TICKS = 1026  # from one conversion to the next, and to the frame
GATES_TICKS = 150         # from FLYING_START on: the gates are on, and it is not too hot for long enough yet
TUNING = "robust for motor A" if BOARD.stem == "g431_bench" else "any motor"  # of the images
OVERTEMPERATURE_TICKS = round(0.11 * STAGE["pwm_frequency_hz"])  # for 0.1 s

STRIDE = 37  # instructions, fewer than the store needs to read a block, and in step with none of its loops
LONG_BLOCK = b"NFCB" + struct.pack("<II", 1, 384) + bytes(1524)  # for the store to read, and to find its CRC wrong


class Boots(unittest.TestCase):
    def test_full_speed_and_pins(self):
        made = ready()
        self.assertTrue(made.chip.power.runs_at_full_speed())
        for pin in made.wiring.alternates:
            self.assertTrue(made.chip.has_function(pin), pin)
        self.assertEqual({pin: made.chip.pin_level(pin) for pin in WIRING.held}, WIRING.held)

    def test_says_what_it_is_and_opens_no_gate_unasked(self):
        made = ready()
        said = made.said()
        self.assertRegex(said, rf"^neurofoc: .*, {re.escape(STAGE['name'])}, {TUNING}\r?\n")
        self.assertIn("READY", said)
        self.assertNotIn("watchdog", said)
        self.assertFalse(made.chip.timer.gates_on())

    def test_dead_time_is_at_least_that_of_the_board(self):
        """A driver with enables makes it itself."""
        made_by_timer = 0 if WIRING.has_enables else STAGE["dead_time_s"]
        self.assertGreaterEqual(ready().chip.timer.dead_time() / CLOCK_HZ, made_by_timer * (1 - 1e-9))

    def test_samples_and_updates_at_the_peak(self):
        made = ready()
        trigger, counts = made.chip.timer.trigger, []

        def look():
            counts.append(made.chip.timer.count())
            trigger()

        made.chip.timer.trigger = look
        made.tick(5)
        self.assertEqual(counts, [HALF_PERIOD] * 5)

    def test_run_and_stop(self):
        made = running()
        self.assertTrue(made.chip.timer.gates_on())
        made.type("stop")
        made.take()
        self.assertFalse(made.chip.timer.gates_on())


@unittest.skipIf(WIRING.break_line, "the gate driver looks for over-currents")
class OverCurrent(unittest.TestCase):
    def count(self, made, ampere):
        return MIDDLE - round(ampere / FULL_SCALE_A * MIDDLE)  # out of the motor

    def test_below_the_level_nothing_happens(self):
        made = running()
        for phase_a, phase_b in ((0, MIDDLE), (MIDDLE, 0), (MIDDLE, MIDDLE)):
            limit = self.count(made, made.trip_a - 0.2)
            made.set_inputs(phase_a or limit, phase_b or limit, BUS)
            self.assertTrue(made.chip.timer.gates_on())

    def test_each_phase_opens_the_gates_without_software(self):
        for phase in range(3):
            with self.subTest(phase):
                made = running()
                counts = [MIDDLE] * 3
                counts[phase] = self.count(made, made.trip_a + 0.2)
                counts[(phase + 1) % 3] = 3 * MIDDLE - counts[phase] - MIDDLE
                made.set_inputs(*counts[:2], BUS)
                self.assertFalse(made.chip.timer.gates_on())

    def test_into_a_phase_it_opens_them_where_it_returns(self):
        for share, opens in ((1.0, False), (1.9, False), (2.1, True)):
            with self.subTest(share):
                made = running()
                inwards = MIDDLE + round(share * made.trip_a / FULL_SCALE_A * MIDDLE)
                made.set_inputs(inwards, MIDDLE - (inwards - MIDDLE) // 2, BUS)
                self.assertEqual(made.chip.timer.gates_on(), not opens)

    def opens_at(self, choose, ampere):
        """Whether some phase opens the gates by itself, on a board of such parts."""
        made = running(choose=choose)
        limit = self.count(made, ampere)
        for counts in ((limit, MIDDLE), (MIDDLE, limit), (2 * MIDDLE - limit, MIDDLE)):
            made.set_inputs(*counts, BUS)
        return not made.chip.timer.gates_on()

    def test_the_comparators_of_each_board_leave_what_the_drive_allows_and_trip_within_their_tolerances(self):
        """The drive's own limit comes first, also with parts that trip early; those that trip late do so at last."""
        late_v = -analogue.COMPARATOR_OFFSET_MV[0] / 1e3 + (1 - analogue.BIAS[0]) * HAL["amplifier_zero_v"] / HAL["pga_gain"]
        late_a = late_v / (HAL["shunt_ohm"] * abs(HAL["amplifier_gain"]) / HAL["pga_gain"])
        for choose in (analogue.least, analogue.most, *map(analogue.drawn, range(3))):
            self.assertFalse(self.opens_at(choose, STAGE["overcurrent_a"] - 0.2))
            self.assertTrue(self.opens_at(choose, STAGE["trip_a"] + late_a + 0.2))

    def test_is_reported_and_stays_until_it_is_cleared(self):
        made = running()
        made.set_inputs(self.count(made, made.trip_a + 0.2), MIDDLE, BUS)
        made.set_inputs(MIDDLE, MIDDLE, BUS)
        made.tick(2)
        self.assertIn("FAULT by BREAK", made.said())
        self.assertIn("error: a fault is latched", answer(made, "run"))
        made.take()
        made.tick()
        self.assertFalse(made.chip.timer.gates_on())
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        made.type("run")
        made.tick_to_search()
        made.tick()
        self.assertTrue(made.chip.timer.gates_on())


@unittest.skipUnless(WIRING.break_line, "comparators look for over-currents")
class FaultLine(unittest.TestCase):
    def test_it_opens_the_gates_without_software(self):
        made = running()
        self.assertTrue(made.chip.timer.gates_on())
        made.chip.set_fault_line(WIRING.break_level)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertFalse(WIRING.has_enables and any(made.chip.timer.enables()))

    def test_a_driver_that_takes_longer_to_wake_up_than_the_board_file_says_is_named(self):
        made = make()
        made.chip.wiring.wake_s = 30e-3  # longer than all that comes before the trial too
        self.assertIn("cannot start:\r\nthe gate driver tells of a fault at rest\r\n", self.refused(made))

    def test_it_is_reported_and_stays_until_it_is_cleared(self):
        made = running()
        made.chip.set_fault_line(WIRING.break_level)
        made.chip.set_fault_line(1 - WIRING.break_level)
        made.tick(2)
        self.assertIn("FAULT by BREAK", made.said())
        run(made)
        self.assertFalse(made.chip.timer.gates_on())
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        run(made)
        self.assertTrue(made.chip.timer.gates_on())

    def refused(self, made):
        made.go_on(GIVING_UP_S)
        self.assertFalse(made.chip.timer.gates_on())
        return made.said()

    def test_a_fault_at_the_start_is_named(self):
        made = make()
        made.chip.fault_line = WIRING.break_level
        self.assertIn("cannot start:\r\nthe gate driver tells of a fault at rest\r\n", self.refused(made))

    def test_a_break_input_that_does_not_see_the_line_is_found_at_the_start(self):
        """It sees its level at rest, whatever polarity the timer asks for."""
        made = make()
        made.chip.break_changed = lambda: made.chip.timer.set_break_input(False)
        self.assertIn("cannot start:\r\nthe line of the gate driver does not open the gates\r\n", self.refused(made))


class Ticks(unittest.TestCase):
    def stall(self, made, cycles):
        """The next tick takes so much longer, between its measurements and its demand."""
        register = made.chip.converters[0].register("JDR1")

        def read():
            register.on_read = None
            made.chip.advance(cycles)
            return register.value

        register.on_read = read

    def test_a_late_one_leaves_the_rest_duty_and_is_counted(self):
        made = running()
        made.type("speed 1000")
        made.tick(200)  # until the ramp asks for more current than rounds to nothing
        self.assertNotEqual(made.chip.timer.active, REST)
        self.stall(made, 2 * HALF_PERIOD)
        made.handle_next()
        self.assertEqual(made.chip.timer.active, REST)
        made.tick(2)
        self.assertNotEqual(made.chip.timer.active, REST)
        self.assertIn(" late 1,", answer(made, "status"))
        self.assertTrue(made.chip.timer.gates_on())

    def test_a_skipped_one_opens_the_gates_and_trips_the_watchdog(self):
        made = running()
        last = made.chip.now
        self.assertEqual(lose_a_conversion(made), made.chip.system.SYSTICK)
        self.assertFalse(made.chip.timer.gates_on())
        with self.assertRaises(WatchdogBites):
            made.tick(100)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertLess((made.chip.now - last) / CLOCK_HZ, WATCHDOG_S)

    def test_after_the_watchdog_the_console_says_so(self):
        made = booted(reset_flags=board.WATCHDOG_FLAG)
        self.assertIn("last reset: watchdog; no recording is saved", made.said())
        self.assertEqual(made.chip.power.rcc["CSR"], 0)

    def test_an_interrupt_that_nobody_wants_opens_the_gates_for_good(self):
        made = running()
        made.core.handle(16, instructions=1000)  # the window watchdog's, which does not run
        self.assertFalse(made.chip.timer.gates_on())

    def test_a_torn_word_of_the_store_is_survived_and_any_other_opens_the_gates(self):
        """The NMI comes while the store reads a unit, and then of something else, with and without a torn word."""
        made = make(flashed=[(store_of(WIRING.facts), LONG_BLOCK)])
        reading = address_of("is_reading")
        nmi = functools.partial(made.core.handle, 2, instructions=1000)
        while made.core.uc.mem_read(reading, 1) != b"\1":  # the test of the RAM leaves other values there
            made.core.step(STRIDE)
        made.chip.power.flash.tear()
        self.assertTrue(nmi())
        self.assertEqual(made.chip.power.flash["ECCR"], 0)
        self.assertFalse(nmi())  # no word was torn
        made = running()
        made.chip.power.flash.tear()
        self.assertFalse(made.core.handle(2, instructions=1000))
        self.assertFalse(made.chip.timer.gates_on())

    def test_a_wrong_parity_of_the_ram_opens_the_gates_without_software_and_its_nmi_does_not_come_back(self):
        made = running()
        made.chip.configuration.fail(Configuration.PARITY)
        self.assertFalse(made.chip.timer.gates_on())
        made = running()
        made.chip.configuration["CFGR2"] |= Configuration.PARITY_FLAG  # as if the break had not come
        made.core.uc.mem_write(address_of("is_reading"), b"\1")
        made.chip.power.flash.tear()
        self.assertFalse(made.core.handle(2, instructions=1000))
        self.assertFalse(made.chip.timer.gates_on())

    def test_a_supply_that_sinks_opens_the_gates_without_software_and_is_a_break(self):
        made = running()
        made.chip.configuration.fail(Configuration.SUPPLY)
        self.assertFalse(made.chip.timer.gates_on())
        made.tick(2)
        self.assertIn("FAULT by BREAK", made.said())

    def test_the_console_tells_which_option_bytes_protect_less_than_they_could(self):
        for wrong, told in ((BOR_LEVEL, "no reset at 2.8 V of supply, set BOR_LEV = 4"), (NO_PARITY, "no parity of the RAM, set SRAM_PE = 0")):
            with self.subTest(told):
                made = make()
                made.chip.power.flash["OPTR"] ^= wrong
                made.boot()
                self.assertEqual(re.findall("option bytes: (.*)\r", made.said()), [told])
        self.assertNotIn("option bytes", booted().said())

    def test_a_fault_with_no_stack_left_opens_the_gates(self):
        made = running()
        made.core.fault_without_stack(3, instructions=50)
        self.assertFalse(made.chip.timer.gates_on())


class Resets(unittest.TestCase):
    """The backup registers: heat (Q24), its scale, and a check word."""

    ONE = 1 << 24

    @staticmethod
    def kept(heat, scale):
        return heat, scale, ~(heat + scale) & 0xFFFFFFFF

    def test_the_heat_of_the_winding_goes_on_where_it_was(self):
        heat, scale, check = ready().chip.power.backup.words[:3]
        self.assertEqual((heat, scale, check), self.kept(heat, scale))
        before = self.kept(self.ONE // 4, scale)
        after = ready(kept=before).chip.power.backup.words[0]
        self.assertLess(0, self.ONE // 4 - after)  # it has cooled since the start
        self.assertLess(self.ONE // 4 - after, self.ONE // 400)

    def test_after_a_loss_of_power_the_winding_counts_as_warm(self):
        scale = ready().chip.power.backup.words[1]
        for kept in ((), (self.ONE // 4, scale, 0)):
            with self.subTest(kept):
                heat = ready(kept=kept).chip.power.backup.words[0]
                self.assertLess(0.89 * self.ONE, heat)
                self.assertLess(heat, 0.9 * self.ONE)


class Console(unittest.TestCase):
    def test_what_is_no_command_is_refused_in_one_line_and_the_last_speeds_are_taken(self):
        made = ready()
        limit = int(re.search(r"at most (\d+) either way", answer(made, "speed fast"))[1])
        commands = "the commands are run, stop, clear, speed RPM, torque NM, zero, unlock, status, dump, record, last, faults, identify"
        speeds = f"speed takes a whole number of rpm, at most {limit} either way"
        for line, wrong in (("sped 3", commands), ("run " + 100 * "x", commands), ("clear", "there is no fault to clear"),
                            ("speed fast", speeds), (f"speed {limit + 1}", speeds), (f"speed {-limit - 1}", speeds)):
            self.assertEqual(answer(made, line), f"error: {wrong}\r\n")
        for taken in (limit, -limit):
            self.assertEqual(answer(made, f"speed {taken}"), "ok\r\n")

    def test_each_phase_is_shown_from_its_own_input(self):
        """Counts that lie far apart, none of them the other's negative."""
        made = ready()
        made.set_inputs(MIDDLE + 300, MIDDLE - 700, BUS)
        made.tick(2)  # what is converted when the inputs change belongs to the tick before
        shown = re.search(r"READY, speed unknown, asked 0 rpm, phases (\S+) (\S+) (\S+) A, bus (\S+) V, 25 C", answer(made, "status"))
        per_count = FULL_SCALE_A / MIDDLE
        for text, counts in zip(shown.groups(), (300, -700, 400)):
            self.assertAlmostEqual(float(text), counts * per_count, delta=1.01 * per_count)
        self.assertAlmostEqual(float(shown[4]), STAGE["bus_nominal_v"], delta=STAGE["bus_full_scale_v"] / 4096)

    def test_a_hot_board_is_a_fault_that_cannot_be_cleared_until_it_has_cooled(self):
        """The drive's fault is the only thing that stands in the way, for as long as it is hot."""
        made = ready()
        made.set_inputs(MIDDLE, MIDDLE, BUS, temperature=HOT)
        made.tick(TEMPERATURE_TICKS + OVERTEMPERATURE_TICKS)
        self.assertIn("FAULT by OVERTEMPERATURE", made.said())
        self.assertEqual(answer(made, "run"), "error: a fault is latched; clear it first\r\n")
        made.type("clear")
        made.tick(2 * CALIBRATION_TICKS)
        self.assertIn("FAULT by OVERTEMPERATURE", made.said())
        made.set_inputs(MIDDLE, MIDDLE, BUS)
        made.tick(TEMPERATURE_TICKS)
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        run(made)
        self.assertTrue(made.chip.timer.gates_on())

    def test_a_temperature_that_the_sensor_cannot_have_is_a_fault_of_the_sensor(self):
        for count in (0, BEYOND):  # open and shorted
            with self.subTest(count):
                made = ready()
                made.set_inputs(MIDDLE, MIDDLE, BUS, temperature=count)
                made.tick(TEMPERATURE_TICKS + OVERTEMPERATURE_TICKS)
                self.assertIn("FAULT by TEMPERATURE_SENSOR", made.said())

    def test_a_board_that_is_hot_for_less_than_the_drives_time_can_be_run(self):
        made = ready()
        made.set_inputs(MIDDLE, MIDDLE, BUS, temperature=HOT)
        while int(re.search(r"(\d+) C,", answer(made, "status"))[1]) < STAGE["temperature_max_c"]:
            made.tick(20)
        made.said()
        made.type("run")
        made.tick(board.SLOW_TICKS)
        self.assertCountEqual(console.lines(made.said()), ["ok", "FLYING_START"])
        made.tick(GATES_TICKS)
        self.assertTrue(made.chip.timer.gates_on())


class ModelsNotice(unittest.TestCase):
    def test_a_register_without_a_model(self):
        made = make()
        del made.core.bus._found[0x40012C60]
        with self.assertRaisesRegex(WrongAccess, "write of 0x40012c60, which has no model"):
            made.boot()

    def test_a_peripheral_without_a_model(self):
        made = make()
        line = WIRING.facts.base(WIRING.serial)
        made.core.uc.mem_unmap(line & ~(core.PAGE - 1), core.PAGE)
        with self.assertRaisesRegex(WrongAccess, f"to {line + 0xC:#x}, where there is nothing"):
            made.boot()

    def test_a_block_without_its_clock_reads_0_and_keeps_nothing_and_the_image_says_that_it_cannot_start(self):
        level = () if WIRING.break_line else (("DAC3", "CR", "the trip level's DAC does not become ready"),)
        for block, key, told in (
                *level,
                ("ADC2", "CR", "a converter does not become ready"),
                ("TIM1", "ARR", "the timer does not enable its output")):
            with self.subTest(block):
                made = make()
                found = next(one for one in made.chip.blocks if one.name == block)
                found.clocked = lambda: False
                kept = {name: register.value for name, register in found.by_address.values()}
                made.go_on(GIVING_UP_S)
                said = made.said()
                self.assertIn(f"cannot start:\r\n{told}\r\n", said)
                self.assertNotIn("READY", said)
                self.assertEqual({name: register.value for name, register in found.by_address.values()}, kept)
                self.assertEqual(made.chip.timer.due, NEVER)
                address = next(at for at, (name, _) in found.by_address.items() if name == key)
                made.core.bus.write(address, 4, 1)
                self.assertEqual(made.core.bus.read(address, 4), 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
