# SPDX-License-Identifier: MIT
"""What dead-time compensation does to the drive on the switched plant.

The figures are bounded on both sides: a change that moves one by more than a fifth, for better or worse, has to
be understood and the table changed with it.

test_deadtime_effect.py            holds the bounds
test_deadtime_effect.py --measure  prints the table as it is measured now
"""

import math
import os
import sys
import unittest

import support  # noqa: F401 (the path of the tools)
from deadtime import harmonics, measure
from deadtime.points import LOADS_NM, SPEEDS_RPM

MOTORSIM = os.environ["NF_MOTORSIM"]

# Motor A on the bench inverter with the set `deadtime`.
BUS_V, PERIOD_S, DEAD_TIME_S, DROP_V = 310.0, 1e-4, 2e-6, 1.2
RESISTANCE_OHM, INDUCTANCE_H, POLE_PAIRS = 2.125, 0.0116, 2
LOST_V = BUS_V * DEAD_TIME_S / PERIOD_S + DROP_V    # of a leg, against its current

# The share of the lost voltage, rms, that may be left. All is compensated but where a leg's current is within its
# ripple and five counts of the converter: at the least current, less half of i_q, for a tenth of a turn.
CROSSING_A = BUS_V * PERIOD_S / (12 * INDUCTANCE_H) + 5 * 2 * 20.0 / 4096
LEAST_A = 0.25 * 7.8 / (1.5 * POLE_PAIRS * 0.387) * math.sqrt(0.8)
LEFT = math.sqrt(2 / math.pi * math.asin(CROSSING_A / LEAST_A))     # 0.34

MARGIN = 0.2
EXPECTED = {    # rpm, N·m, compensated: THD in %, ripple of i_q in A rms, largest angle error in °
    (200, 0, True): (2.93, 0.0744, 0.234),
    (200, 1, True): (3.97, 0.119, 0.418),
    (200, 3, True): (4.12, 0.172, 0.778),
    (400, 0, True): (1.22, 0.0323, 0.103),
    (400, 1, True): (4.67, 0.101, 0.478),
    (400, 3, True): (1.71, 0.0675, 0.182),
    (900, 0, True): (1.75, 0.0641, 0.212),
    (900, 1, True): (1.64, 0.0514, 0.183),
    (900, 3, True): (1.06, 0.0433, 0.102),
    (900, 3, False): (34.6, 0.951, 0.753),
}


def through_windings_pct(point, fundamental_a):
    """THD of what a square wave of LOST_V in each leg drives through the windings alone."""
    omega = POLE_PAIRS * point.speed_rpm * math.pi / 30
    orders = [order for order in range(5, harmonics.ORDERS + 1) if order % 6 in (1, 5)]
    currents = [4 * LOST_V / (math.pi * order) / math.hypot(RESISTANCE_OHM, order * omega * INDUCTANCE_H)
                for order in orders]
    return 100 * math.hypot(*currents) / fundamental_a


def measured_figures(results):
    return {(result.point.speed_rpm, result.point.load_nm, result.point.given_back):
            (result.thd_pct, result.iq_ripple_a, result.angle_max_deg)
            for pair in results for result in pair
            if result.point.imperfections == "deadtime" and (result.point.given_back or steady(result))}


def steady(result):
    """What sways at an amplitude of its own is not bounded: any change moves it."""
    return (result.point.speed_rpm, result.point.load_nm) == (SPEEDS_RPM[-1], LOADS_NM[-1])


class Effect(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.results = measure.measure(MOTORSIM).results

    def each_pair(self):
        for given_back, lost in self.results:
            with self.subTest(point=measure.where(given_back)):
                yield given_back, lost

    def test_the_rotor_is_held_everywhere_with_it(self):
        for given_back, _ in self.each_pair():
            self.assertTrue(given_back.held)

    def test_without_it_more_flows_than_the_lost_voltage_drives_through_the_windings(self):
        for given_back, lost in self.each_pair():
            if given_back.point.imperfections == "deadtime":
                self.assertGreater(lost.thd_pct,
                                   through_windings_pct(lost.point, given_back.fundamental_a))

    def test_with_it_no_more_flows_than_what_is_left_drives_through_the_windings(self):
        for given_back, _ in self.each_pair():
            if given_back.point.imperfections == "deadtime":
                self.assertLess(given_back.thd_pct, LEFT * through_windings_pct(
                    given_back.point, given_back.fundamental_a))

    def test_distortion_and_angle_error_fall_to_what_is_left(self):
        for given_back, lost in self.each_pair():
            self.assertLess(given_back.thd_pct, LEFT * lost.thd_pct)
            self.assertLess(given_back.angle_max_deg, LEFT * lost.angle_max_deg)

    def test_figures_are_what_they_were(self):
        found = measured_figures(self.results)
        self.assertEqual(set(found), set(EXPECTED))
        for point, figures in EXPECTED.items():
            for value, now in zip(figures, found[point]):
                with self.subTest(point=point, value=value):
                    self.assertAlmostEqual(now, value, delta=MARGIN * value)


if __name__ == "__main__":
    if sys.argv[1:] == ["--measure"]:
        for where, figures in measured_figures(measure.measure(MOTORSIM).results).items():
            print(f"    {where}: ({', '.join(f'{figure:#.3g}' for figure in figures)}),")
    else:
        unittest.main()
