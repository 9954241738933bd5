# SPDX-License-Identifier: MIT
"""target.inputs: throttle, button and pulses, from the pins of the chip to what the binding tells.

test_inputs.py IMAGE BOARD CLOCK [TEST...]: an image of probe.c. A few runs of each test that draws, or many if they are asked for.
"""

import random
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import digital
import many_runs
import rig
from probed import PULSE_HZ, UNIT, Probe, decoded, dshot, dshot_frame, servo

RUNS = many_runs.of(4, 40, 300)
FILTER_S = 32 / digital.CLOCK_HZ  # 8 samples at a quarter of the clock
COUNT = 1                         # an edge is counted in whole units, and a width is of two edges
HELD = 47                         # pulses that the binding holds
SLOTS = HELD + 1
LOST_LATER = 2                    # the two rings notice an overrun of whole rounds one after the other, by the next pulses
REGULAR_TICKS = 128               # from one conversion of the throttle to the next
OLDEST_TICKS = 2 * REGULAR_TICKS + 2
WRAP = 1 << 32


def is_near(one, other):
    """Whether two times are the same, counted in whole units."""
    difference = (one - other + WRAP / 2) % WRAP - WRAP / 2
    return abs(difference) <= COUNT


class Pulses(unittest.TestCase):
    def assert_measured(self, found, sent):
        """Each pulse, in order."""
        delay = FILTER_S * PULSE_HZ
        self.assertEqual(len(found), len(sent))
        for (start, width), (sent_start, sent_width) in zip(found, sent):
            self.assertTrue(is_near(start, sent_start + delay), f"{start} is not {sent_start + delay}")
            self.assertLessEqual(abs(width - sent_width), COUNT)

    def assert_some_of(self, found, sent):
        """Each that was found is one that was sent, in order, and none twice."""
        delay = FILTER_S * PULSE_HZ
        rest = iter(sent)
        for start, width in found:
            self.assertTrue(any(is_near(start, sent_start + delay) and abs(width - sent_width) <= COUNT
                                for sent_start, sent_width in rest), f"nobody has sent {start}, {width}")

    def test_those_of_a_servo_tester_are_measured(self):
        for width_s, rate_hz in ((1e-3, 50), (1.5e-3, 333), (2e-3, 490)):
            with self.subTest(width=width_s, rate=rate_hz):
                probe = Probe()
                sent = probe.send(servo(4, width_s, rate_hz, jitter_s=1e-6))
                self.assert_measured(probe.pulses(), sent)

    def test_frames_of_dshot_are_measured_bit_by_bit(self):
        frames = [dshot_frame(value, value % 3 == 0) for value in (0, 48, 1046, 2047, 1365)]
        for kilobaud in (150, 300, 600):
            with self.subTest(kilobaud=kilobaud):
                probe = Probe()
                sent = probe.send(dshot(frames, kilobaud, gap_s=100e-6, jitter=0.05, seed=kilobaud))
                found = probe.pulses()
                self.assert_measured(found, sent)
                self.assertEqual(decoded(found, kilobaud), frames)

    def test_two_frames_at_once_are_held_while_the_background_is_busy(self):
        frames = [dshot_frame(1000), dshot_frame(1001)]
        probe = Probe()
        probe.pause(True)
        sent = probe.send(dshot(frames, 600, gap_s=2e-6))
        self.assertEqual(probe.pulses(), [])
        probe.pause(False)
        probe.tick(3)
        found = probe.pulses()
        self.assert_measured(found, sent)

    def test_the_time_may_wrap_within_a_pulse(self):
        probe = Probe()
        probe.chip.capture.settle()
        probe.chip.capture.counted = WRAP - round((0.001 + 1 / 400 + 0.0007) * PULSE_HZ)
        sent = probe.send(servo(3, 1.5e-3, 400))
        found = probe.pulses()
        self.assertLess(found[2][0], found[1][0])
        self.assert_measured(found, sent)

    def test_a_line_that_is_high_at_the_start_is_no_pulse(self):
        probe = Probe(level=1)
        probe.play([(0.001, 0)])
        sent = probe.send(servo(2, 1e-3, 400))
        self.assert_measured(probe.pulses(), sent)

    def test_a_line_that_stays_where_it_is_gives_no_pulses(self):
        for level in (0, 1, None):
            probe = Probe()
            probe.chip.signals.set(probe.pin, level)
            probe.go_on(0.02)
            self.assertEqual(probe.pulses(), [])

    def test_the_present_time_is_on_the_scale_of_the_edges(self):
        probe = Probe()
        probe.send(servo(1, 1e-3, 50))
        (start, width), = probe.pulses()
        tick = PULSE_HZ / rig.STAGE["pwm_frequency_hz"]
        self.assertLess(start + width, probe.word("now"))
        self.assertLess(probe.word("now") - start - width, 4 * tick)

    def test_what_is_shorter_than_the_filter_is_not_seen_in_either_level(self):
        short = FILTER_S * 0.9
        probe = Probe()
        probe.play([(0.001, 1), (0.001 + short, 0)])
        self.assertEqual(probe.pulses(), [])
        probe.play([(0.001, 1), (0.0015, 0), (0.0015 + short, 1), (0.002, 0)])
        (_, width), = probe.pulses()
        self.assertLessEqual(abs(width - 0.001 * PULSE_HZ), COUNT)

    def test_a_runt_that_passes_the_filter_is_a_pulse_of_its_own(self):
        probe = Probe()
        sent = probe.send([(0.001, 1.5 * FILTER_S), (0.001 + 5 * FILTER_S, 2 * FILTER_S)])
        self.assert_measured(probe.pulses(), sent)

    def test_after_an_overrun_those_that_are_given_were_sent_so_and_all_that_follow_come(self):
        for seed in range(RUNS):
            with self.subTest(seed=seed):
                draw = random.Random(seed)
                probe = Probe()
                probe.send(servo(draw.randrange(1, SLOTS), 20e-6, 20e3))
                probe.pulses()
                probe.pause(True)
                count = draw.choice((HELD - 1, HELD, SLOTS, SLOTS + 1, 2 * SLOTS, draw.randrange(SLOTS, 5 * SLOTS)))
                sent = probe.send([(50e-6 * (k + 1), draw.uniform(1e-6, 40e-6)) for k in range(count)])
                probe.pause(False)
                probe.tick(3)
                found = probe.pulses()
                self.assert_some_of(found, sent)
                if count <= HELD:
                    self.assertEqual(len(found), count)
                later = probe.send([(50e-6 * (k + 1), draw.uniform(1e-6, 40e-6)) for k in range(SLOTS)])
                found = probe.pulses()
                self.assert_some_of(found, sent[-1:] + later)
                self.assertGreaterEqual(len(found), SLOTS - LOST_LATER)

    def test_an_overrun_that_begins_within_a_pulse_pairs_no_edge_with_one_that_was_lost(self):
        for seed in range(RUNS):
            with self.subTest(seed=seed):
                draw = random.Random(3000 + seed)
                probe = Probe()
                first = probe.send(servo(3, 20e-6, 20e3))
                zero, start = probe.word_time(), probe.chip.now
                rise = probe.play([(20e-6, 1)])[0][0]  # the image has seen it
                probe.pause(True)
                probe.play([(20e-6, 0)])
                fall = probe.chip.now
                sent = probe.send([(50e-6 * (k + 1), draw.uniform(1e-6, 40e-6)) for k in range(SLOTS - 2 + seed % 8)])
                probe.pause(False)
                probe.tick(3)
                self.assertLess((rise - start) / UNIT, (fall - start) / UNIT)
                wide = [pulse for pulse in probe.pulses() if pulse[1] > 40e-6 * PULSE_HZ + COUNT]
                self.assertLessEqual(len(wide), 1 if seed % 8 < 2 else 0, f"{wide} beside {first} from {zero} on, {sent}")

    def test_edges_that_the_dma_loses_are_never_replaced_by_others(self):
        for seed in range(RUNS):
            with self.subTest(seed=seed):
                draw = random.Random(1000 + seed)
                probe = Probe()
                pulses = [(60e-6 * (k + 1) + draw.uniform(0, 10e-6), draw.uniform(20e-6, 40e-6)) for k in range(60)]
                stop = draw.randrange(5, 20)  # within this pulse
                stop_s, go_s = pulses[stop][0] + 10e-6, 60e-6 * (stop + 1) + draw.uniform(0.5, 20) * 60e-6
                zero, start = probe.word_time(), probe.chip.now
                edges = [(start + round(at * digital.CLOCK_HZ), level)
                         for rise, width in pulses for at, level in ((rise, 1), (rise + width, 0))]
                probe.chip.signals.play(probe.pin, edges)
                probe.go_on(stop_s)
                probe.chip.dma.stand(True)
                probe.go_on(go_s - stop_s)
                probe.chip.dma.stand(False)
                probe.go_on(60 * 60e-6 - go_s + 200e-6)
                sent = [(zero + (rise[0] - start) / UNIT, (fall[0] - rise[0]) / UNIT) for rise, fall in zip(edges[::2], edges[1::2])]
                found = probe.pulses()
                self.assert_some_of(found, sent)
                lost = sum(stop_s <= rise + width <= go_s or stop_s <= rise <= go_s for rise, width in pulses)
                self.assertGreaterEqual(len(found), len(pulses) - lost - 4)

    def test_noise_gives_only_pulses_that_the_filter_lets_pass(self):
        for seed in range(RUNS):
            with self.subTest(seed=seed):
                draw = random.Random(2000 + seed)
                probe = Probe()
                at, levels = 100e-6, []
                for k in range(600):
                    levels.append((at, 1 - k % 2))
                    at += draw.choice((draw.uniform(20e-9, 400e-9), draw.uniform(20e-9, 20e-6)))
                zero, start = probe.word_time(), probe.chip.now
                edges = probe.play(levels)
                self.assert_some_of(probe.pulses(), filtered(edges, zero, start))


