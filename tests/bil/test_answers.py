# SPDX-License-Identifier: MIT
"""target.loop.answers: the image waits for registers of the chip; these answer at once, late, or never.

test_answers.py IMAGE BOARD CLOCK [TEST...], as scenario.py. Each wait is bounded: the image says what does not answer, opens
no gate and does not go on.
"""

import sys
import unittest
from dataclasses import dataclass

import board
import flash
from digital import CLOCK_HZ, NEVER
from rig import CALIBRATION_TICKS, make

LONG = round(0.3e-3 * CLOCK_HZ)  # beyond all that is waited for but the timer's update; the watchdog does not bite yet
PATIENCE = 600_000              # looks at a register until the image gives it up, and one more
SOME_LOOKS = 4
GIVING_UP_S = 1.0               # longer than that, at the oscillator's 16 MHz too
LOOK_S = 0.02                   # and so often is looked whether it has

CLOCK_TOLD = "the clock does not settle"
DAC_TOLD = "the trip level's DAC does not become ready"
ADC_TOLD = "a converter does not become ready"
TIMER_TOLD = "the timer does not update at its peak"
WATCHDOG_TOLD = "the watchdog does not start"


@dataclass(frozen=True)
class Wait:
    """For the bits `mask` of a register; `refused`: what they are as long as it does not answer."""

    block: str
    key: str
    mask: int
    refused: int
    told: str = ""    # if it never answers
    answers: int = 0  # how often it does before that
    behind: int = 0   # bits that the image sets in the same register before it waits


COUNTED = Wait("SYSTEM", "SYST_CSR", 1 << 16, 0)  # a time that has passed: the image goes on without
PEAK = Wait("TIM1", "CR1", 1 << 4, 0, TIMER_TOLD, behind=1)
ALWAYS_DOWN = Wait("TIM1", "CR1", 1 << 4, 1 << 4, behind=1)
WAITS = (
    Wait("PWR", "CR5", 1 << 8, 1 << 8, CLOCK_TOLD),
    Wait("PWR", "SR2", 1 << 10, 1 << 10, CLOCK_TOLD),
    Wait("FLASH", "ACR", 0xF, 0, CLOCK_TOLD, behind=1 << 8),
    Wait("RCC", "CR", 1 << 10, 0, CLOCK_TOLD),
    Wait("RCC", "CR", 1 << 25, 0, CLOCK_TOLD),
    Wait("RCC", "CFGR", 3 << 2, 1 << 2, CLOCK_TOLD),
    *(Wait("DAC3", "SR", 1 << bit, 0, DAC_TOLD) for bit in (11, 27)),
    *(Wait(converter, "CR", 1 << 31, 1 << 31, ADC_TOLD) for converter in ("ADC1", "ADC2")),
    *(Wait(converter, "ISR", 1 << bit, 0, ADC_TOLD) for bit in (0, 2) for converter in ("ADC1", "ADC2")),
    Wait("ADC1", "ISR", 1 << 2, 0, ADC_TOLD, answers=1),
    Wait("TIM1", "SR", 1 << 0, 0, TIMER_TOLD),
    Wait("TIM1", "SR", 1 << 0, 0, TIMER_TOLD, answers=3),
    Wait("IWDG", "SR", 3, 3, WATCHDOG_TOLD),
)
ONCE_EACH = [wait for wait in (*WAITS, COUNTED) if wait.answers == 0]


def block_of(made, wait):
    return next(one for one in made.chip.blocks if one.name == wait.block)


def register_of(made, wait):
    return block_of(made, wait).register(wait.key)


def hook(made, wait, refuses, for_ever=False):
    """`refuses` says of each look whether there is no answer yet, from whether the chip has one; with `for_ever` what it
    has refused once it goes on to refuse, and is not asked at each of the looks that follow one another."""
    register = register_of(made, wait)
    address, = (at for at, (key, _) in block_of(made, wait).by_address.items() if key == wait.key)
    before = register.on_read or (lambda: register.value)

    def read():
        value = before()
        refused = value & wait.behind == wait.behind and refuses(value & wait.mask != wait.refused)
        shown = value & ~wait.mask | wait.refused if refused else value
        if refused and for_ever:
            made.chip.hold(address, shown)
        return shown

    register.on_read = read


