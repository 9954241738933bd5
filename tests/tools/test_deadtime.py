# SPDX-License-Identifier: MIT
"""The measurement of the dead time: harmonics of known currents, files, figure and section."""

import functools
import math
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from support import FolderTest, captured
import plot
from deadtime import figure, harmonics, measure, section, table
from deadtime.measure import Measurement, Result
from deadtime.points import SETS, Point, pairs
from report import style
from report.assemble import write_report
from report.runs import PlotError, Trace

PERIOD_S = 1e-4
# A least-squares fit of a sum of sines is exact but for the rounding of doubles.
ROUNDING = 1e-9


def angle_of(hertz, seconds=1.0, start_deg=17.0):
    """The electrical angle, sampled as a trace is; no whole number of samples in a turn."""
    turned = start_deg + 360.0 * hertz * np.arange(round(seconds / PERIOD_S)) * PERIOD_S
    return np.mod(turned + 180.0, 360.0) - 180.0


def current_of(angle_deg, shares, amplitude=2.0, mean=0.0):
    """A fundamental with harmonics: order → share of its amplitude."""
    angle = np.radians(angle_deg)
    return mean + amplitude * (np.cos(angle) + sum(
        share * np.sin(order * angle + order) for order, share in shares.items()))


class Turns(unittest.TestCase):
    def test_whole_turns_begin_and_end_at_the_same_angle(self):
        for hertz, turns in ((6.7, 6), (-13.3, 12), (60.1, 59)):     # from wrap to wrap, in a second
            angle = angle_of(hertz)
            whole, counted = harmonics.whole_turns(angle)
            self.assertEqual(counted, turns)
            step = 360.0 * abs(hertz) * PERIOD_S
            self.assertLess(abs(angle[whole.start] - angle[whole.stop]), step)

    def test_less_than_a_turn_is_refused(self):
        for angle in (angle_of(0.9, start_deg=0.0), np.zeros(10)):
            with self.assertRaisesRegex(ValueError, "no whole electrical turn; expected"):
                harmonics.whole_turns(angle)


def of_whole_turns(angle, current):
    whole, _ = harmonics.whole_turns(angle)
    return harmonics.orders(angle[whole], current[whole])


class Harmonics(unittest.TestCase):

    def test_a_sine_has_no_distortion(self):
        angle = angle_of(6.71)
        found = harmonics.orders(angle, current_of(angle, {}, mean=0.3))
        self.assertAlmostEqual(found.fundamental, 2.0, delta=ROUNDING)
        self.assertAlmostEqual(found.amplitudes[0], 0.3, delta=ROUNDING)
        self.assertLess(found.distortion_pct, 100 * ROUNDING)

    def test_each_order_and_their_thd(self):
        shares = {2: 0.01, 5: 0.05, 7: 0.03, 13: 0.02, 25: 0.004}
        angle = angle_of(6.71)
        found = harmonics.orders(angle, current_of(angle, shares))
        for order in range(2, harmonics.ORDERS + 1):
            self.assertAlmostEqual(found.shares_pct[order], 100 * shares.get(order, 0.0), delta=ROUNDING)
        both = of_whole_turns(angle, current_of(angle, shares))
        expected = 100 * math.sqrt(sum(share ** 2 for share in shares.values()))
        self.assertAlmostEqual(both.thd_pct, expected, delta=ROUNDING)
        # A mean square over turns that are whole but for less than a sample at either end.
        self.assertAlmostEqual(both.distortion_pct, expected, delta=expected * 2 * 6.71 * PERIOD_S)

    def test_a_square_wave(self):
        angle = angle_of(10.03, seconds=2.0)
        found = of_whole_turns(angle, np.sign(np.cos(np.radians(angle))))
        # Eight edges between two samples in eight turns: each moves by up to half a sample of 997.
        edges = 4 * 10.03 * PERIOD_S
        self.assertAlmostEqual(found.fundamental, 4 / math.pi, delta=edges)
        for order in (3, 5, 7):
            self.assertAlmostEqual(found.shares_pct[order], 100 / order, delta=100 * edges)
        self.assertAlmostEqual(found.distortion_pct, 100 * math.sqrt(math.pi ** 2 / 8 - 1), delta=100 * edges)
        odd = math.sqrt(sum(1 / order ** 2 for order in range(3, harmonics.ORDERS + 1, 2)))
        self.assertAlmostEqual(found.thd_pct, 100 * odd, delta=100 * edges)

    def test_what_lies_between_the_orders_counts(self):
        angle = angle_of(10.0)
        between = 0.2 * np.sin(0.37 * np.unwrap(np.radians(angle)))
        found = harmonics.orders(angle, current_of(angle, {}, amplitude=1.0) + between)
        # 3.7 turns are no whole number: mean and fundamental take a part of it, at most a fifth.
        self.assertAlmostEqual(found.distortion_pct, 20.0, delta=4.0)
        self.assertLess(found.thd_pct, found.distortion_pct / 2)

    def test_a_speed_that_sways_is_no_distortion(self):
        time = np.arange(10000) * PERIOD_S
        turned = 360.0 * (10.0 * time + 0.3 * np.sin(2 * math.pi * 3 * time))
        angle = np.mod(turned + 180.0, 360.0) - 180.0
        self.assertLess(harmonics.orders(angle, current_of(angle, {})).distortion_pct, 100 * ROUNDING)


