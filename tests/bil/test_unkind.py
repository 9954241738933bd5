# SPDX-License-Identifier: MIT
"""target.loop.unkind: the image on a board that has tolerances, disturbances and a user, and takes its time.

test_unkind.py IMAGE BOARD CLOCK [TEST...], as scenario.py; all tests, or those named.
"""

import re
import sys
import unittest

import analogue
import board
from copies import in_a_copy
from rig import answer, instant, ready, running

SEEDS = range(8)
ALIGN_TICKS = 400  # from `run` on, to where ticks are as long as they will be for a while
LATE_TICKS = 40  # every other one: more than the drive bears
SLOW_ROUND = 40  # ticks in which each part of the slow schedule has its turn
TYPING_S = 5e-3  # more than a short line takes
LINE_MAX = 512  # characters that the console keeps to be sent
TOLD_TICKS = 4    # the pass that was under way, which may go beyond a tick, and the one that tells
LEAST_ACCESSES = 10  # flags twice each, demand, count and the gates: fewer would be another register
SPIKE_S = 100e-9  # as the switches make when they turn on; the filter has 141 ns


def tripping(made, phase=0):
    """(pin, count) of a shunt that carries more than the trip level."""
    pin = made.wiring.shunts[phase]
    dac, channel = made.level_of(phase)
    level = dac[f"DHR12R{channel}"]
    above = level >= made.chip.pins[pin]
    return pin, level + (5 if above else -5)


def lasting(made):
    """A break that the filter lets through."""
    made.chip.spike(*tripping(made), 2 * SPIKE_S)


def hang(made):
    """The tick goes on only when its guard has come."""
    made.chip.advance(made.chip.system.due - made.chip.now)


class Parts(unittest.TestCase):
    def test_any_of_many_boards_comes_to_ready_without_a_fault(self):
        for seed in SEEDS:
            with self.subTest(seed):
                said = ready(choose=analogue.drawn(seed)).said()
                self.assertIn("READY", said)
                self.assertNotIn("FAULT", said)


class Break(unittest.TestCase):
    def test_a_spike_of_turning_on_does_not_pass_the_filter(self):
        made = running()
        made.chip.spike(*tripping(made), SPIKE_S)
        self.assertTrue(made.chip.timer.gates_on())

    def test_what_lasts_twice_as_long_opens_the_gates(self):
        made = running()
        lasting(made)
        self.assertFalse(made.chip.timer.gates_on())


class EachAccess(unittest.TestCase):
    """Of the tick to the timer, also while the gates are being enabled: what comes there leaves them open and reaches the
    drive. Between two accesses it does the same as right before the second one."""

    def test_a_break(self):
        self.assert_stops_at_each(lasting)

    def test_the_tick_guard(self):
        self.assert_stops_at_each(hang)

    def assert_stops_at_each(self, disturb):
        for start in (self.enabling, running):
            with self.subTest(start.__name__):
                seen = self.disturbed_at_each(start(), disturb)
                self.assertGreater(len(seen), LEAST_ACCESSES)
                self.assertEqual(set(seen), {"open, FAULT by BREAK"})

    def enabling(self):
        made = instant()
        made.type("run")
        made.said()
        made.tick_to_search()
        return made

    def disturbed_at_each(self, made, disturb):
        """What came of it before each of them, and behind the last."""
        seen = []
        made.chip.wait_for_exception()
        while True:
            how, _, said = in_a_copy(lambda: self.disturbed(made, disturb, len(seen))).partition("\n")
            seen.append(said)
            if how == "behind":
                return seen

    def disturbed(self, made, disturb, access):
        """Before that access of the next tick, or behind the last one if there are no more."""
        left = access

        def counted(act):
            def at(address, *what):
                nonlocal left
                if address in made.chip.timer.by_address:
                    if left == 0:
                        disturb(made)
                    left -= 1
                return act(address, *what)
            return at

        bus = made.core.bus
        bus.read, bus.write = counted(bus.read), counted(bus.write)
        made.core.handle(made.chip.system.take(board.THREAD))
        behind = left >= 0
        left = -1  # of this tick
        if behind:
            disturb(made)
            if made.chip.system.pending:
                made.core.handle(made.chip.system.take(board.THREAD))
        open_then = not made.chip.timer.gates_on()
        made.tick(TOLD_TICKS)
        open_now = not made.chip.timer.gates_on()
        said = re.search(r"FAULT by \w+", made.said())
        gates = "open" if open_then and open_now else "closed again"
        return f"{'behind' if behind else 'before'}\n{gates}, {said[0] if said else 'nothing said'}"


