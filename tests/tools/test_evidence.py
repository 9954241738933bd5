# SPDX-License-Identifier: MIT
"""tools/dev evidence: which parts are due, what a stop leaves, and what its page and its cost say."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools/evidence"), str(ROOT / "tools/gates")]

import ctest_run  # noqa: E402
import ctested  # noqa: E402
import fuzz  # noqa: E402
import page  # noqa: E402
import part  # noqa: E402
import run  # noqa: E402
import run_tests  # noqa: E402

SPINS = "import time; [None for _ in iter(lambda: time.process_time() < {}, False)]"


def ended(name, passed=True):
    return ctest_run.Ended(name, passed, 2.0)


class Evidence(unittest.TestCase):
    """A project with one source, and one part of two tests."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.source = self.root / "source.c"
        self.source.write_text("one", encoding="utf-8")
        subprocess.run(["git", "init", "-q", self.root], check=True)
        for name, value in {"ROOT": self.root, "OUT": self.root}.items():
            patch = mock.patch.object(run, name, value)
            patch.start()
            self.addCleanup(patch.stop)
        self.part = run.Part("part", "says", ["part.*"], ["source.c"], 30, tests=["part.a", "part.b"])

    def state(self):
        return run.State(self.root / "state.json")

    def note(self, *tests):
        progress = run.Progress([self.part], self.state(), {"part": self.part.digest()})
        with mock.patch("builtins.print"):
            for test in tests:
                progress.note(test)
        return progress

    def pass_all(self):
        return self.note(ended("part.a"), ended("part.b"))

    def test_a_part_is_due_until_all_its_tests_have_passed(self):
        self.assertTrue(self.state().is_due(self.part))
        self.note(ended("part.a"))
        self.assertTrue(self.state().is_due(self.part))
        self.pass_all()
        self.assertFalse(self.state().is_due(self.part))

    def test_a_part_with_a_test_that_fails_stays_due_and_is_named(self):
        progress = self.note(ended("part.a", passed=False), ended("part.b"))
        self.assertEqual(progress.failed, {"part": ["part.a"]})
        self.assertTrue(self.state().is_due(self.part))

    def test_a_part_that_has_passed_and_then_fails_with_the_same_inputs_is_due(self):
        self.pass_all()
        self.note(ended("part.a", passed=False))
        self.assertTrue(self.state().is_due(self.part))

    def test_a_failure_of_what_a_part_needs_is_named(self):
        self.assertEqual(self.note(ended("of.another", passed=False)).needed, ["of.another"])

    def test_a_part_is_due_again_by_the_content_of_its_inputs_and_not_by_their_time(self):
        self.pass_all()
        os.utime(self.source, (1, 1))
        self.assertFalse(self.state().is_due(self.part))
        self.source.write_text("two", encoding="utf-8")
        self.assertTrue(self.state().is_due(self.part))
        self.source.write_text("one", encoding="utf-8")
        self.assertFalse(self.state().is_due(self.part))

    def test_what_changes_while_a_part_is_made_makes_it_due_again(self):
        progress = run.Progress([self.part], self.state(), {"part": self.part.digest()})
        self.source.write_text("two", encoding="utf-8")
        with mock.patch("builtins.print"):
            progress.note(ended("part.a"))
            progress.note(ended("part.b"))
        self.assertTrue(self.state().is_due(self.part))

    def test_a_part_whose_figures_are_gone_is_due(self):
        self.part.figures = True
        self.pass_all()
        self.assertTrue(self.state().is_due(self.part))
        self.part.output().write_text("{}", encoding="utf-8")
        self.assertFalse(self.state().is_due(self.part))

    def test_a_state_that_was_cut_is_none(self):
        self.pass_all()
        (self.root / "state.json").write_text('{"passed"', encoding="utf-8")
        self.assertTrue(self.state().is_due(self.part))

    def test_what_a_part_takes_is_that_of_its_last_run(self):
        self.assertEqual(self.state().core_minutes(self.part), 30)
        self.note(ended("part.a"))
        self.assertEqual(self.state().core_minutes(self.part), 30)
        self.pass_all()
        self.part.tests = []  # before a build has listed them
        self.assertAlmostEqual(self.state().core_minutes(self.part), 4 / 60)

    def test_a_program_is_installed_when_a_part_that_needs_it_is_due_and_else_not(self):
        self.part.programs = ["cargo"]
        other = run.Part("other", "says", ["other.*"], ["source.c"], 30)
        with mock.patch.object(run.subprocess, "run") as called:
            run.set_up([other])
            called.assert_not_called()
            run.set_up([other, self.part])
        called.assert_called_once_with([self.root / "tools/setup/apt", "cargo"], check=False)

    def test_a_test_of_no_part_or_of_two_is_found(self):
        tests = {name: mock.Mock(labels={"evidence"}) for name in ("part.a", "other")}
        self.assertIn("other belongs to 0 parts", "\n".join(run.assign([self.part], tests)))
        self.assertIn("part.a belongs to 2 parts", "\n".join(run.assign([self.part, self.part], tests)))

    def test_a_pattern_that_no_test_of_the_evidence_matches_is_found(self):
        self.part.patterns.append("gone.*")
        self.assertEqual(list(run.assign([self.part], {"part.a": mock.Mock(labels={"evidence"})})),
                         ["parts.toml: part: no test of the label evidence matches gone.*"])

    def test_the_page_names_a_part_that_was_not_made_and_escapes_its_texts(self):
        part.end(self.root / "one.json", "one", "One", "What <is> shown.", [part.figure("share", "98 %", "≥ 95 %", False)], [])
        text = page.page([page.read(self.root, name) for name in ("one", "two")])
        self.assertIn("This part was not made.", text)
        self.assertIn("What &lt;is&gt; shown.", text)
        self.assertIn('<span class="verdict bad">not kept</span>', text)


