# SPDX-License-Identifier: MIT
"""evidence.bounds_can_fail: a value outside of what is proven, a tick over the budget and a stack too small are found."""

import unittest

import bounds

RUN = ("s1", "ideal", [{"name": "drive.bus", "min": 3, "max": 40, "unit": "V", "one": 2.0, "zero": 1.0}], "")
COST = {"m": {"ticks": {"robust": {"RUN": {"max": 100}}},
              "stack": {"robust": {"measured": 90, "computed": 110, "deepest": ["a", "b"]}}}}


def seen():
    return bounds.gathered([RUN])


class BoundsCanFail(unittest.TestCase):
    def test_a_value_above_or_below_what_is_proven_is_found_with_its_run_and_one_of_which_nothing_is(self):
        self.assertEqual(bounds.outside(seen(), {"bus": {"min": 3, "max": 40}}), [])
        for proven, said in (({"bus": {"min": 3, "max": 39}}, "drive.bus: seen 3 to 40 (s1 ideal)"),
                             ({"bus": {"min": 4, "max": 40}}, "drive.bus: seen 3 to 40 (s1 ideal)"),
                             ({}, "nothing is proven")):
            line, = bounds.outside(seen(), proven)
            self.assertIn(said, line)

    def test_a_run_that_is_refused_is_found(self):
        figures = bounds.figures_of([RUN, ("s1", "all", [], "refused")], [], [], [], [])
        self.assertFalse(figures[0]["ok"])

    def test_extremes_are_those_of_all_runs(self):
        other = ("s2", "ideal", [{**RUN[2][0], "min": -5, "max": 9}], "")
        both = bounds.gathered([RUN, other])["drive.bus"]
        self.assertEqual((both["low"], both["high"]), ((-5, "s2 ideal"), (40, "s1 ideal")))
        self.assertEqual(both["si"], [-12.0, 78.0])

    def test_a_tick_over_the_budget_is_found(self):
        for allowed, count in ((99, 1), (100, 0)):
            _, over = bounds.instruction_rows(COST, {"m": {"robust": {"run_max_instructions": [1, allowed]}}})
            self.assertEqual(len(over), count)

    def test_a_stack_too_small_is_found(self):
        _, largest = bounds.stack_rows(COST, 100)
        self.assertEqual(largest, 110 + bounds.EXCEPTION_BYTES)
        for reserved, enough in ((largest, True), (largest - 1, False)):
            self.assertEqual(bounds.figures_of([RUN], [], [], [], [("all", largest, reserved)])[-1]["ok"], enough)

    def test_a_state_that_is_not_counted_is_found(self):
        missing = bounds.uncounted(COST)
        self.assertIn("m FAULT", missing)
        self.assertNotIn("m RUN", missing)
        self.assertFalse(bounds.figures_of([RUN], [], [], missing, [])[-1]["ok"])


if __name__ == "__main__":
    unittest.main()