def filtered(edges, zero, start):
    """The pulses of a line, less what is shorter than the filter."""
    cycles = FILTER_S * digital.CLOCK_HZ
    level, rise, found = 0, 0, []
    for (at, to), (after, _) in zip(edges, [*edges[1:], (1 << 62, 0)]):
        if to != level and after - at > cycles:
            level = to
            if to:
                rise = at
            else:
                found.append((zero + (rise - start) / UNIT, (at - rise) / UNIT))
    return found


class Levels(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.probe = Probe()

    def test_the_throttle_is_that_of_its_pin_and_the_temperature_stays_that_of_its_own(self):
        probe = self.probe
        temperature = probe.word("temperature")
        self.assertEqual(temperature, round(probe.chip.pins[probe.wiring.temperature]))
        for count in (0, 1, 2048, 4095, 17):
            probe.chip.pins[probe.wiring.throttle] = count
            probe.tick(OLDEST_TICKS)
            self.assertEqual(probe.throttle, count)
        probe.tick(8 * REGULAR_TICKS)
        self.assertEqual(probe.word("temperature"), temperature)

    def test_the_temperature_goes_on_to_be_measured(self):
        probe = self.probe
        probe.chip.pins[probe.wiring.temperature] = 3000
        probe.tick(8 * REGULAR_TICKS + 2)
        self.assertEqual(probe.word("temperature"), 3000)
        self.assertNotEqual(probe.throttle, 3000)

    def test_a_conversion_is_counted_once_and_one_that_does_not_end_is_not(self):
        """Seven of eight are of the throttle. Then the converters never tell the end of one."""
        probe = Probe()
        probe.tick(3)
        before = probe.conversions
        probe.tick(8 * REGULAR_TICKS)
        self.assertEqual(probe.conversions - before, 7)
        for converter in probe.chip.converters:
            converter.__class__ = type("Stalled", (type(converter),), {"converting": property(lambda _: False, lambda *_: None)})
        before = probe.conversions
        probe.chip.pins[probe.wiring.throttle] = 3210
        probe.tick(8 * REGULAR_TICKS)
        self.assertEqual(probe.conversions, before)
        self.assertNotEqual(probe.throttle, 3210)

    def test_the_first_throttle_is_measured_before_the_first_tick(self):
        probe = Probe()
        probe.tick()
        self.assertEqual(probe.throttle, 0)

    def test_the_button_is_pressed_at_its_level_and_an_open_wire_is_released(self):
        probe = self.probe
        pin, pressed = probe.wiring.button, probe.wiring.button_level
        for level, expected in ((None, False), (pressed, True), (1 - pressed, False), (pressed, True), (None, False)):
            probe.chip.signals.set(pin, level)
            probe.tick(2)
            self.assertEqual(probe.button, expected)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
