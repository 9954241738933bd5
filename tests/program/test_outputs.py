# SPDX-License-Identifier: MIT
"""programs.outputs, gaindesign.outputs: a program whose results could not be written says so, and leaves no half of a file.

test_outputs.py PROGRAM..., of motorsim, nfconfig and gaindesign. The last computes for seconds; it has a test of its own.
"""

import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROGRAMS = {Path(program).name: program for program in sys.argv[1:]}
MOTORSIM, NFCONFIG, GAINDESIGN = "motorsim", "nfconfig", "gaindesign"
DONE, LIMIT_BROKEN, BAD_INPUT = 0, 1, 2
PATIENCE_S = 30
ROOM = 100  # bytes of a file, in place of a disk that is full; each result is longer

SHORT = ("s1", "--set", "scenario.duration_s=0.01", "--set", "scenario.evaluate_from_s=0",
         "--set", "scenario.command=[{time_s = 0, speed_rpm = 0}]")
CERTIFY = ("motor_a", "--runs", "1", "--tuning", "any", "--overwrite")
SHEET = ("--name", "m", "--poles", "8", "--resistance", "1 ohm phase", "--inductance", "1 mH phase", "--kv", "100 rpm/V six-step",
         "--rated-speed", "1000", "--rated-torque", "1 N.m", "--max-current", "20 A peak", "--inertia", "1 kg.cm2", "--friction", "0")
PARTS = ("--motor", "motor_a", "--board", "g431_bench")
# Each option that names a file to write.
WRITERS = {
    **{(MOTORSIM, "run", option): SHORT for option in ("--trace", "--json", "--record", "--extremes", "--vcd")},
    (MOTORSIM, "bench", "--json"): ("--runs", "1"),
    **{(MOTORSIM, "identify", option): ("s1", "--overwrite") for option in ("--output", "--log", "--json")},
    (MOTORSIM, "motor", "--output"): (*SHEET, "--overwrite"),
    **{(MOTORSIM, "certify", option): CERTIFY for option in ("--output", "--json")},
    (NFCONFIG, "header", "--out"): PARTS,
    (NFCONFIG, "hal-header", "--out"): PARTS,
    (NFCONFIG, "hal-memory", "--out"): PARTS,
    (NFCONFIG, "alike", "--out"): (*PARTS, "--count", "1"),
    (NFCONFIG, "block", "--out"): (*PARTS, "--overwrite"),
    (GAINDESIGN, "design", "--json"): (),
}
WRITERS = {writer: settings for writer, settings in WRITERS.items() if writer[0] in PROGRAMS}
# Each command that prints, but for the replay, which needs a recording, the live view, which needs a board, and the zoo,
# which writes files only.
PRINTERS = (
    (MOTORSIM, "run", *SHORT), (MOTORSIM, "run", *SHORT, "--json", "-"), (MOTORSIM, "list"), (MOTORSIM, "signals", "s1"),
    (MOTORSIM, "estimators"),
    (MOTORSIM, "bench", "--runs", "1"), (MOTORSIM, "bench", "--runs", "1", "--json", "-"), (MOTORSIM, "debug", "s1"),
    (MOTORSIM, "identify", "s1"), (MOTORSIM, "identify", "s1", "--json", "-"),
    (MOTORSIM, "motor", *SHEET),
    (MOTORSIM, "certify", *CERTIFY), (MOTORSIM, "certify", *CERTIFY, "--json", "-"),
    (NFCONFIG, "header", *PARTS), (NFCONFIG, "hal-header", *PARTS), (NFCONFIG, "hal-memory", *PARTS), (NFCONFIG, "pins", "stm32g431cb"), (NFCONFIG, "show", *PARTS), (NFCONFIG, "keys"),
    (NFCONFIG, "block", *PARTS, "--out", "-"),
    (NFCONFIG, "list"), (NFCONFIG, "alike", *PARTS, "--count", "1"),
    (GAINDESIGN, "design"), (GAINDESIGN, "compare"), (GAINDESIGN, "check", "0.264", "0.035"),
)
PRINTERS = [printer for printer in PRINTERS if printer[0] in PROGRAMS]
of_motorsim = unittest.skipUnless(MOTORSIM in PROGRAMS, "a recording or a trace is motorsim's")


