# SPDX-License-Identifier: MIT
"""target.shaft: a sensor of the shaft, from the pins of the chip to what the binding tells the control interrupt.

test_shaft.py IMAGE BOARD CLOCK [TEST...]: an image of probe.c on a board with Hall sensors, with an incremental encoder, or with an
absolute one. What belongs to another sensor than the board's is left out.
"""

import random
import sys
import unittest

import digital
import rig
from probed import Probe

WIRING = rig.WIRING
IS_ABSOLUTE, IS_HALL = bool(WIRING.spi), bool(WIRING.hall)
QUADRATURE = ((0, 0), (1, 0), (1, 1), (0, 1))  # of A and B, forwards
FILTER_S = 16 / digital.CLOCK_HZ               # 8 samples at half the clock
EDGE_S = 2e-6                                  # from one edge to the next
WRAP = 1 << 16
ANGLES = 1 << 14
TICK = digital.CLOCK_HZ / rig.STAGE["pwm_frequency_hz"]
ERROR, PARITY = 1 << 14, 1 << 15
NOBODY, STUCK = 0xFFFF, 0x0000


def age(probe):
    """Of the last Hall edge, in ticks."""
    return (probe.word("readings") >> 16) / 256


def reading(probe):
    return probe.word("readings") & 0xFFFF


@unittest.skipUnless(IS_HALL, "the board has no Hall sensors")
class Hall(unittest.TestCase):
    def test_each_pattern_is_read_with_sensor_1_as_its_lowest_bit(self):
        probe = Probe()
        for pattern in (0, 1, 3, 2, 6, 4, 5, 7, 0):
            for sensor, pin in enumerate(WIRING.hall):
                probe.chip.signals.set(pin, pattern >> sensor & 1)
            probe.tick()
            self.assertEqual(reading(probe), pattern)

    def test_an_open_wire_is_high(self):
        probe = Probe()
        for sensor, pin in enumerate(WIRING.hall):
            for other in WIRING.hall:
                probe.chip.signals.set(other, 0)
            probe.chip.signals.set(pin, None)
            probe.tick()
            self.assertEqual(reading(probe), 1 << sensor)

    def edge_at(self, share):
        """The age, in ticks, that a tick reads of an edge at this part of the time from the end of the tick before to its own."""
        probe = Probe()
        signals = probe.chip.signals
        for pin in WIRING.hall:
            signals.set(pin, 0)
        probe.tick(4)
        signals.play(WIRING.hall[1], [(probe.chip.now + round(share * TICK), 1)])
        probe.tick()
        self.assertEqual(reading(probe), 2)
        return probe, age(probe)

    def test_the_age_of_an_edge_is_the_time_since_then(self):
        """To 1/256 of a tick, downwards, and an instruction."""
        _, first = self.edge_at(0)
        for share in (0.1, 0.25, 0.5, 0.8):
            _, later = self.edge_at(share)
            self.assertAlmostEqual(first - later, share, delta=1.5 / 256)

    def test_an_edge_grows_old_by_a_tick_in_each_tick(self):
        probe, first = self.edge_at(0.5)
        probe.tick()
        self.assertAlmostEqual(age(probe) - first, 1, delta=1.5 / 256)

    def test_each_edge_of_each_signal_counts_and_what_the_filter_takes_does_not(self):
        probe, first = self.edge_at(0.5)
        signals = probe.chip.signals
        for pin, level in zip(2 * WIRING.hall, (1, 0, 1, 0, 1, 0)):
            signals.play(pin, [(probe.chip.now + round(0.5 * TICK), level)])
            probe.tick()
            self.assertAlmostEqual(age(probe), first, delta=1.5 / 256)
        now = probe.chip.now + round(0.5 * TICK)
        signals.play(WIRING.hall[0], [(now, 1), (now + round(0.9 * FILTER_S * digital.CLOCK_HZ), 0)])
        probe.tick()
        self.assertAlmostEqual(age(probe), first + 1, delta=1.5 / 256)


