# SPDX-License-Identifier: MIT
"""evidence.coverage_can_fail: what is not covered is found, and so is a justification that nothing needs.

The PI controller of the firmware stands for all of the core. Each fault alone is put into a copy of it, or into the
test, which covers all of it as it is.
"""

import os
import re
import shutil
import tempfile
import unittest
from pathlib import Path

import coverage
import ctested
import part

MODULE = "firmware/control/pi.c"
LINE = "    if (output > limit) {"
TEST = """
#include "pi.h"

int main(void)
{
    const pi_cfg_t cfg = {.kp = 1, .ki = 1, .kp_shift = 1U, .ki_shift = 1U};
    pi_t pi;
    int32_t sum = 0;

    pi_reset(&pi, 0);
    sum += pi_step(&pi, &cfg, 2, 0, 100);
    sum += pi_step(&pi, &cfg, 2, 1000, 100);
    sum += pi_step(&pi, &cfg, 2, -1000, 100);
    pi_unwind(&pi, 1);
    return (pi_output(&pi) + sum) == 12345;
}
"""
UNITY_TEST = """
#include "pi.h"
#include "unity.h"

static const pi_cfg_t cfg = {.kp = 1, .ki = 1, .kp_shift = 1U, .ki_shift = 1U};
static pi_t pi;

void setUp(void) { pi_reset(&pi, 0); }
void tearDown(void) { (void)pi_output(&pi); }
static void test_steps(void) { (void)pi_step(&pi, &cfg, 2, 0, 100); }
static void test_unwinds(void) { pi_unwind(&pi, 1); }
int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_steps);
    RUN_TEST(test_unwinds);
    return UNITY_END();
}
"""
ONE = ctested.Test("one", (), Path(), {}, ())
COUNTED = ("-fprofile-instr-generate", "-fcoverage-mapping", "-fcoverage-mcdc")


class CoverageCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name).resolve()
        for floor in ("math", "control"):
            shutil.copytree(part.ROOT / "firmware" / floor, self.root / "firmware" / floor)
        self.source = self.root / MODULE
        self.test = self.root / "test.c"
        self.test.write_text(TEST, encoding="utf-8")
        self.register = self.root / "justified.toml"
        self.register.write_text("", encoding="utf-8")

    def replace(self, path, text, fault):
        source = path.read_text(encoding="utf-8")
        self.assertEqual(source.count(text), 1, text)
        path.write_text(source.replace(text, fault), encoding="utf-8")

    def justify(self, text, kind):
        self.register.write_text(f'[[justified]]\nfile = "{MODULE}"\nfunction = "pi_limit"\ntext = "{text}"\n'
                                 f'kind = "{kind}"\nreason = "of the test"\n', encoding="utf-8")

    def findings(self, *of_program):
        """Of the module and of the register; the headers have more than the module calls."""
        counted, program = self.root / "pi.o", self.root / "test"
        folders = [f"-I{self.root / 'firmware' / name}"
                   for name in ("math", "math/port", "math/port/generic", "control")]
        coverage.quietly(["clang-19", *COUNTED, *folders, "-c", self.source, "-o", counted])
        coverage.quietly(["clang-19", *COUNTED[:1], *folders, self.test, counted, *of_program, "-o", program])
        coverage.quietly([program], env={**os.environ, "LLVM_PROFILE_FILE": str(self.root / "one.%p.profraw")})
        measured = coverage.measure(coverage.export([counted], coverage.merged(self.root, [ONE], "all", "-sparse")), self.root)
        bad, _, _ = coverage.judge(measured, self.root, self.register)
        return [line for line in bad if line.startswith((MODULE, str(coverage.REGISTER)))]

    def assert_found(self, *what):
        found = self.findings()
        for words in what:
            self.assertTrue([line for line in found if words in line], found)

    def test_what_is_covered_is_no_finding(self):
        self.assertEqual(self.findings(), [])

    def test_a_case_that_the_tests_lack_is_found(self):
        self.replace(self.test, "    sum += pi_step(&pi, &cfg, 2, -1000, 100);\n", "")
        self.assert_found("statement not covered in pi_limit: { output = -limit;",
                          "branch not covered in pi_limit: output < -limit (true)")

    def test_a_condition_that_decides_nothing_is_found(self):
        self.replace(self.source, LINE, "    if ((output > limit) && (u != 12345)) {")
        self.assert_found("mcdc not covered in pi_limit: (u != 12345)",
                          "branch not covered in pi_limit: (u != 12345) (false)")

    def test_a_decision_that_clang_cannot_count_is_found(self):
        self.replace(self.source, LINE, "    if ((output > limit) && (fx_min((u > 0) && (limit > 0), 1) == 1)) {")
        self.assert_found("clang counts no MC/DC of this decision")

    def test_a_justified_gap_is_no_finding(self):
        self.replace(self.source, LINE, "    if (u == 12345) {\n        output = 0;\n    }\n" + LINE)
        self.justify("u == 12345", "branch")
        found = self.findings()
        self.assertEqual(len(found), 1, found)  # the statement alone
        self.assertIn("statement not covered in pi_limit: { output = 0; }", found[0])

    def test_a_justification_that_nothing_needs_is_found(self):
        self.justify("output > limit", "branch")
        self.assert_found("branch 'output > limit' needs no justification")

    def test_a_source_file_that_no_build_has_is_found(self):
        measured = {(MODULE, (1, 1, 1, 1), "statement", ""): True}
        self.assertIn("firmware/control/modulator.c: nothing of it is counted", coverage.not_built(measured, self.root))
        self.assertNotIn("firmware/math/trig_table.c: nothing of it is counted",
                         coverage.not_built(measured, self.root))

    def test_what_a_test_runs_is_told_from_what_it_does_not(self):
        self.replace(self.test, "    pi_unwind(&pi, 1);\n", "")
        self.findings()
        ran = coverage.what_ran(self.root, [ONE])
        self.assertIn("pi_step", ran["tests"]["one"][""])
        self.assertIn("pi_unwind", ran["counted"])
        self.assertNotIn("pi_unwind", ran["tests"]["one"][""])

    def test_what_one_unity_test_runs_is_told_from_what_another_of_its_program_does(self):
        self.test.write_text(UNITY_TEST, encoding="utf-8")
        cache = (part.ROOT / "build" / "host" / "CMakeCache.txt").read_text(encoding="utf-8")
        unity = Path(re.search(r"^UNITY_ROOT:PATH=(.*)$", cache, re.MULTILINE)[1])
        self.findings("-Wl,--wrap=UnityDefaultTestRun", f"-I{unity}", unity / "unity.c",
                      part.ROOT / "tests/evidence/each_test.c")
        ran = coverage.what_ran(self.root, [ONE])["tests"]["one"]
        self.assertEqual({name: [function for function in functions if function.startswith("pi_")]
                          for name, functions in ran.items()},
                         {"": ["pi_integral", "pi_limit", "pi_output", "pi_reset", "pi_step", "pi_sum", "pi_unwind"],
                          "test_steps": ["pi_integral", "pi_limit", "pi_output", "pi_reset", "pi_step", "pi_sum"], "test_unwinds": ["pi_output", "pi_reset", "pi_unwind"]})


if __name__ == "__main__":
    unittest.main()
