# SPDX-License-Identifier: MIT
"""evidence.misra_can_fail: a violation in the code is found, and each hole in the table.

The gate runs over the small tree of gate.selftest; the table is made of what it writes.
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import misra
import part
import selftest

GATE = part.ROOT / "tools" / "gates" / "misra.py"
RULES = part.ROOT / misra.RULES
SOURCE = "firmware/control/pi.c"
ALL_TESTS = {test for entries in misra.Guidelines(RULES).held.values() for _, test in entries}


class MisraCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        selftest.plant(self.root, selftest.CLEAN)

    def replace(self, path, text, fault):
        content = (self.root / path).read_text(encoding="utf-8")
        self.assertIn(text, content)
        (self.root / path).write_text(content.replace(text, fault), encoding="utf-8")

    def table(self, checked=None, guidelines=None, tests=ALL_TESTS):
        """Guideline → status, and what is wrong."""
        checked = checked or {"findings": [], "files": [SOURCE]}
        table = misra.Table(self.root, guidelines or misra.Guidelines(RULES), checked, tests)
        return {row[0]: row[3] for row in table.rows()}, table.bad

    def gate(self):
        """What gate.misra writes."""
        out = self.root / "checked.json"
        subprocess.run([sys.executable, GATE, "--root", self.root, "--out", out], capture_output=True, check=False)
        return json.loads(out.read_text(encoding="utf-8"))

    def test_registered_deviations_are_no_violations(self):
        status, bad = self.table(self.gate())
        self.assertEqual((status["11.4"], status["8.7"], status["15.6"], bad),
                         ("deviation", "not followed", "compliant", []))

    def test_a_violation_in_the_code_is_found(self):
        self.replace(SOURCE, selftest.TAG, "")
        self.replace("firmware/MISRA.md", "| D1 |", "| E1 |")
        status, bad = self.table(self.gate())
        self.assertEqual(status["11.4"], "violated")
        self.assertTrue(bad[0].startswith(f"{SOURCE}:6: "), bad)

    def test_a_finding_of_cppcheck_itself_is_one(self):
        self.replace(SOURCE, "{\n", "{\n    int32_t x;\n    x = x + 1;\n")
        _, bad = self.table(self.gate())
        self.assertTrue([line for line in bad if "[uninitvar]" in line], bad)

    def test_a_mandatory_rule_takes_no_deviation_and_a_required_one_is_followed(self):
        self.replace("firmware/MISRA.md", "| D1 | 11.4 |", "| D1 | 9.1 |")
        self.replace("firmware/MISRA.md", "8.7, 15.5", "8.7, 8.4")
        bad = " ".join(self.table()[1])
        self.assertIn("9.1 is mandatory and has a deviation", bad)
        self.assertIn("8.4 is required and is not followed", bad)

    def test_what_is_not_applicable_does_not_occur(self):
        self.replace(SOURCE, "{\n", "{\n    goto end;\n")
        status, bad = self.table()
        self.assertEqual(bad[0], f"{SOURCE}:6: not so: no goto, no label (15.1)")
        self.assertEqual(status["15.1"], "compliant")  # by the checker


if __name__ == "__main__":
    unittest.main()
