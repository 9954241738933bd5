# SPDX-License-Identifier: MIT
"""evidence.traceability_can_fail: each kind of broken link is found, in a copy of the register and the sources; and what
stands in a source in an uncommon form is read as the compiler reads it."""

import shutil
import tempfile
import unittest
from pathlib import Path

import part
import syntax
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
    "an equation left out": (REGISTER, 'id = "A (23)"', 'id = "H23"', "equation (23) of paper A is missing"),
    "a requirement left out": (REGISTER, 'id = "C7.8"', 'id = "C7.9"', "C7.8 is missing"),
    "an equation that is not cited": ("firmware/control/rotor_position.h", "paper A (23). ", "",
                                      "A (23): no comment beside rotor_position_step names it"),
    "an equation that there is not": ("firmware/control/rotor_position.h", "paper A (23)", "paper A (24)",
                                      "there is no equation (24) of paper A"),
}

# Language, header, source, the functions that are defined in them: name, file and line.
FORMS = {
    "a declaration": ("c", "int32_t\nrotor_extra(int32_t (*first)(void),\n            int32_t second);", "", []),
    "a definition in a comment": ("c", "/*\nint32_t rotor_extra(void) {}\n*/", "", []),
    "the marks of a comment in strings": ("c", "", 'char A[] = "/*";\nint rotor_extra(void)\n{\n}\nchar B[] = "*/";',
                                          [("rotor_extra", "a.c:2")]),
    "a macro in place of a loop": ("c", "", "void rotor_extra(void)\n{\n    FOR_EACH(leg) {\n    }\n}", [("rotor_extra", "a.c:1")]),
    "a function that a macro defines": ("c", "", "#define ROTOR(name) int32_t name(void) { return 0; }\nROTOR(rotor_extra)",
                                        [("rotor_extra", "a.c:2")]),
    "a structure that is returned": ("c", "", "rotor_t rotor_extra(int32_t a)\n{\n    return (rotor_t){a, a};\n}",
                                     [("rotor_extra", "a.c:1")]),
    "a method": ("c++", "class Rotor {\n    angle_t extra() const;\n};", "angle_t Rotor::extra() const\n{\n}", [("extra", "a.cpp:1")]),
}
CITING = """/*
 * By (4) and, as paper A
 * says, (5)–(6), paper A (7).
 */
const char NO_COMMENT[] = "paper B (8)"; // (9)
"""
UNITY_TESTS = """TEST(test_one)
{
    puts("TEST(test_in_a_string)"); // TEST(test_in_a_comment)
}
TEST(
    test_over_lines)
{
}
"""
PYTHON_TESTS = '''
class Tests:
    def test_one(self):
        """
        def test_in_a_string(self):
        """
    def test_over_lines(
            self):
        pass
'''

NOTHING_COUNTED = {"counted": [], "tests": {}}


class TraceabilityCanFail(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        for name in (*traceability.SOURCES, REGISTER.parent):
            shutil.copytree(part.ROOT / name, cls.root / name)

    def findings(self, path=REGISTER, text="", fault="", ran=NOTHING_COUNTED):
        """With `fault` in place of `text` in a file, which is as it was afterwards."""
        content = (self.root / path).read_text(encoding="utf-8")
        self.assertIn(text, content, path)
        try:
            (self.root / path).write_text(content.replace(text, fault) if text else content, encoding="utf-8")
            return traceability.Finder(self.root, BUILD, REGISTER, ran).check()
        finally:
            (self.root / path).write_text(content, encoding="utf-8")

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

    def test_a_function_that_its_tests_do_not_run_is_found(self):
        other = ["drive_step"]
        one_counted = {"programs": ["test_rotor_position"],
                       "tests": ["test_constant_speed_of_one_unit_neither_rounds_nor_drifts", "gate.no_float"]}
        for name, runs, found in (
                ("the test runs it", {}, False),
                ("its program does not run it", {"own": other, "whole": other}, True),
                ("only others of its program run it", {"own": other}, True),
                ("a test that is not counted does not excuse those that are", {"own": other, **one_counted}, True),
                ("a test that is not counted is not asked", one_counted, False),
                ("no test is counted", {"own": other, "whole": other, "programs": []}, False)):
            with self.subTest(name):
                self.assertEqual(bool(self.found_of_runs(**runs)), found)


class SourcesAreReadAsTheCompilerReadsThem(unittest.TestCase):
    def read(self, language, header, source):
        suffix = {"c": ".c", "c++": ".cpp"}[language]
        return syntax.parsed(language, ((Path("a.h"), header), (Path("a").with_suffix(suffix), source)), traceability.PAPER)

    def test_each_form_of_a_function(self):
        for name, (language, header, source, there) in FORMS.items():
            with self.subTest(name):
                functions, _ = self.read(language, header, source)
                self.assertEqual([(function, str(place)) for function, place in functions], there)

    def test_the_equations_of_comments_with_their_lines(self):
        _, comments = self.read("c", "// (3)", CITING)
        cited = [(*equation, str(place)) for equation, place in traceability.cited(comments)]
        self.assertEqual(sorted(cited), [("A", 3, "a.h:1"), ("A", 4, "a.c:2"), ("A", 5, "a.c:3"), ("A", 6, "a.c:3"),
                                         ("A", 7, "a.c:3"), ("A", 9, "a.c:5")])

    def test_each_test_of_a_program_and_of_a_module(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in (("a.c", UNITY_TESTS), ("a.cpp", UNITY_TESTS), ("a.py", PYTHON_TESTS)):
                path = Path(folder) / name
                path.write_text(text, encoding="utf-8")
                with self.subTest(name):
                    self.assertEqual(syntax.test_functions(path), {"test_one", "test_over_lines"})


if __name__ == "__main__":
    unittest.main()
