# SPDX-License-Identifier: MIT
"""Steps, peaks, wraps and zoomed windows."""

import math
import unittest
from pathlib import Path

import numpy as np

import support  # noqa: F401 (the path of the tools)
from report import signals
from report.runs import Trace

TIME = np.arange(10001) * 1e-4


def trace(**columns):
    return Trace(Path("t.csv"), {"time_s": TIME, **columns})


class Envelope(unittest.TestCase):
    def test_keeps_ends_and_every_peak(self):
        values = np.zeros_like(TIME)
        for place in (0, 1, 4321, 7777, 10000):
            values = np.zeros_like(TIME)
            values[place] = -5.0
            time, kept = signals.envelope(TIME, values, 100)
            self.assertLess(len(kept), 250)
            self.assertEqual(kept.min(), -5.0)
            self.assertEqual(time[kept.argmin()], TIME[place])
            self.assertEqual((time[0], time[-1]), (TIME[0], TIME[-1]))

    def test_few_samples_stay_as_they_are(self):
        time, values = signals.envelope(TIME, TIME, 5001)
        self.assertIs(values, TIME)
        self.assertIs(time, TIME)

    def test_time_stays_in_order(self):
        time, _ = signals.envelope(TIME, np.sin(700 * TIME), 333)
        self.assertTrue(np.all(np.diff(time) > 0))


class Angles(unittest.TestCase):
    def test_pieces_do_not_wrap(self):
        turns = 3
        pieces = signals.pieces(TIME, 360.0 * turns * TIME)
        self.assertEqual(len(pieces), turns + 1)
        for _, degrees in pieces:
            self.assertLess(np.abs(np.diff(degrees)).max(), 1.0)
            self.assertLessEqual(np.abs(degrees).max(), 180.0)

    def test_rest_at_zero_does_not_flicker(self):
        noise = np.where(np.arange(len(TIME)) % 2, 0.1, -0.1)
        self.assertEqual(len(signals.pieces(TIME, noise)), 1)


class Events(unittest.TestCase):
    def test_steps_of_speed_and_load(self):
        found = signals.events(trace(
            speed_command_rpm=np.where(TIME < 0.2, 0.0, 1000.0),
            load_torque_nm=np.where((TIME >= 0.5) & (TIME < 0.8), 3.0, 0.0)))
        self.assertEqual([event.text for event in found], ["1000 rpm", "load 3 N·m", "no load"])
        np.testing.assert_allclose([event.time for event in found], [0.2, 0.5, 0.8], atol=1e-9)

    def test_position_command_replaces_speed_command(self):
        found = signals.events(trace(
            speed_command_rpm=np.where(TIME < 0.2, 0.0, 1000.0),
            position_command_rad=np.where(TIME < 0.3, 3 * math.pi, -3 * math.pi)))
        self.assertEqual([event.text for event in found], ["−3π rad"])

    def test_a_ramp_or_nothing_is_no_step(self):
        self.assertEqual(signals.events(trace(speed_command_rpm=1000 * TIME)), [])
        self.assertEqual(signals.events(trace(load_torque_nm=0 * TIME)), [])
        self.assertEqual(signals.events(trace()), [])

    def test_position_texts(self):
        for value, text in ((math.pi, "π rad"), (-2 * math.pi, "−2π rad"), (0.5, "0.5 rad"),
                            (0.0, "0 rad")):
            self.assertEqual(signals.radians_text(value), text)


class Windows(unittest.TestCase):
    def test_turns_at_a_step_and_at_the_end(self):
        hertz = 60.0
        angle = (360 * hertz * TIME + 180) % 360 - 180
        first, last = signals.zoom_windows(trace(angle_el_deg=angle),
                                           [signals.Event(0.5, "load")])
        length = signals.ZOOM_TURNS / hertz
        self.assertAlmostEqual(first.end, 0.5 + length, delta=2e-4)
        self.assertLess(first.start, 0.5)
        self.assertAlmostEqual(last.start, 1.0 - length, delta=2e-4)
        self.assertAlmostEqual(last.end, 1.0 + 1e-4)    # the last sample holds one period

    def test_a_rotor_at_rest_ends_the_window_by_time(self):
        windows = signals.zoom_windows(trace(angle_el_deg=0 * TIME), [signals.Event(0.2, "")])
        self.assertAlmostEqual(windows[0].end, 0.2 + signals.ZOOM_LONGEST_S)
        self.assertAlmostEqual(windows[1].start, 1.0 - signals.ZOOM_LONGEST_S)

    def test_windows_stay_within_the_trace(self):
        windows = signals.zoom_windows(trace(angle_el_deg=0 * TIME),
                                       [signals.Event(0.0, ""), signals.Event(0.99, "")])
        for window in windows:
            self.assertGreaterEqual(window.start, 0.0)
            self.assertLessEqual(window.end, signals.end(TIME))


if __name__ == "__main__":
    unittest.main()
