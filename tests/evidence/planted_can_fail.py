# SPDX-License-Identifier: MIT
"""evidence.planted_can_fail: a row that shows nothing is a finding, and a row that holds is none."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import part
import planted

BUILD = part.ROOT / "build" / "host"
FAULT = planted.Fault("a wrong sign", "drive", "firmware/control/pi.c", "excess * Q15_TO_Q26", "excess * -Q15_TO_Q26", ("test_pi",))
HARMLESS = {"old": '#include "pi.h"\n', "new": '#include "pi.h"\n\n'}
ROWS = {  # what is changed in a row that holds, and what is then said
    "that holds": ({}, None),
    "that changes nothing": (HARMLESS, "test_pi passes with the fault in"),
    "that one of its tests does not find": ({"tests": ("test_pi", "test_modulator")}, "test_modulator passes"),
    "whose test runs other code": ({"tests": ("test_trig",)}, "test_trig runs nothing of firmware/control/pi.c"),
    "that does not compile": ({"new": "excess->none"}, "cannot be built with it"),
    "whose text is gone": ({"old": "pi->gone"}, "stands there 0 times; expected once"),
}


class RowsCanFail(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.copy = planted.copy_of(part.ROOT, cls.folder / "copy")
        cls.runner = planted.Runner(part.ROOT, BUILD)

    def wrong(self, fault, name):
        return self.runner.judge(fault, self.copy, self.folder / name).wrong

    def test_each_row_that_shows_nothing_is_a_finding(self):
        for name, (change, said) in ROWS.items():
            with self.subTest(name):
                wrong = self.wrong(replace(FAULT, **change), name)
                self.assertEqual(bool(wrong), said is not None, wrong)
                self.assertTrue(said is None or said in wrong[0], wrong)

    def test_a_test_that_fails_without_the_fault_too_is_a_finding(self):
        failing = replace(self.runner.listed["test_pi"], command=("false",))
        self.runner.listed["failing"] = failing
        self.assertEqual(self.wrong(replace(FAULT, tests=("failing",)), "failing"), ["failing fails without the fault too"])

    def test_what_a_program_of_the_build_generates_is_followed(self):
        fault = planted.Fault("another share", "config", "host_sim/config/units/supervision_units.cpp",
                              "constexpr double LATE_WINDOW_S = 1;", "constexpr double LATE_WINDOW_S = 2;", ("test_shipped",))
        self.assertEqual(self.wrong(fault, "generated"), ["test_shipped passes with the fault in"])

    def test_the_copy_is_afterwards_as_it_was(self):
        for fault in (FAULT, replace(FAULT, file="firmware/control/new.h", old="", new="\n")):
            path = self.copy / fault.file
            before = path.read_bytes() if path.is_file() else None
            with planted.Planted(self.copy, fault):
                self.assertNotEqual(path.read_bytes(), before)
            self.assertEqual(path.read_bytes() if path.is_file() else None, before)


if __name__ == "__main__":
    unittest.main()