class Command(Evidence):
    """What is typed after `tools/dev evidence` and `tools/dev test`."""

    def call(self, *words):
        patches = (mock.patch.object(sys, "argv", ["evidence", *words]), mock.patch.object(run, "finish", self.finish),
                   mock.patch("builtins.print"))
        with patches[0], patches[1], patches[2] as said:
            return run.main(), "".join(str(call.args[0]) for call in said.call_args_list)

    def finish(self, parts, due, _state):
        self.assertTrue({one.name for one in due} <= {one.name for one in parts})
        self.due = [one.name for one in due]
        return 0

    def test_a_part_alone_is_made(self):
        self.assertEqual(self.call("proof")[0], 0)
        self.assertEqual(self.due, ["proof"])

    def test_a_part_that_is_none_is_refused_in_one_line_that_names_all(self):
        status, said = self.call("fuzzing")
        self.assertEqual(status, 2)
        self.assertRegex(said, r"^tools/dev evidence: found 'fuzzing'; allowed: proof, .*fuzz, [^\n]*$")

    def test_the_list_names_each_part(self):
        said = self.call("--list")[1]
        for one in run.parts_of(run.PARTS.read_text(encoding="utf-8")):
            self.assertIn(f" {one.name} ", said)

    def test_a_stop_is_said_in_one_line(self):
        with mock.patch.object(self, "finish", side_effect=KeyboardInterrupt):
            status, said = self.call()
        self.assertEqual(status, run.STOPPED)
        self.assertRegex(said, r"^\nevidence: stopped; 0 of \d+ parts hold; .*$")

    def test_each_part_that_the_entry_script_or_a_page_names_is_one(self):
        names = {one.name for one in run.parts_of(run.PARTS.read_text(encoding="utf-8"))}
        called = re.findall(r"evidence (\w+) \"\$@\"", (ROOT / "tools/dev").read_text(encoding="utf-8"))
        self.assertEqual(called, ["coverage"])
        table = re.search(r"\| part \| requirement \|\n.*\n((?:\|.*\n)*)", (ROOT / "docs/evidence.md").read_text(encoding="utf-8"))[1]
        self.assertEqual(set(re.findall(r"^\| (\w+) \|", table, re.M)), names)

    def test_ctest_gets_the_options_of_the_user_and_leaves_the_evidence_out(self):
        always = ["-j2", "--output-on-failure", "--no-tests=error", "-LE"]
        for typed, given in {(): ["^evidence$"], ("-L", "gate"): ["^evidence$", "-L", "gate"],
                             ("-LE", "docs", "-V"): ["^evidence$|docs", "-V"], ("-R", "test_pi"): ["^evidence$", "-R", "test_pi"],
                             ("-E", "a", "-j1"): ["^evidence$", "-E", "a", "-j1"]}.items():
            self.assertEqual(run_tests.words_for_ctest(typed), (always + given, None))

    def test_a_word_that_belongs_to_no_option_of_ctest_is_refused(self):
        for typed in (("test_pi",), ("-R", "a", "test_pi"), ("-V", "test_pi")):
            self.assertEqual(run_tests.words_for_ctest(typed)[1],
                             "tools/dev test: found 'test_pi'; allowed: options of ctest, for instance -R test_pi")