def little_room():
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, ROOM))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # the write fails, as it does where a disk is full


def run(program, *arguments, **options):
    options = {"stdout": subprocess.PIPE, "input": "print state\n", **options}
    return subprocess.run((PROGRAMS[program], *arguments), stderr=subprocess.PIPE, text=True, **options)


def commands_of(program):
    text = run(program, "--help").stdout
    listed = text[text.upper().index("\nSUBCOMMANDS:"):].partition("\n\n")[0]
    return re.findall(r"^  ([a-z-]+) ", listed, re.MULTILINE)


class Outputs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.file = self.folder / "result"

    def assert_one_line(self, done, start):
        self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
        self.assertRegex(done.stderr, rf"\A\w+: {re.escape(str(start))}: cannot write: [^\n]+\n\Z")

    def write(self, writer, **options):
        program, command, option = writer
        return run(program, command, *WRITERS[writer], option, self.file, **options)

    def each_writer(self, check):
        for writer in WRITERS:
            self.file.unlink(missing_ok=True)
            with self.subTest(writer):
                check(writer)

    def test_each_option_that_writes_a_file_is_looked_at_here(self):
        for program, command in {writer[:2] for writer in WRITERS}:
            help_text = run(program, command, "--help").stdout
            named = set(re.findall(r"(--[a-z-]+) (?:FILE|TEXT).* write\b", help_text))
            self.assertEqual(named, {option for *where, option in WRITERS if tuple(where) == (program, command)})

    def assert_whole_and_alone(self, writer):
        done = self.write(writer)
        self.assertIn(done.returncode, (DONE, LIMIT_BROKEN), done.stderr)
        self.assertGreater(self.file.stat().st_size, ROOM)
        self.assertEqual(list(self.folder.iterdir()), [self.file])

    def test_a_result_is_there_under_its_name_alone(self):
        self.each_writer(self.assert_whole_and_alone)

    def assert_nothing_left(self, writer):
        self.assert_one_line(self.write(writer, preexec_fn=little_room), self.file)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_result_that_does_not_fit_leaves_nothing(self):
        self.each_writer(self.assert_nothing_left)

    def assert_left_as_it_was(self, writer):
        self.file.write_text("of yesterday")
        self.assert_one_line(self.write(writer, preexec_fn=little_room), self.file)
        self.assertEqual(list(self.folder.iterdir()), [self.file])
        self.assertEqual(self.file.read_text(), "of yesterday")

    def test_a_result_that_does_not_fit_leaves_the_one_before_as_it_was(self):
        self.each_writer(self.assert_left_as_it_was)

    def assert_named(self, writer):
        self.assert_one_line(self.write(writer), self.file)

    def test_a_folder_that_is_not_there_is_named(self):
        self.file = self.folder / "no" / "such" / "file"
        self.each_writer(self.assert_named)

    def test_a_full_device_is_named(self):
        link = self.file
        for writer in WRITERS:
            with self.subTest(writer):
                link.symlink_to("/dev/full")
                self.assert_named(writer)
                self.assertTrue(link.is_symlink())
                link.unlink()

    @of_motorsim
    def test_a_result_goes_where_a_link_leads_and_keeps_its_rights(self):
        there = self.folder / "there"
        there.write_text("of yesterday")
        there.chmod(0o640)
        self.file.symlink_to(there)
        self.write((MOTORSIM, "run", "--json"))
        self.assertTrue(self.file.is_symlink())
        self.assertGreater(there.stat().st_size, ROOM)
        self.assertEqual(there.stat().st_mode & 0o777, 0o640)

    def test_a_file_in_memory_is_as_any_other(self):
        with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
            self.folder, self.file = Path(folder), Path(folder) / "result"
            self.each_writer(self.assert_left_as_it_was)

    @of_motorsim
    def test_a_file_that_is_open_already_is_written_in_place(self):
        for name in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
            with self.subTest(name), open(self.file, "w") as there:
                done = run(MOTORSIM, "run", *SHORT, "--json", name, stdout=there)
                self.assertIn(done.returncode, (DONE, LIMIT_BROKEN), done.stderr)
                self.assertEqual(os.fstat(there.fileno()).st_ino, self.file.stat().st_ino)
                self.assertGreater(self.file.stat().st_size, ROOM)

    @of_motorsim
    def test_a_pipe_gets_the_result(self):
        done = run(MOTORSIM, "run", *SHORT, "--trace", "/dev/stderr", stdout=subprocess.DEVNULL)
        self.assertTrue(done.stderr.startswith("time_s,"), done.stderr[:80])


    def assert_removed_by(self, number):
        """While it is written, the file has another name. The program ends by the signal as it would without a file."""
        long = (*SHORT, "--set", "scenario.duration_s=1000")
        with subprocess.Popen((PROGRAMS[MOTORSIM], "run", *long, "--trace", self.file, "--vcd", self.folder / "other"),
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as started:
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end and len(list(self.folder.glob("*.part"))) < 2:
                time.sleep(0.01)
            self.assertEqual(len(list(self.folder.glob("*.part"))), 2)
            started.send_signal(number)
            self.assertEqual(started.wait(PATIENCE_S), -number)

    @of_motorsim
    def test_a_signal_that_ends_the_program_leaves_the_file_of_before_and_nothing_else(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(number):
                self.file.write_text("of yesterday")
                self.assert_removed_by(number)
                self.assertEqual(list(self.folder.iterdir()), [self.file])
                self.assertEqual(self.file.read_text(), "of yesterday")

    @of_motorsim
    def test_a_signal_that_is_ignored_does_not_end_it(self):
        def ignores():
            signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does

        with subprocess.Popen((PROGRAMS[MOTORSIM], "run", *SHORT, "--trace", self.file), preexec_fn=ignores,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as started:
            while started.poll() is None:
                started.send_signal(signal.SIGHUP)
                time.sleep(0.001)
        self.assertIn(started.returncode, (DONE, LIMIT_BROKEN))
        self.assertEqual(list(self.folder.iterdir()), [self.file])


class FullOutput(unittest.TestCase):
    def assert_refused(self, *command):
        with self.subTest(command), open("/dev/full", "w") as full:
            done = run(*command, stdout=full)
            self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
            self.assertIn(": standard output: cannot write", done.stderr.splitlines()[-1])

    def test_help_is_refused(self):
        for program in PROGRAMS:
            self.assert_refused(program, "--help")
            commands = commands_of(program)
            self.assertGreater(len(commands), 2)
            for command in commands:
                self.assert_refused(program, command, "--help")

    def test_each_command_is_looked_at_here(self):
        for program in PROGRAMS:
            looked_at = {command for one, command, *_ in PRINTERS if one == program}
            self.assertEqual(set(commands_of(program)) - {"replay", "zoo", "live"}, looked_at)

    @unittest.skipUnless(NFCONFIG in PROGRAMS, "the zoo is nfconfig's")
    def test_the_zoo_writes_files_that_refer_to_each_other(self):
        with tempfile.TemporaryDirectory() as folder:
            into = Path(folder) / "new"
            done = run(NFCONFIG, "zoo", "zoo:17", "--out", into)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (DONE, "", ""))
            self.assertEqual({path.name for path in into.iterdir()}, {"motor.toml", "board.toml", "exact.toml", "user.toml"})
            if MOTORSIM in PROGRAMS:
                short = ("--set", "scenario.duration_s=0.5", "--set", "scenario.evaluate_from_s=0")
                written, drawn = (run(MOTORSIM, "run", one, *short).stdout.partition("\n  motor")[2]
                                  for one in (into / "user.toml", "zoo:17:user"))
                self.assertEqual(written, drawn)
                self.assertIn("flux_linkage_wb", written)

    @unittest.skipUnless(NFCONFIG in PROGRAMS, "the zoo is nfconfig's")
    def test_a_folder_for_the_zoo_that_is_none_is_named(self):
        done = run(NFCONFIG, "zoo", "zoo:17", "--out", "/dev/full")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn("/dev/full/motor.toml: cannot write", done.stderr)

    def test_tables_are_refused(self):
        for command in PRINTERS:
            self.assert_refused(*command)

    @of_motorsim
    def test_what_was_replayed_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log"
            run(MOTORSIM, "run", *SHORT, "--record", log)
            self.assert_refused(MOTORSIM, "replay", log)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
