# SPDX-License-Identifier: MIT
"""target.loop.checks: the chip checks itself. Each part that protects is broken in the model, and the image has to find it.

test_checks.py IMAGE BOARD CLOCK [TEST...], as scenario.py; all tests, or those named.
"""

import functools
import re
import sys
import unittest

import analogue
from copies import in_a_copy
from g4 import RAM
from rig import (CALIBRATION_TICKS, STAGE, WIRING, WORD_BYTES, address_of, answer, booted, change_what_is_read, gates_are_inputs,
                 instant, make, ready, run, running)
from wiring import port_and_number

ROUND_TICKS = 130  # more than there are registers and pins: one is looked at in each pass of the background
GIVING_UP_S = 0.1  # more than the start takes
WORDS_A_TICK = 2  # of the flash
LAST_TICKS = 300  # of a round of the flash

# A bit of each register that protects, and of each kind of pin. Not of those whose change ends the ticks at once: the guard of the tick
# finds it.
FLIPS = {
    "TIM1_CR1": 1 << 5, "TIM1_CR2": 1 << 8, "TIM1_CCMR1": 1 << 4, "TIM1_CCMR2": 1 << 3, "TIM1_CCER": 1 << 2,
    "TIM1_BDTR": 1 << 0, "TIM1_AF1": 1 << 2, "TIM1_ARR": 1 << 3, "TIM1_RCR": 1 << 0, "TIM1_PSC": 1 << 0,
    "COMP1_CSR": 1 << 0, "COMP2_CSR": 1 << 16, "COMP4_CSR": 1 << 31, "DAC3_DHR12R1": 1 << 5, "DAC3_DHR12R2": 1 << 5,
    "DAC3_CR": 1 << 1, "DAC3_MCR": 1 << 8, "OPAMP1_CSR": 1 << 14, "OPAMP2_CSR": 1 << 5, "OPAMP3_CSR": 1 << 7,
    "ADC12_CCR": 1 << 16, "ADC1_CFGR": 1 << 12, "ADC1_SMPR1": 1 << 3, "ADC1_SMPR2": 1 << 24, "ADC1_SQR1": 1 << 6,
    "ADC1_JSQR": 1 << 17, "ADC2_CFGR": 1 << 12, "ADC2_SMPR1": 1 << 9, "ADC2_SMPR2": 1 << 25, "ADC2_SQR1": 1 << 7,
    "ADC2_JSQR": 1 << 21, "RCC_CFGR": 1 << 8, "RCC_PLLCFGR": 1 << 8, "RCC_CR": 1 << 24, "RCC_AHB2ENR": 1 << 18,
    "FLASH_ACR": 1 << 2, "PWR_CR5": 1 << 8, "PWR_CR1": 1 << 8, "PWR_CR2": 1 << 1, "SYSCFG_CFGR2": 1 << 1, "IWDG_PR": 1 << 0,
    "IWDG_RLR": 1 << 4, "SCB_SHPR3": 1 << 28, "NVIC_IPR4": 1 << 22, "NVIC_ISER0": 1 << 3,
    "SYST_RVR": 1 << 3, "USART2_BRR": 1 << 5,
}
# On a board with inputs. Where a throttle shares the converter of the temperature, their channel is written before each conversion.
FLIPS_OF_INPUTS = {
    "DMAMUX1_C0CR": 1 << 0, "DMA1_CCR1": 1 << 7, "DMA1_CPAR1": 1 << 2, "DMA1_CMAR1": 1 << 4, "DMA1_CMAR2": 1 << 12,
    "TIM2_PSC": 1 << 3, "TIM2_CCMR1": 1 << 5, "TIM2_CCER": 1 << 5, "TIM2_DIER": 1 << 9, "TIM4_SMCR": 1 << 1, "TIM4_CCMR1": 1 << 8,
    "RCC_AHB1ENR": 1 << 0,
}
if WIRING.pulse and WIRING.encoder:
    FLIPS = {name: bits for name, bits in FLIPS.items() if name != "ADC1_SQR1"} | FLIPS_OF_INPUTS