class ThisProject(unittest.TestCase):
    def test_each_test_of_the_evidence_belongs_to_one_part_whose_inputs_exist(self):
        parts = run.parts_of(run.PARTS.read_text(encoding="utf-8"))
        tests = ctested.listed(ROOT / "build/host", whole=False)
        self.assertEqual(list(run.assign(parts, tests)), [])
        for one in parts:
            for path in one.inputs:
                self.assertTrue((ROOT / path).exists(), f"{one.name}: {path}")


    def test_each_program_that_takes_any_bytes_is_fuzzed(self):
        listed = (ROOT / "tests/fuzz/CMakeLists.txt").read_text(encoding="utf-8")
        self.assertEqual(set(re.findall(r"^nf_add_fuzzed\((\w+) ", listed, re.M)), set(fuzz.PROGRAMS))


class Cost(unittest.TestCase):
    """The processor time of tests that ctest runs."""

    def measured(self, seconds):
        with tempfile.TemporaryDirectory() as folder:
            command = [os.path.normpath(sys.executable), "-c", SPINS.format(seconds)]
            words = " ".join(f'"{word}"' for word in command)
            (Path(folder) / "CTestTestfile.cmake").write_text(f"add_test(spins {words})\n", encoding="utf-8")
            with mock.patch("builtins.print"):
                return list(ctest_run.Run(folder, [], {"spins": command}))

    def test_it_is_what_the_test_has_used(self):
        (test,) = self.measured(2)
        self.assertTrue(test.passed)
        # Of the last look before its end, and of the start of the interpreter.
        self.assertGreater(test.core_seconds, 2 - 2 * ctest_run.LOOK_S)
        self.assertLess(test.core_seconds, 2 + 2 * ctest_run.LOOK_S)

    def test_lines_of_a_ctest_that_a_test_has_called_are_not_tests(self):
        lines = ("  1/2 Test  #7: one ....   Passed    0.10 sec", " 12/286 Test #31: inner ...***Failed    0.01 sec",
                 " 1/286 Test #31: inner ...   Passed    0.01 sec", "  2/2 Test  #9: two ...***Failed    0.20 sec")
        self.assertEqual(list(ctest_run.own_lines(lines)), [("one", "Passed"), ("two", "***Failed")])

    def too_dear(self, ended, **labels):
        names = {test.name for test in ended} | set(labels)
        return list(run_tests.too_dear(ended, {name: mock.Mock(labels=set(labels.get(name, ()))) for name in names}))

    def test_a_test_that_takes_more_of_the_whole_than_allowed_is_found_unless_it_has_a_reason(self):
        share = run_tests.FAILS + 0.001
        names = [f"n{number}" for number in range(99)]
        for seconds in (1, 1000):
            ended = [ctest_run.Ended(name, True, (1 - share) * seconds / 99) for name in names]
            ended += [ctest_run.Ended("a", True, share * seconds), ctest_run.Ended("built", True, 5 * seconds)]
            self.assertEqual([line.split(":")[0] for line in self.too_dear(ended, built=["dear"])], ["a"])
            self.assertEqual(self.too_dear(ended, a=["dear"], built=["dear"]), [])

    def test_of_a_part_of_the_tests_no_share_is_judged(self):
        ended = [ctest_run.Ended("a", True, 1.0)]
        self.assertEqual(self.too_dear(ended, b=[]), [])
        self.assertEqual(len(self.too_dear(ended, b=["evidence"])), 1)


if __name__ == "__main__":
    unittest.main()