@unittest.skipUnless(WIRING.encoder and not IS_HALL and not IS_ABSOLUTE, "the board has no incremental encoder")
class Encoder(unittest.TestCase):
    def setUp(self):
        self.probe = Probe()
        self.position = 0
        for pin in WIRING.encoder:
            self.probe.chip.signals.set(pin.name, 0)
        self.probe.tick(2)
        self.zero = reading(self.probe)

    def turn(self, counts, index_at=None):
        """So many counts, each of which lasts EDGE_S; the index is high at one count."""
        signals, now = self.probe.chip.signals, self.probe.chip.now
        pins = [pin.name for pin in WIRING.encoder]
        step = 1 if counts > 0 else -1
        for k in range(1, abs(counts) + 1):
            self.position += step
            at = now + round(k * EDGE_S * digital.CLOCK_HZ)
            for pin, level in zip(pins, QUADRATURE[self.position % 4]):
                signals.play(pin, [(at, level)])
            if len(pins) > 2 and index_at is not None:
                middle = at + round(EDGE_S / 2 * digital.CLOCK_HZ)
                signals.play(pins[2], [(middle, int(self.position == index_at))])
        self.probe.go_on((abs(counts) + 1) * EDGE_S)
        self.probe.tick(2)

    def assert_reads(self, position):
        self.assertEqual((reading(self.probe) - self.zero) % WRAP, position % WRAP)

    def test_it_counts_each_edge_up_when_a_leads_and_down_when_b_does(self):
        for counts in (1, 1, 1, 1, 250, -1, -3, -700, 444):
            self.turn(counts)
            self.assert_reads(self.position)

    def test_it_wraps_at_sixteen_bits_both_ways(self):
        self.probe.chip.encoder.counted = WRAP - 5
        self.zero = -5 % WRAP
        for counts in (12, -20, 30):
            self.turn(counts)
            self.assert_reads(self.position)

    def test_a_pair_of_edges_within_the_filter_is_not_counted_even_if_it_lasts(self):
        now = self.probe.chip.now
        cycles = round(0.9 * FILTER_S * digital.CLOCK_HZ)
        self.probe.chip.signals.play(WIRING.encoder[0].name, [(now + 4000 * k + at, level) for k in range(1, 20)
                                                             for at, level in ((0, 1), (cycles, 0))])
        self.probe.tick(4)
        self.assert_reads(0)

    def test_a_disturbed_edge_counts_once(self):
        """It bounces: up and down and up again."""
        now, pin = self.probe.chip.now, WIRING.encoder[0].name
        self.probe.chip.signals.play(pin, [(now + 4000 + 100 * k, (k + 1) % 2) for k in range(21)])
        self.probe.tick(3)
        self.assert_reads(1)

    def test_the_count_at_the_index_is_told_once_and_both_ways(self):
        for counts, at in ((100, 37), (-100, 37), (40, 5)):
            before = self.probe.word("indexes")
            self.turn(counts, index_at=at)
            self.assertEqual(self.probe.word("indexes"), before + 1)
            index = self.probe.word("readings") >> 16
            self.assertEqual((index - self.zero) % WRAP, at)
            self.probe.tick(3)
            self.assertEqual(self.probe.word("indexes"), before + 1)

    def test_it_follows_a_random_walk_to_the_count(self):
        draw = random.Random(7)
        for _ in range(20):
            self.turn(draw.choice((-1, 1)) * draw.randrange(1, 120))
            self.assert_reads(self.position)


@unittest.skipUnless(IS_ABSOLUTE, "the board has no absolute encoder")
class Absolute(unittest.TestCase):
    def setUp(self):
        self.probe = Probe()
        self.encoder = self.probe.chip.absolute

    def frame(self, angle, error=0):
        value = angle | (ERROR if error else 0)
        return value | (PARITY if value.bit_count() % 2 else 0)

    def test_a_tick_reads_the_angle_at_the_beginning_of_the_tick_before(self):
        draw = random.Random(3)
        self.probe.tick(2)
        angles = [draw.randrange(ANGLES) for _ in range(50)]
        for before, angle in zip([None, *angles], angles):
            self.encoder.angle = angle  # until the next tick has begun
            self.probe.tick()
            if before is not None:
                self.assertEqual(reading(self.probe), self.frame(before))

    def test_the_first_tick_reads_an_angle_and_not_the_answer_to_no_question(self):
        probe = Probe()
        probe.chip.absolute.angle = 4711
        probe.tick(2)
        self.assertEqual(reading(probe), self.frame(4711))

    def test_a_sensor_that_does_not_answer_reads_as_an_error(self):
        self.encoder.state = self.encoder.DEAD
        self.probe.tick(3)
        self.assertEqual(reading(self.probe), NOBODY)
        self.encoder.state, self.encoder.angle = None, 99
        self.probe.tick(3)
        self.assertEqual(reading(self.probe), self.frame(99))

    def test_a_wire_that_is_stuck_is_read_as_it_is(self):
        self.encoder.state = self.encoder.STUCK
        self.probe.tick(3)
        self.assertEqual(reading(self.probe), STUCK)

    def test_flipped_bits_and_the_error_flag_come_through(self):
        self.encoder.angle = 1000
        for flip in (1, 1 << 7, PARITY):
            self.encoder.flip = flip
            self.probe.tick(2)
            self.assertEqual(reading(self.probe), self.frame(1000) ^ flip)
        self.encoder.flip, self.encoder.error = 0, True
        self.probe.tick(2)
        self.assertEqual(reading(self.probe), self.frame(1000, error=1))

    def test_of_two_frames_the_newer_one_is_read_and_the_next_ticks_are_not_behind(self):
        self.encoder.angle = 1234
        self.probe.tick(2)
        self.probe.chip.spi.received.insert(0, self.frame(99))
        for angle in (1300, 1400, 1500):
            before, self.encoder.angle = self.encoder.angle, angle
            self.probe.tick()
            self.assertEqual(reading(self.probe), self.frame(before))

    def test_a_frame_that_is_under_way_when_a_tick_begins_is_left_alone(self):
        self.encoder.angle = 1234
        self.probe.tick(2)
        self.probe.chip.spi.due += round(digital.CLOCK_HZ / rig.STAGE["pwm_frequency_hz"])
        self.encoder.angle = 2000
        self.probe.tick()
        self.assertEqual(reading(self.probe), NOBODY)  # it has not come
        self.probe.tick()
        self.assertEqual(reading(self.probe), self.frame(1234))
        self.probe.tick()
        self.assertEqual(reading(self.probe), self.frame(2000))

    def test_no_command_is_wrong(self):
        self.probe.tick(20)
        self.assertFalse(self.encoder.error)
        self.assertGreaterEqual(len(self.encoder.frames), 20)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
