# SPDX-License-Identifier: MIT
"""evidence.mutation_can_fail: mutants survive weaker tests, and the register cannot hide or keep one.

With it, two faults that have to be killed: the sign of the gradient in (21) of paper A, a dropped saturation.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import mutants
import mutation
import part

PI = "firmware/control/pi.c"
OBSERVER = "firmware/control/nn_observer.c"
PORT = "firmware/math/port/generic/fx_port.h"
GROUP = "limit"  # what the names of the tests that are left out have in common
KILLED = {
    "the sign of the gradient in (21)": (OBSERVER, "nn_observer_predict", "(rotated.q * before.d) +"),
    "the sign of the weight's change in (22)": (OBSERVER, "nn_observer_train", "fx_clamp(obs->speed + weight_step"),
    "a shift by too many bits, of which the PC takes those modulo 32": (
        PORT, "fx_leading_zeros", "(rest >> (-(width)))"),
    "a dropped saturation": (PI, "pi_unwind", "(pi->integral_q26 - (excess * Q15_TO_Q26));"),
}


def without_group(build, test, folder):
    """The test program without the tests of the group."""
    source = Path("tests/unit") / f"{test.name}.c"
    text = (build.root / source).read_text(encoding="utf-8")
    weaker = folder / source.name
    weaker.write_text(re.sub(rf"^TEST\((\w*{GROUP}\w*)\)", r"static void \1(void)", text, flags=re.MULTILINE), encoding="utf-8")
    object_ = folder / "weaker.o"
    subprocess.run([*build.compile_command(str(source)), "-Wno-unused-function", f"-I{build.root / source.parent}",
                    "-o", str(object_), "-c", str(weaker)], check=True)
    test.link = [str(object_) if word.endswith(f"{source.name}.o") else word for word in test.link]


class MutationCanFail(unittest.TestCase):
    build = None

    def examined(self, path, folder, wanted, weaken=False):
        subject = mutation.subject(self.build, path)
        if weaken:
            weaker = replace(subject.tests[0], link=list(subject.tests[0].link))
            subject.tests = [weaker]
            without_group(self.build, weaker, folder)
        made = list(filter(wanted, mutants.mutants(self.build.root, path, mutation.CORE)))
        return mutation.examined(self.build, [subject], made, folder, 1)

    def test_mutants_survive_when_a_group_of_tests_is_left_out(self):
        def of_a_limit(mutant):
            return mutant.path == PI and "limit" in mutant.before

        for weaken in (False, True):
            with self.subTest(weaken=weaken), tempfile.TemporaryDirectory() as folder:
                real = self.examined(PI, Path(folder), of_a_limit, weaken)
                found = list(mutation.findings(real, {}, []))
                self.assertTrue(real)
                self.assertEqual(bool(found), weaken, found)

    def test_each_of_these_faults_is_killed(self):
        for name, (path, function, text) in KILLED.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                real = self.examined(path, Path(folder),
                                     lambda mutant: mutant.function == function and text in mutant.after)
                self.assertEqual(len(real), 1, [candidate.mutant.after for candidate in real])
                self.assertTrue(real[0].killed_by, real[0].mutant)
                print(f"{name}: {real[0].mutant.after} is killed by {real[0].killed_by}")

    def test_a_registered_mutant_that_is_killed_or_gone_is_a_finding(self):
        with tempfile.TemporaryDirectory() as folder:
            real = self.examined(PI, Path(folder), lambda mutant: mutant.function == "pi_reset")
            killed = mutation.key(real[0].mutant)
            gone = (PI, "pi_reset", "a line", "that is not there")
            register = {place: (mutation.HARMLESS, "a reason") for place in (killed, gone)}
            found = list(mutation.findings(real, register, [candidate.mutant for candidate in real]))
            self.assertEqual(len(found), 2, found)


def candidates(killed, survivors):
    def candidate(number, killed_by):
        mutant = mutants.Mutant("a.c", number, "f", 0, 1, "", "a line", f"mutant {number}")
        return mutation.Candidate(mutant, killed_by)

    return [candidate(number, "a test" if number < killed else None) for number in range(killed + survivors)]


class RateCanFail(unittest.TestCase):
    def test_95_of_100_are_enough_without_the_equivalent_ones_but_not_less_or_none(self):
        area = mutation.Area("an area", (), (), (95, 100))
        for killed, survivors, equivalent, enough in ((95, 5, 0, True), (94, 6, 0, False), (95, 6, 1, True),
                                                      (94, 6, 1, False), (0, 0, 0, False)):
            real = candidates(killed, survivors)
            register = {mutation.key(one.mutant): (mutation.EQUIVALENT, "a reason")
                        for one in real[killed:killed + equivalent]}
            with self.subTest(killed=killed, survivors=survivors, equivalent=equivalent):
                self.assertEqual(mutation.rate(area, real, register)["ok"], enough)

    def test_of_a_sample_two_standard_deviations_less_are_enough(self):
        """Of 90 % among 36 one is 5 %: 80 % are 28.8 of 36."""
        area = mutation.Area("an area", (), (), (9, 10), sample=36)
        for killed, enough in ((29, True), (28, False)):
            self.assertEqual(mutation.rate(area, candidates(killed, 36 - killed), {})["ok"], enough)


class SampleCanFail(unittest.TestCase):
    AREA = next(area for area in mutation.AREAS if area.name == "drive")

    def test_a_sample_is_the_same_each_time_and_spread_over_the_files(self):
        made, sample = self.AREA.mutants(part.ROOT)
        self.assertEqual(self.AREA.mutants(part.ROOT)[1], sample)
        self.assertEqual(len(sample), self.AREA.sample)
        self.assertGreater(len({mutant.path for mutant in sample}), len({mutant.path for mutant in made}) // 2)

    def test_a_sample_has_none_of_those_that_were_looked_at(self):
        looked_at = replace(self.AREA, sample=self.AREA.looked_at, looked_at=0).mutants(part.ROOT)[1]
        self.assertEqual(len(looked_at), self.AREA.looked_at)
        self.assertFalse(looked_at & self.AREA.mutants(part.ROOT)[1])

    def test_a_mutant_is_drawn_whatever_else_is_in_the_file(self):
        one = mutants.Mutant("a.c", 7, "f", 0, 1, "", "a line", "another")
        self.assertEqual(mutation.drawn(one), mutation.drawn(replace(one, line=8, start=9, end=10)))
        self.assertNotEqual(mutation.drawn(one), mutation.drawn(replace(one, after="a third")))


class MutantsCanFail(unittest.TestCase):
    SOURCE = """