def trace(shares, speed_ripple=0.0, error_deg=0.5):
    angle = angle_of(6.71)
    ones = np.ones_like(angle)
    ripple = np.where(np.arange(len(angle)) % 2, 1.0, -1.0)
    return Trace(Path("t.csv"), {
        "time_s": np.arange(len(angle)) * PERIOD_S, "angle_el_deg": angle,
        "i_a_a": current_of(angle, shares), "i_q_a": 2.0 * ones + 0.1 * ripple,
        "speed_rpm": 200.0 * ones + speed_ripple * ripple,
        "angle_error_el_deg": -error_deg * ones + 0.2 * ripple})


@functools.cache
def made_up(sets=SETS):
    """A Measurement of all points without a simulator: the same two runs at each."""
    runs = [measure.evaluate(Point("imp", 200, 3), trace({5: share}), share < 0.1)
            for share in (0.01, 0.2)]
    both = [tuple(tuple(replace(part, point=point) for part in made) for point, made in zip(pair, runs))
            for pair in pairs(sets)]
    shown = [pair for pair in both if measure.where(pair[0][0]) in measure.SHOWN]
    return Measurement([tuple(result for result, _ in pair) for pair in both],
                       [tuple(wave for _, wave in pair) for pair in shown])


class Evaluation(unittest.TestCase):
    def test_figures_of_a_known_trace(self):
        result, wave = measure.evaluate(Point("imp", 200, 3), trace({5: 0.05}, speed_ripple=3.0), True)
        tolerance = 2 * 6.71 * PERIOD_S     # a sample at either end
        self.assertEqual(result.turns, 6)
        self.assertAlmostEqual(result.fundamental_a, 2.0, delta=ROUNDING)
        self.assertAlmostEqual(result.thd_pct, 5.0, delta=5.0 * tolerance)
        self.assertAlmostEqual(result.iq_ripple_a, 0.1, delta=tolerance)
        self.assertAlmostEqual(result.speed_ripple_rpm, 3.0, delta=3.0 * tolerance)
        self.assertAlmostEqual(result.angle_mean_deg, -0.5, delta=tolerance)
        self.assertAlmostEqual(result.angle_max_deg, 0.7, delta=ROUNDING)
        self.assertEqual(len(wave.time_s), len(wave.current_a))
        self.assertAlmostEqual(wave.time_s[-1] - wave.time_s[0], measure.SHOWN_TURNS / 6.71, delta=3 * PERIOD_S)

    def test_a_rotor_at_rest_is_named(self):
        still = trace({})
        still.columns["angle_el_deg"][:] = 3.0
        with self.assertRaisesRegex(PlotError, r"t\.csv: .*no whole electrical turn"):
            measure.evaluate(Point("imp", 200, 3), still, True)


