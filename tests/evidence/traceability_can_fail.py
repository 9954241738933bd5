# SPDX-License-Identifier: MIT
"""evidence.traceability_can_fail: each kind of broken link is found, in a copy of the register and the sources."""

import shutil
import tempfile
import unittest
from pathlib import Path

import part
import traceability

BUILD = part.ROOT / "build" / "host"
REGISTER = traceability.REGISTER

# What is done to which file: text, what stands there in its place, what is said.
FAULTS = {
    "a function that is gone": (REGISTER, 'functions = ["rotor_position_step"]', 'functions = ["rotor_position_move"]',
                                "A (23): no function rotor_position_move"),
    "a test that is gone": (REGISTER, '"test_position_equals_the_twin_to_the_last_unit"', '"test_position_equals"',
                            "A (23): ctest runs no test test_position_equals"),
    "no function": (REGISTER, 'functions = ["rotor_position_step"]', "functions = []", "A (23): has no functions"),
    "no test": (REGISTER, 'tests = ["gate.no_float"]', "tests = []", "H2: has no tests"),
    "no scope": (REGISTER, 'scope = ["firmware"]', "scope = []", "H2: has no functions"),
    "a scope without code": (REGISTER, 'scope = ["firmware"]', 'scope = ["firmwares"]', "H2: its scope firmwares has no code"),
    "functions and a scope": (REGISTER, 'scope = ["firmware"]', 'scope = ["firmware"]\nfunctions = ["drive_step"]',
                              "H2: has both functions and a scope"),
    "a status that there is not": (REGISTER, 'id = "A (7)"', 'id = "A (7)"\nstatus = "nearly"', "A (7): is 'nearly'"),
    "not met without a word": (REGISTER, 'id = "A (7)"', 'id = "A (7)"\nstatus = "not met"',
                               "A (7): is 'not met' and has no note that says why"),
    "a key misspelt": (REGISTER, 'title = "no float, no heap"', 'titel = "no float, no heap"', "H2: there is no key 'titel'"),
    "an equation left out": (REGISTER, 'id = "A (23)"', 'id = "H23"', "equation (23) of paper A is missing"),
    "a requirement left out": (REGISTER, 'id = "C7.8"', 'id = "C7.9"', "C7.8 is missing"),
    "an equation twice": (REGISTER, 'id = "H2"', 'id = "A (23)"', "A (23) stands twice"),
    "an equation that is not cited": ("firmware/control/rotor_position.h", "paper A (23). ", "",
                                      "A (23): no comment beside rotor_position_step names it"),
    "an equation that there is not": ("firmware/control/rotor_position.h", "paper A (23)", "paper A (24)",
                                      "rotor_position.h:2: there is no equation (24) of paper A"),
    "a function that nothing asks for": ("firmware/control/rotor_position.h", "#endif", "int32_t rotor_extra(void);\n#endif",
                                         "no equation and no requirement names rotor_extra"),
}


NOTHING_COUNTED = {"counted": [], "tests": {}}


def copy(folder):
    for name in (*traceability.SOURCES, REGISTER.parent):
        shutil.copytree(part.ROOT / name, folder / name)


class TraceabilityCanFail(unittest.TestCase):
    def findings(self, path=None, text="", fault="", ran=NOTHING_COUNTED):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            copy(root)
            if path:
                content = (root / path).read_text(encoding="utf-8")
                self.assertIn(text, content, path)
                (root / path).write_text(content.replace(text, fault), encoding="utf-8")
            return traceability.Finder(root, BUILD, REGISTER, ran).check()

    def test_nothing_is_found_in_what_there_is(self):
        self.assertEqual(self.findings(), [])

    def test_each_fault_is_found(self):
        for name, (path, text, fault, said) in FAULTS.items():
            with self.subTest(name):
                bad = self.findings(path, text, fault)
                self.assertTrue([line for line in bad if said in line], bad)

    def found_of_runs(self, own=("rotor_position_step",), whole=("rotor_position_step",), programs=None, tests=None):
        """What is said of A (23) if each of its Unity tests runs the functions `own`, its programs `whole`, and `tests` stand
        there in place of its own."""
        named = next(entry["tests"] for entry in traceability.entries(part.ROOT / REGISTER) if entry["id"] == "A (23)")
        of = traceability.tests(BUILD)
        ran = {program: {"": list(whole), "test_of_another": list(whole), **dict.fromkeys(named, list(own))}
               for test in named for program in of[test] if programs is None or program in programs}
        shown = {"counted": ["rotor_position_step", "drive_step"], "tests": ran}
        text = "tests = [" + ", ".join(f'"{test}"' for test in named) + "]"
        new = "tests = [" + ", ".join(f'"{test}"' for test in tests or named) + "]"
        return [line for line in self.findings(REGISTER, text, new, shown) if "A (23): rotor_position_step is run" in line]

    def test_a_test_that_runs_the_function_is_no_finding(self):
        self.assertEqual(self.found_of_runs(), [])

    def test_a_program_that_does_not_run_the_function_is_found(self):
        self.assertTrue(self.found_of_runs(own=["drive_step"], whole=["drive_step"]))

    def test_a_test_that_does_not_run_what_others_of_its_program_do_is_found(self):
        self.assertTrue(self.found_of_runs(own=["drive_step"]))

    def test_a_test_that_is_not_counted_does_not_excuse_those_that_are(self):
        counted = ["test_rotor_position"]
        tests = ["test_constant_speed_of_one_unit_neither_rounds_nor_drifts", "gate.no_float"]
        self.assertTrue(self.found_of_runs(own=["drive_step"], programs=counted, tests=tests))
        self.assertEqual(self.found_of_runs(programs=counted, tests=tests), [])

    def test_an_entry_without_a_counted_test_is_not_asked(self):
        self.assertEqual(self.found_of_runs(own=["drive_step"], whole=["drive_step"], programs=[]), [])


if __name__ == "__main__":
    unittest.main()
