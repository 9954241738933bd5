# SPDX-License-Identifier: MIT
"""Campaign files: what is drawn from them, and the one line that says what is wrong."""

import unittest

from campaign_support import MINE, CampaignTest
from robustness.campaign import CampaignError, names, load
from robustness.distributions import Choice, Range, values

MANY = 4000
# Standard deviations: a wrong distribution is further off, a right one hardly ever.
SURE = 5
# Of run 5 of the file, once and for all: results of campaigns are compared over the years.
PINNED = {"plant.resistance_scale": "0.9039192", "plant.inertia_scale": "1.123119",
          "plant.bus_ripple_pct": "0", "scenario.seed": "3744346275"}


def texts(distribution, count=MANY, key="k"):
    return [values({key: distribution}, 1, run)[key] for run in range(count)]


class Draws(CampaignTest):
    def test_a_run_depends_on_seed_and_number_alone(self):
        first = self.load()
        forwards = [first.values(run) for run in range(20)]
        second = self.load()
        backwards = [second.values(run) for run in reversed(range(20))]
        self.assertEqual(forwards, backwards[::-1])
        self.assertEqual(len({str(value) for value in forwards}), 20)
        other = self.load(MINE.replace("seed = 3", "seed = 4"))
        self.assertNotEqual(forwards[0], other.values(0))

    def test_the_values_are_the_same_on_every_machine_and_in_every_version(self):
        self.assertEqual(self.load().values(5), PINNED)

    def test_one_more_parameter_leaves_the_others_as_they_were(self):
        more = self.load(MINE.replace("[vary]\n", "[vary]\nplant.flux_scale = "
                                      "{ uniform = [0.9, 1.1] }\n"))
        found = more.values(5)
        del found["plant.flux_scale"]
        self.assertEqual(found, self.load().values(5))

    def test_uniform_fills_its_range_evenly(self):
        found = [float(text) for text in texts(Range("uniform", -2, 6))]
        self.assertTrue(all(-2 <= value <= 6 for value in found))
        deviation = 8 / (12 * MANY) ** 0.5
        self.assertAlmostEqual(sum(found) / MANY, 2, delta=SURE * deviation)

    def test_log_uniform_has_as_many_below_the_geometric_mean_as_above(self):
        found = [float(text) for text in texts(Range("log_uniform", 0.25, 4))]
        self.assertTrue(all(0.25 <= value <= 4 for value in found))
        self.assertAlmostEqual(sum(value < 1 for value in found), MANY / 2,
                               delta=SURE * (MANY / 4) ** 0.5)

    def test_integers_reach_both_ends(self):
        self.assertEqual(set(texts(Range("integer", 3, 5))), {"3", "4", "5"})

    def test_every_choice_is_as_likely(self):
        found = texts(Choice(("a", "b", "c", "d")))
        for option in "abcd":
            self.assertAlmostEqual(found.count(option), MANY / 4,
                                   delta=SURE * (MANY * 3 / 16) ** 0.5)

    def test_two_parameters_of_a_run_are_independent(self):
        half = Range("uniform", 0, 1)
        pairs = [values({"a": half, "b": half}, 1, run) for run in range(MANY)]
        equal = sum((float(pair["a"]) < 0.5) == (float(pair["b"]) < 0.5) for pair in pairs)
        self.assertAlmostEqual(equal, MANY / 2, delta=SURE * (MANY / 4) ** 0.5)

    def test_arguments_hold_everything_of_the_file(self):
        words = self.load(MINE.replace("runs = 6", 'with = ["hot", "adc"]\nruns = 6'))
        words = words.arguments({"plant.resistance_scale": "1.05"})
        self.assertEqual(words, ["run", "campaign", "--with", "hot", "--with", "adc",
                                 "--set", "plant.adc_noise_lsb=1",
                                 "--set", "scenario.duration_s=0.2",
                                 "--set", "plant.resistance_scale=1.05"])

    def test_a_path_is_relative_to_the_file(self):
        found = self.load(MINE.replace('"campaign"', '"../own.toml"'))
        self.assertEqual(found.drawn.scenario, str(self.folder.resolve().parent / "own.toml"))

    def test_trial_runs_reach_all_ends_and_options(self):
        for key, wanted in (("plant.inertia_scale", {"0.5", "2"}),
                            ("plant.bus_ripple_pct", {"0", "40"})):
            self.assertEqual({corner[key] for corner in self.load().corners()}, wanted)


