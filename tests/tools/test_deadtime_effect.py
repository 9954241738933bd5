# SPDX-License-Identifier: MIT
"""What dead-time compensation does to the drive on the switched plant.

The figures of docs/design.md are bounded on both sides: a change that moves one by more than a fifth, for better or worse,
has to be understood and the table changed with it, `tools/dev figures --write`.
"""

import math
import os
import sys
import unittest

import support  # (the path of the tools)
from deadtime import harmonics, measure

sys.path.append(str(support.TOOLS / "docs"))
import dead_time  # noqa: E402
import generated  # noqa: E402

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


def through_windings_pct(point, fundamental_a):
    """THD of what a square wave of LOST_V in each leg drives through the windings alone."""
    omega = POLE_PAIRS * point.speed_rpm * math.pi / 30
    orders = [order for order in range(5, harmonics.ORDERS + 1) if order % 6 in (1, 5)]
    currents = [4 * LOST_V / (math.pi * order) / math.hypot(RESISTANCE_OHM, order * omega * INDUCTANCE_H)
                for order in orders]
    return 100 * math.hypot(*currents) / fundamental_a


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

    def test_the_page_shows_what_is_measured(self):
        self.assertIsNone(generated.departure(dead_time.PAGE, dead_time.made(self.results)))


if __name__ == "__main__":
    unittest.main()