PIN_FLIPS = {WIRING.legs[0].high.name: "mode", WIRING.legs[2].second.name: "function", WIRING.legs[0].second.name: "pull",
             WIRING.shunts[0]: "mode"}
MAIN_OUTPUT, BREAK_FLAG = 1 << 15, 1 << 7  # of TIM1's BDTR and SR
COMPARATORS = dict(zip("abc", map(str, WIRING.comparators)))


def register_of(made, name):
    """By the name that the manual, and the image, have for it."""
    block, _, key = name.partition("_")
    block, key = {"COMP": ("COMP", f"{block[4:]}_{key}"), "OPAM": ("OPAMP", f"{block[5:]}_{key}")}.get(block[:4], (block, key))
    if block in ("SCB", "NVIC", "SYST"):
        block, key = "SYSTEM", name
    return next(one for one in made.chip.blocks if one.name == block).register(key)


def flip(made, name):
    register_of(made, name).value ^= FLIPS[name]


def flip_pin(made, name, what):
    """The lowest bit of its mode or function, or the higher one of its resistor."""
    port, pin = port_and_number(name)
    key, place = {"mode": ("MODER", 2 * pin), "pull": ("PUPDR", 2 * pin + 1),
                  "function": ("AFRH" if pin > 7 else "AFRL", 4 * (pin % 8))}[what]
    made.chip.ports[port][key] ^= 1 << place


class Registers(unittest.TestCase):
    def assert_each_is_found(self, spoils):
        """`spoils`: (what is named, what spoils it) of a board, of which each has a copy."""
        made = instant()

        def spoilt(spoil):
            spoil(made)
            made.tick(ROUND_TICKS)
            return f"{made.chip.timer.gates_on()} {gates_are_inputs(made)} {answer(made, 'status')}"

        for what, spoil in spoils:
            with self.subTest(what):
                self.assertRegex(in_a_copy(lambda spoil=spoil: spoilt(spoil)),
                                 f"^False True (?s:.*), until a reset: {re.escape(what)} is not as it was set")

    def test_each_that_changes_while_the_drive_is_ready_is_named(self):
        def spoil(made, name):
            if name == "RCC_AHB1ENR":
                made.chip.dma.clocked = lambda: True  # without it, one of its registers may be looked at first
            flip(made, name)

        self.assert_each_is_found((f"register {name}", functools.partial(spoil, name=name)) for name in FLIPS)

    def test_each_pin_that_changes_is_named(self):
        self.assert_each_is_found((f"pin {name}", functools.partial(flip_pin, name=name, what=what))
                                  for name, what in PIN_FLIPS.items())

    def test_one_that_changes_in_run_opens_the_gates_and_the_console_names_it_unasked(self):
        made = running()
        flip(made, "TIM1_ARR")
        made.tick(ROUND_TICKS)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertRegex(made.said(), "FAULT by BREAK .*, until a reset: register TIM1_ARR is not as it was set")

    def test_a_clear_does_not_bring_the_gates_back(self):
        made = running()
        flip(made, "DAC3_DHR12R1")
        made.tick(ROUND_TICKS)
        flip(made, "DAC3_DHR12R1")
        made.type("clear")
        made.tick(CALIBRATION_TICKS)
        run(made)
        made.tick(ROUND_TICKS)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertIn("register DAC3_DHR12R1 is not as it was set", made.said())

    def test_the_first_reason_is_kept(self):
        made = ready()
        flip(made, "TIM1_PSC")
        made.tick(ROUND_TICKS)
        flip(made, "TIM1_CR2")
        made.tick(ROUND_TICKS)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertTrue(gates_are_inputs(made))
        self.assertIn(", until a reset: register TIM1_PSC is not as it was set", answer(made, "status"))

    def test_one_that_does_not_take_its_value_keeps_the_drive_from_starting(self):
        made = make()
        register = register_of(made, "OPAMP2_CSR")
        register.on_read = lambda: register.value & ~(1 << 7)
        made.go_on(GIVING_UP_S)
        said = made.said()
        self.assertIn("cannot start:\r\nregister OPAMP2_CSR is not as it was set\r\n", said)
        self.assertNotIn("READY", said)

    def test_a_chip_that_is_as_it_was_set_runs_on(self):
        made = running()
        made.tick(3 * ROUND_TICKS)
        self.assertTrue(made.chip.timer.gates_on())
        self.assertNotIn("until a reset", answer(made, "status"))