def never(answers=0):
    given, had = 0, False

    def refuses(has):
        nonlocal given, had
        given += has and not had
        had = has
        return given > answers

    return refuses


def late(looks):
    """Each answer is there at this look, and not before."""
    left = looks

    def refuses(has):
        nonlocal left
        left = left - 1 if has and left else left if has else looks
        return has and left > 0

    return refuses


def pass_time(made, wait):
    """Before each look there is time for what it is for. Where nothing runs yet, or an exception comes in place of a flag, a
    look is for something else."""
    register = register_of(made, wait)
    before = register.on_read or (lambda: register.value)

    def is_awaited(value):
        runs = wait.block != "TIM1" or made.chip.timer.due != NEVER
        return runs and value & wait.mask == wait.refused and not (wait == COUNTED and value & 2)

    def read():
        value = before()
        if is_awaited(value):
            made.chip.advance(made.chip.timer.due - made.chip.now if wait.block == "TIM1" else LONG)
            value = before()
        return value

    register.on_read = read


class Answers(unittest.TestCase):
    def boot(self, waits, answer):
        made = make()
        kept = {register: register.on_read for register in (register_of(made, wait) for wait in waits)}
        for wait in waits:
            answer(made, wait)
        made.boot()
        for register, read in kept.items():
            register.on_read = read
        made.tick(CALIBRATION_TICKS)
        said = made.said()
        self.assertIn("READY", said)
        self.assertNotIn("cannot start", said)

    def test_at_once_it_boots(self):
        self.boot(ONCE_EACH, pass_time)

    def test_some_looks_later_it_boots(self):
        self.boot([wait for wait in ONCE_EACH if wait != COUNTED], lambda made, wait: hook(made, wait, late(SOME_LOOKS)))

    def test_a_time_whose_end_is_never_told_does_not_keep_it(self):
        refuses = late(PATIENCE + 2)
        self.boot([COUNTED], lambda made, wait: hook(made, wait, lambda has: refuses(True)))

    def test_times_whose_ends_are_never_told_do_not_keep_it(self):
        def never_told(made, wait):
            register_of(made, wait).on_read = None  # a flag that was read would be set again by the next time
            hook(made, wait, lambda _: True, for_ever=True)

        self.boot([COUNTED], never_told)

    def test_a_direction_that_never_changes_does_not_keep_it(self):
        self.boot([ALWAYS_DOWN], lambda made, wait: hook(made, wait, lambda _: True, for_ever=True))

    def tells(self, wait, options=flash.GOOD_OPTIONS, **arguments):
        made = make(**arguments)
        made.chip.power.flash["OPTR"] = options
        watchdog = made.chip.watchdog
        watchdog.fire = lambda: setattr(watchdog, "due", NEVER)  # what if it did not bite either
        hook(made, wait, never(wait.answers), for_ever=True)
        said = ""
        for _ in range(round(GIVING_UP_S / LOOK_S)):
            made.go_on(LOOK_S)
            said += made.chip.usart.heard()
            if said.endswith(f"{wait.told}\r\n"):
                break
        self.assertIn(f"cannot start:\r\n{wait.told}\r\n", said)
        self.assertNotIn("READY", said)
        self.assertFalse(made.chip.timer.gates_on())
        return said

    def test_never_it_says_what_does_not_and_stays(self):
        for wait in (*WAITS, PEAK):
            with self.subTest(wait):
                self.tells(wait)

    def test_behind_the_watchdog_it_says_both(self):
        self.assertIn("last reset: watchdog", self.tells(WAITS[0], reset_flags=board.WATCHDOG_FLAG))

    def test_behind_an_option_byte_that_protects_less_it_says_both(self):
        self.assertIn("no parity of the RAM", self.tells(WAITS[0], options=flash.GOOD_OPTIONS ^ flash.NO_PARITY))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