namespace nf
{
namespace
{
constexpr double SHARE = 1.15;
}

double shares(double speed)
{
    check(speed < 2 * SHARE);
    return std::max(speed, 0.5) * SHARE;
}
} // namespace nf
"""
    PRELUDE = "namespace std { inline const double &max(const double &a, const double &b) { return a < b ? b : a; } }\nvoid check(bool);\n"

    def test_constants_calls_and_limits_of_cpp_have_their_mutants(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "a.cpp").write_text(self.PRELUDE + self.SOURCE, encoding="utf-8")
            made = {(mutant.function, mutant.after) for mutant in mutants.mutants(Path(folder), "a.cpp", ())}
        for expected in (("SHARE", "constexpr double SHARE = (2 * 1.15);"), ("SHARE", "constexpr double SHARE = (0.9 * 1.15);"),
                         ("shares", ";"), ("shares", "return (0.5) * SHARE;"),
                         ("shares", "return std::min(speed, 0.5) * SHARE;"), ("shares", "check(speed <= 2 * SHARE);")):
            self.assertIn(expected, made)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=part.ROOT / "build/host", help="folder of the CMake build")
    args, others = parser.parse_known_args()
    MutationCanFail.build = mutation.Build(part.ROOT, args.build.resolve())
    unittest.main(argv=[sys.argv[0], *others])