class Files(FolderTest):
    def test_read_is_what_was_written(self):
        made, path = made_up(), self.folder / "deep" / "deadtime.json"
        measure.write(made, path)
        self.assertEqual(measure.read(path), made)

    def test_one_clear_line(self):
        path = self.folder / "x.json"
        for text in ("{}", "[", '{"results": [[{"a": 1}]], "waves": []}'):
            self.write("x.json", text)
            with self.assertRaisesRegex(PlotError, r"x\.json: .*; expected what `tools/plot.py deadtime`"):
                measure.read(path)
        with self.assertRaisesRegex(PlotError, r"no\.json: No such file"):
            measure.read(self.folder / "no.json")
        with self.assertRaisesRegex(PlotError, "no/motorsim: No such file.*expected motorsim"):
            measure.run("no/motorsim", Point("imp", 200, 3))

    def test_the_section_of_the_report(self):
        self.run_files("s1")
        made = self.folder / "deadtime.data"
        measure.write(made_up(), made)
        status, out, err = captured(plot.main, "report", "--runs", self.folder, "--deadtime", made, "--out", self.folder / "r")
        self.assertEqual((status, err), (0, ""))
        text = Path(out.strip()).read_text(encoding="utf-8")
        self.assertIn('<a href="#deadtime">', text)
        self.assertEqual(text.count("<tr><th scope=row>deadtime, "), len(pairs()) // len(SETS))
        self.assertTrue((self.folder / "r" / "deadtime.png").is_file())

    def test_without_a_measurement_there_is_no_section(self):
        self.run_files("s1")
        path = write_report(self.folder, self.folder / "r")
        self.assertNotIn("deadtime", path.read_text(encoding="utf-8"))


class Shown(unittest.TestCase):
    def test_every_pair_has_a_row_and_two_marks(self):
        made = made_up()
        self.assertEqual(len(table.text(made).splitlines()), 2 + len(made.results))
        marks = figure.draw(made, style.PRINT).axes[-1].lines
        self.assertEqual(len(marks), 2 * len(made.results))
        self.assertEqual({mark.get_markerfacecolor() == "none" for mark in marks[1::2]}, {True})

    def test_of_one_set_there_are_its_points_and_its_name_alone(self):
        made = made_up(("deadtime",))
        self.assertEqual(made.sets(), ["deadtime"])
        axes = figure.draw(made, style.PRINT).axes[-1]
        self.assertEqual(len(axes.lines), 2 * len(made.results))
        self.assertEqual([text.get_text() for text in axes.texts], ["deadtime"])

    def test_what_is_no_sine_has_no_figure(self):
        row = table.cells((result_of(thd_pct=2.34), result_of(thd_pct=100.1, held=False)))
        self.assertEqual(row[0], ("2.3", f">{table.FIXED_SPACE}100"))
        self.assertEqual(table.signed(-0.04), "0.0")
        self.assertEqual(table.signed(-0.06), "−0.1")
        self.assertEqual(row[-1], ("held", "not held"))

    def test_the_caption_counts_what_is_not_held(self):
        self.assertRegex(section.caption(made_up()), r"hold the rotor at 27 of 27 points")


def result_of(**changed):
    return Result(**{**dict(point=Point("imp", 200, 3), turns=6, fundamental_a=2.0, thd_pct=1.0, distortion_pct=1.0,
                            iq_ripple_a=0.1, speed_ripple_rpm=1.0, angle_mean_deg=0.0,
                            angle_max_deg=0.2, held=True), **changed})


if __name__ == "__main__":
    unittest.main()