class Image(unittest.TestCase):
    """The flash, in which a bit has another value than the build gave it."""

    TOLD = "the flash does not hold the image that was built"

    def flip(self, made, address):
        byte, = made.core.uc.mem_read(address, 1)
        made.core.uc.mem_write(address, bytes([byte ^ 1 << 3]))

    def places(self):
        """Bytes that the start does not need: of the table of sines, and the last of the checksum."""
        yield address_of("trig_sin_table") + 1001
        yield address_of("image_seal") + 7

    def test_one_bit_keeps_the_drive_from_starting(self):
        for place in self.places():
            with self.subTest(hex(place)):
                made = make()
                self.flip(made, place)
                made.go_on(GIVING_UP_S)
                said = made.said()
                self.assertIn(f"cannot start:\r\n{self.TOLD}\r\n", said)
                self.assertNotIn("READY", said)

    def read(self, made, name):
        """The first word of a variable."""
        return int.from_bytes(made.core.uc.mem_read(address_of(name), WORD_BYTES), "little")

    def set_length(self, made, words):
        made.core.uc.mem_write(address_of("image_seal"), words.to_bytes(WORD_BYTES, "little"))

    def test_a_length_of_none_keeps_the_drive_from_starting(self):
        made = make()
        self.set_length(made, 0)
        made.go_on(GIVING_UP_S)
        self.assertIn(f"cannot start:\r\n{self.TOLD}\r\n", made.said())

    def test_what_changes_later_opens_the_gates_and_a_whole_one_runs_on(self):
        """From where the first round is almost at its end: what was not looked at yet, and the length."""
        made = instant()
        made.tick(self.read(made, "image_seal") // WORDS_A_TICK - LAST_TICKS)

        def later(spoil):
            spoil()
            made.tick(2 * LAST_TICKS)
            return f"{gates_are_inputs(made)} {answer(made, 'status')}"

        for what, spoil, is_found in (
                ("whole", lambda: None, False),
                ("its last bits", lambda: self.flip(made, address_of("image_seal") - 1), True),
                ("its checksum", lambda: self.flip(made, address_of("image_seal") + 7), True),
                ("shorter", lambda: self.set_length(made, self.read(made, "next_word")), True)):
            with self.subTest(what):
                said = in_a_copy(lambda spoil=spoil: later(spoil))
                self.assertEqual(said.startswith("True"), is_found)
                self.assertEqual(f", until a reset: {self.TOLD}" in said, is_found)


class Memory(unittest.TestCase):
    """The RAM, of which a bit does not take what is written, or a word is another one's."""

    TOLD = "cannot start:\r\nthe RAM does not hold what is written\r\n"
    PLACES = (RAM + 0x40, RAM + WIRING.facts.ram_bytes - 4)  # the stack's end, which is not used, and what is behind all variables

    def boot(self, place, read):
        """`read` gives what the word at `place` shows, of the core and the word."""
        made = make()
        change_what_is_read(made, place, functools.partial(read, made.core.uc))
        made.go_on(GIVING_UP_S)
        return made

    def test_a_stuck_bit_keeps_the_drive_from_starting(self):
        for place in self.PLACES:
            for stuck in (lambda _, word: word | 1 << 7, lambda _, word: word & ~(1 << 30)):
                with self.subTest(hex(place)):
                    self.assertIn(self.TOLD, self.boot(place, stuck).said())

    def test_a_word_that_shows_another_one_keeps_the_drive_from_starting(self):
        place, other = self.PLACES[1], self.PLACES[1] - 0x1000

        def alias(uc, _):
            return int.from_bytes(uc.mem_read(other, WORD_BYTES), "little")

        self.assertIn(self.TOLD, self.boot(place, alias).said())

    def test_a_good_one_is_seen_as_such(self):
        said = self.boot(self.PLACES[0], lambda _, word: word).said()
        self.assertNotIn("cannot start", said)


class Clock(unittest.TestCase):
    """The clock against the watchdog's oscillator, which has another frequency on each chip: data sheet, table 44."""

    SLOW_HZ, FAST_HZ = 29.5e3, 34e3
    TOLD = "the clock has another speed than its second oscillator allows"
    FOUND_S = 0.2
    CLOCK_OFF = 0.019  # of the internal oscillator, over all temperatures: less than 2 %

    def after(self, oscillator_hz, clock, seconds):
        """So long after the clock has become so many times as fast."""
        made = ready()
        made.chip.pace.oscillator_hz = oscillator_hz / clock
        made.tick(round(seconds * STAGE["pwm_frequency_hz"]))
        return made

    def test_one_that_is_a_quarter_fast_or_slow_is_found_in_time_on_any_chip(self):
        for oscillator_hz in (self.SLOW_HZ, self.FAST_HZ):
            for clock in (0.75, 1.25, 0.5, 2):
                with self.subTest(f"{oscillator_hz} Hz, {clock}"):
                    made = self.after(oscillator_hz, clock, self.FOUND_S / 10)
                    self.assertTrue(gates_are_inputs(made))
                    self.assertIn(f", until a reset: {self.TOLD}", answer(made, "status"))

    def test_one_within_the_tolerances_of_both_oscillators_is_not(self):
        for oscillator_hz in (self.SLOW_HZ, self.FAST_HZ):
            for clock in (1 - self.CLOCK_OFF, 1 + self.CLOCK_OFF):
                with self.subTest(f"{oscillator_hz} Hz, {clock}"):
                    made = self.after(oscillator_hz, clock, self.FOUND_S / 10)
                    self.assertNotIn("until a reset", answer(made, "status"))

    def test_an_oscillator_that_stands_still_is_found_in_time(self):
        made = self.after(0, 1, self.FOUND_S)
        self.assertTrue(gates_are_inputs(made))
        self.assertIn(", until a reset: the second oscillator stands still", answer(made, "status"))

    def test_in_run_the_gates_open(self):
        made = running()
        made.chip.pace.oscillator_hz /= 1.25
        made.tick(ROUND_TICKS)
        self.assertFalse(made.chip.timer.gates_on())
        self.assertIn(self.TOLD, made.said())

    def test_a_background_that_comes_late_for_a_while_finds_nothing(self):
        made = running()
        for _ in range(20):
            made.tick(5, background=1)
            made.tick(2)
        self.assertTrue(made.chip.timer.gates_on())


class Trip(unittest.TestCase):
    """The way from the level to the gates, which the start tries without current."""

    def refuses(self, spoil):
        made = make()
        spoil(made)
        made.go_on(GIVING_UP_S)
        self.assertFalse(made.chip.timer.gates_on())
        said = made.said()
        self.assertIn("cannot start:\r\n", said)
        return said.split("cannot start:\r\n")[1].strip()

    def test_the_gates_never_open_while_it_is_tried_and_the_comparators_are_locked_behind(self):
        made = make()
        seen = []
        timer = made.chip.timer
        write = timer.register("BDTR").on_write

        def look(value):
            write(value)
            seen.append((timer["BDTR"] >> 15 & 1, timer.gates_on()))

        timer.register("BDTR").on_write = look
        made.boot()
        self.assertIn((1, False), seen)
        self.assertNotIn(True, [gates for _, gates in seen])
        for number in COMPARATORS.values():
            self.assertEqual(made.chip.comparators[f"{number}_CSR"] >> 31, 1)

    def test_a_comparator_that_never_trips_is_named_by_its_phase(self):
        for phase, number in COMPARATORS.items():
            def spoil(made, number=int(number)):
                output = made.chip.comparators.output
                made.chip.comparators.output = lambda asked: False if asked == number else output(asked)

            with self.subTest(phase):
                self.assertEqual(self.refuses(spoil), f"the comparator of phase {phase} does not open the gates")

    def test_a_comparator_that_always_trips_is_found(self):
        for number in COMPARATORS.values():
            def spoil(made, number=int(number)):
                output = made.chip.comparators.output
                made.chip.comparators.output = lambda asked: (
                    bool(made.chip.comparators[f"{asked}_CSR"] & 1) if asked == number else output(asked))

            with self.subTest(number):
                self.assertEqual(self.refuses(spoil), "a phase trips at rest")

    def test_a_level_that_does_not_follow_its_register_is_found(self):
        for phase in "ab":
            def spoil(made, phase="ab".index(phase)):
                dac, channel = made.level_of(phase)
                voltage = dac.voltage
                dac.voltage = lambda asked: 1000 if asked == channel else voltage(asked)

            with self.subTest(phase):
                self.assertEqual(self.refuses(spoil), f"the comparator of phase {phase} does not open the gates")

    def test_a_break_that_does_not_reach_the_main_output_is_found(self):
        def spoil(made):
            made.chip.timer.set_break_input = lambda active: None

        self.assertEqual(self.refuses(spoil), "the comparator of phase a does not open the gates")

    def test_a_main_output_that_does_not_come_on_is_found(self):
        def spoil(made):
            timer = made.chip.timer
            timer.register("BDTR").on_read = lambda: timer["BDTR"] & ~MAIN_OUTPUT

        self.assertEqual(self.refuses(spoil), "the timer does not enable its output")

    def test_a_comparator_that_trips_for_a_moment_only_is_found(self):
        def spoil(made):
            timer, was_active = made.chip.timer, False
            trip = timer.set_break_input

            def at_the_edge(active):
                nonlocal was_active
                trip(active and not was_active)
                was_active, timer.broken = active, False

            timer.set_break_input = at_the_edge

        self.assertEqual(self.refuses(spoil), "the comparator of phase a does not open the gates")

    def test_a_main_output_that_goes_off_without_the_flag_of_the_break_is_found(self):
        def spoil(made):
            timer = made.chip.timer
            timer.register("SR").on_read = lambda: timer["SR"] & ~BREAK_FLAG

        self.assertEqual(self.refuses(spoil), "the comparator of phase a does not open the gates")

    def test_a_flag_of_the_break_that_leaves_the_main_output_on_is_found(self):
        def spoil(made):
            timer = made.chip.timer
            trip = timer.set_break_input

            def only_the_flag(active):
                output = timer["BDTR"] & MAIN_OUTPUT
                trip(active)
                timer["BDTR"] |= output

            timer.set_break_input = only_the_flag

        self.assertEqual(self.refuses(spoil), "the comparator of phase a does not open the gates")

    def test_a_flag_of_the_break_that_cannot_be_cleared_is_found(self):
        def spoil(made):
            timer = made.chip.timer
            timer.register("SR").on_read = lambda: timer["SR"] | BREAK_FLAG

        self.assertEqual(self.refuses(spoil), "a phase trips at rest")

    def test_a_flag_of_the_break_that_stays_once_it_came_is_found(self):
        def spoil(made):
            timer, came = made.chip.timer, False
            trip = timer.set_break_input

            def note(active):
                nonlocal came
                came = came or (active and bool(timer["BDTR"] & MAIN_OUTPUT))
                trip(active)

            timer.set_break_input = note
            timer.register("SR").on_read = lambda: timer["SR"] | (BREAK_FLAG if came else 0)

        self.assertEqual(self.refuses(spoil), "the comparator of phase a does not open the gates")

    def test_a_comparator_that_stays_tripped_is_found(self):
        def spoil(made):
            timer, stays = made.chip.timer, False
            trip = timer.set_break_input

            def for_ever(active):
                nonlocal stays
                stays = stays or (active and bool(timer["BDTR"] & MAIN_OUTPUT))
                trip(active or stays)

            timer.set_break_input = for_ever

        self.assertEqual(self.refuses(spoil), "the comparator of phase a does not open the gates")

    def test_on_any_of_many_boards_it_passes(self):
        for choose in (analogue.least, analogue.most, *map(analogue.drawn, range(4))):
            self.assertNotIn("cannot start", booted(choose=choose).said())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