class Line(unittest.TestCase):
    def test_after_an_overrun_the_console_hears_again(self):
        made = ready()
        made.said()
        made.chip.usart.overrun = True  # bytes came while nobody took them
        made.go_on(TYPING_S)
        made.chip.usart.receive(b"status\r")
        made.go_on(TYPING_S)
        self.assertIn("READY, speed unknown, asked 0 rpm", made.said())

    def test_a_byte_with_a_wrong_stop_bit_is_left_out_and_the_next_one_is_not(self):
        made = ready()
        made.said()
        usart = made.chip.usart
        usart.receive(b"sta")
        for byte in b"x\r":
            usart.receive_broken(byte)
        usart.receive(b"tus\r")
        made.go_on(TYPING_S)
        self.assertIn("READY, speed unknown, asked 0 rpm", made.said())

    def test_what_comes_while_nobody_takes_it_sets_the_flag(self):
        usart = ready().chip.usart
        usart.receive(b"x" * (usart.FIFO + 1))
        usart.chip.clock.now += usart.byte_cycles() * (usart.FIFO + 2)
        self.assertTrue(usart.register("ISR").on_read() & 1 << 3)

    def test_what_does_not_fit_is_cut_and_each_line_keeps_its_end(self):
        made = ready()
        made.said()
        for _ in range(LINE_MAX // 60):
            made.type("status")
        said = made.said()
        self.assertTrue(said.endswith("\r\n"))
        for line in said.split("\r\n"):
            self.assertLessEqual(line.count("READY"), 1, line)
        self.assertRegex(answer(made, "status"), r"^READY, .* %, last reset: pin\r\n$")


class Slow(unittest.TestCase):
    def stretch(self, made, share):
        """Every other tick takes a share of its period, the longest of a slow round this one; no more of them, for the
        background would starve the watchdog."""
        handle, ticks, longest = made.core.handle, 0, 0
        period = 2 * made.chip.timer["ARR"]

        def timed(*arguments):
            nonlocal longest
            start = made.chip.now
            try:
                return handle(*arguments)
            finally:
                longest = max(longest, made.chip.now - start)

        made.core.handle = timed
        made.tick(SLOW_ROUND)
        factor = round(share * period / longest)

        def slow(*arguments):
            nonlocal ticks
            ticks += 1
            made.chip.clock.cycle = factor if ticks % 2 else 1
            try:
                return handle(*arguments)
            finally:
                made.chip.clock.cycle = 1

        made.core.handle = slow

    def late(self, share):
        """As long as the drive runs: nobody can say anything behind that in what such ticks leave of the time."""
        made = running()
        made.tick(ALIGN_TICKS)
        in_time = made.core.handle
        self.stretch(made, share)
        for _ in range(LATE_TICKS):
            if made.chip.timer.gates_on():
                made.tick()
        made.core.handle = in_time
        return made

    def test_ticks_that_take_longer_than_their_period_are_late_and_the_drive_says_so(self):
        made = self.late(1.6)
        self.assertIn("FAULT by LATE", made.said())
        self.assertFalse(made.chip.timer.gates_on())

    def test_ticks_that_take_most_of_their_period_are_in_time(self):
        made = self.late(0.8)
        self.assertNotIn("LATE", made.said())
        self.assertIn(" late 0,", answer(made, "status"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