class Refusals(CampaignTest):
    def refused(self, old, new, says):
        self.assertIn(old, MINE)
        with self.assertRaisesRegex(CampaignError, rf"mine\.toml: {says}") as caught:
            self.load(MINE.replace(old, new, 1))
        self.assertNotIn("\n", str(caught.exception))

    def test_shipped_campaigns_are_read(self):
        self.assertLessEqual({"robust", "smoke"}, set(names()))
        for name in names():
            self.assertEqual(load(name).name, name)

    def test_keys(self):
        self.refused("runs =", "count =", "count: unknown key; allowed: title, scenario, with, zoo, classes")
        self.refused("runs = 6", "", "runs: is missing; allowed: a whole number, 1 to 10000000")
        self.refused("runs = 6", "runs = 0", "runs: is 0; allowed: a whole number, 1 to")
        self.refused("runs = 6", "runs = true", "runs: is true; allowed: a whole number")
        self.refused("seed = 3", "seed = -1", "seed: is -1; allowed: a whole number, 0 to")
        self.refused('"campaign"', "7", "scenario: is 7; allowed: a string")
        self.refused("runs = 6", 'runs = 6\nwith = "adc"', 'with: is "adc"; allowed: a list of imp')
        self.refused("[set]", "[[set]]", "set: is .*; allowed: a table")

    def test_distributions(self):
        old = "{ uniform = [0.9, 1.1] }"
        key = r"vary\.plant\.resistance_scale"
        self.refused(old, "{ normal = [1, 2] }", rf"{key}\.normal: 'normal' is no distribution; "
                     "allowed: .*one of uniform, log_uniform, integer, choice")
        self.refused(old, "1.1", rf"{key}: 'resistance_scale' is no distribution")
        rising = r"allowed: \[low, high\], two numbers that rise"
        for wrong in ("[1.1, 0.9]", "[1, 1]", "[1]", "7", "[1, inf]", '["a", "b"]', "[false, true]"):
            self.refused(old, f"{{ uniform = {wrong} }}", rf"{key}\.uniform: is .*; {rising}")
        self.refused(old, "{ log_uniform = [0, 1] }", rf"{key}\.log_uniform: is .*above 0")
        self.refused(old, "{ integer = [0.5, 2] }", rf"{key}\.integer: is .*two whole numbers")
        self.refused(old, "{ choice = [1, 1] }", rf"{key}\.choice: is .*two or more values")
        self.refused(old, "{ uniform = [1, 2], choice = [1, 2] }", f"{key}: has two distributions")

    def test_a_key_is_fixed_or_varied(self):
        self.refused("plant.adc_noise_lsb", "plant.inertia_scale",
                     r"vary\.plant\.inertia_scale: is also in \[set\]")

    def test_acceptance(self):
        for wrong, says in (("locked = 3", "locked: unknown key; allowed: locked_pct, uncontrolled, unnamed_pct"),
                            ("locked_pct = 101", "locked_pct: is 101; allowed: a number, 0 to 100"),
                            ("uncontrolled = 0.5", "uncontrolled: is 0.5; allowed: a whole numb")):
            self.refused("[vary]", f"[accept]\n{wrong}\n[vary]", rf"accept\.{says}")

    def test_files(self):
        self.refused("[vary]", "[vary", r".*line.*; expected TOML")
        with self.assertRaisesRegex(CampaignError, "no campaign 'rubust'; allowed: everything, robust, smoke, zoo, zoo_user"):
            load("rubust")
        with self.assertRaisesRegex(CampaignError, r"no\.toml: No such file.*; expected a camp"):
            load(str(self.folder / "no.toml"))


if __name__ == "__main__":
    unittest.main()
