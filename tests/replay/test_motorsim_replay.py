# SPDX-License-Identifier: MIT
"""replay.motorsim: recordings on the command line, written, replayed, stepped through and refused.

test_motorsim_replay.py MOTORSIM
"""

import base64
import csv
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

MOTORSIM = sys.argv[1]
FAULT = ('scenario.fault=[{time_s = 0.3, what = "break_input", until_s = 0.31}, '
         '{time_s = 0.4, what = "adc_a_high"}]')
CLEAR = "scenario.request=[{time_s = 0.32, clear = true}]"
MARGIN = 20  # of a segment: RECORDER_MARGIN, the change that begins it, and the last tick's three
SAME, DEPARTS, REFUSED = 0, 1, 2

# Of the recording, see firmware/record/recorder_dump.h.
LINE_WORDS = 13
ENTRY_WORDS = 4
COMPARE_B = 2   # word of an entry
COMPARE_B_BIT = 1 << 17


def words_of(text):
    lines = [base64.b64decode(line[1:]) for line in text.splitlines()]
    words = [word for line in lines for word in struct.unpack(f"<{LINE_WORDS + 2}I", line)[1:-1]]
    return words[:words[2]]


def crc(words):
    return zlib.crc32(struct.pack(f"<{len(words)}I", *words))


def text_of(words):
    padded = words + [0] * (-len(words) % LINE_WORDS)
    lines = [[k, *padded[k * LINE_WORDS:(k + 1) * LINE_WORDS]] for k in range(len(padded) // LINE_WORDS)]
    return "".join("~" + base64.b64encode(struct.pack(f"<{LINE_WORDS + 2}I", *line, crc(line))).decode()
                   + "\n" for line in lines)


def motorsim(*arguments):
    return subprocess.run([MOTORSIM, *map(str, arguments)], capture_output=True, text=True)


class Replay(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = Path(folder.name) / "run.log"
        self.trace = Path(folder.name) / "run.csv"

    def record(self, *arguments):
        run = motorsim("run", *arguments, "--record", self.file)
        self.assertTrue(self.file.is_file(), run.stderr)

    def assert_ends_at_the_speed_of_the_trace(self):
        """Of its last row: whole revolutions a minute, and the recording ends a tick later."""
        run = motorsim("replay", self.file)
        self.assertEqual(run.returncode, SAME, run.stdout + run.stderr)
        self.assertIn("are those recorded", run.stdout)
        with self.trace.open() as rows:
            last = list(csv.DictReader(rows))[-1]
        speed = float(re.search(r"ends in \w+, speed (-?\d+) rpm", run.stdout)[1])
        self.assertAlmostEqual(speed, float(last["speed_estimated_rpm"]), delta=1.0)

    def stepped(self, commands):
        script = self.file.with_name("script")
        script.write_text(commands)
        return motorsim("replay", self.file, "--debug", "--script", script)

    def test_a_whole_run_is_what_it_was(self):
        self.record("s1_robust", "--with", "all", "--set", "board.recorder_entries=65536")
        run = motorsim("replay", self.file)
        self.assertRegex(run.stdout, r"ticks 1 to ")
        self.assertEqual(run.returncode, SAME, run.stdout)
        self.assertIn("ends in RUN", run.stdout)
        self.assertIn("are those recorded", run.stdout)

    def test_every_shipped_motor_replays_at_the_speed_that_it_ran_at(self):
        for scenario in ("s1", "s1_motor_b", "s1_odrive_d5065", "s1_teknic_m2310p"):
            with self.subTest(scenario):
                self.record(scenario, "--set", "scenario.duration_s=0.2",
                            "--set", "scenario.evaluate_from_s=0", "--trace", self.trace)
                self.assert_ends_at_the_speed_of_the_trace()

    def test_many_pole_pairs_at_a_low_pwm_frequency_replay_at_the_speed_that_they_ran_at(self):
        for pole_pairs in (15, 16, 24):
            with self.subTest(pole_pairs):
                self.record("s1_robust", "--set", f"motor.pole_pairs={pole_pairs}",
                            "--set", "motor.flux_linkage_wb=0.18",
                            "--set", "motor.inertia_kg_m2=0.02",
                            "--set", "motor.max_speed_rpm=300", "--set", "motor.rated_speed_rpm=250",
                            "--set", "position_loop.speed_rpm=250",
                            "--set", "scenario.command=[{time_s = 0.0, speed_rpm = 250.0}]",
                            "--set", "scenario.duration_s=0.2",
                            "--set", "scenario.evaluate_from_s=0", "--trace", self.trace)
                self.assert_ends_at_the_speed_of_the_trace()

    def test_the_ring_is_that_of_the_board(self):
        for entries in (256, 512, 1408):
            with self.subTest(entries):
                self.record("s1", "--set", f"board.recorder_entries={entries}")
                ticks = int(re.search(r": (\d+) of", motorsim("replay", self.file).stdout)[1])
                self.assertGreaterEqual(ticks, 3 * (entries // 4 - MARGIN))
                self.assertLess(ticks, entries)

    def test_the_first_fault_is_the_one_that_is_kept(self):
        self.record("s1", "--set", FAULT, "--set", CLEAR)
        run = motorsim("replay", self.file)
        self.assertEqual(run.returncode, SAME, run.stdout)
        self.assertIn("BREAK", run.stdout)

    def test_stepping_begins_at_the_fault(self):
        self.record("s1", "--set", FAULT)
        run = self.stepped("back 1\nprint state\nstep 1\nprint state drive.fault.id\n")
        self.assertEqual(run.returncode, SAME, run.stdout + run.stderr)
        before, _, after = run.stdout.partition("step 1")
        self.assertRegex(before, r"\nstate +RUN ")
        self.assertRegex(after, r"\nstate +FAULT ")
        self.assertRegex(after, r"drive\.fault\.id +BREAK ")

    def test_ticks_are_those_of_the_drive_everywhere(self):
        self.record("s1", "--set", FAULT)
        run = self.stepped("print drive.fault.tick\nback 100000\ngoto 0\nrun until state == FAULT\n"
                           "goto 100000\nrun\n")
        first, last, fault = map(int, re.search(
            r"ticks (\d+) to (\d+): .*\n +fault at tick (\d+),", run.stdout).groups())
        self.assertGreater(first, 0)
        self.assertIn(f": ticks {first} to {last} of", run.stdout)
        self.assertIn(f"\ntick {fault} ", run.stdout)
        self.assertRegex(run.stdout, rf"\ndrive\.fault\.tick +{fault} ")
        self.assertIn(f"beginning of the run\ntick {first} ", run.stdout)
        self.assertIn(f"a tick is a whole number from {first} to {last}, found '0'", run.stdout)
        self.assertIn(f"stopped: state == FAULT\ntick {fault} ", run.stdout)
        self.assertIn(f"stopped: end of the scenario\ntick {last} ", run.stdout)

    def alter_an_output(self, entries_before_the_end):
        words = words_of(self.file.read_text())
        self.assertEqual(words[-1], crc(words[:-1]))
        words[-1 - ENTRY_WORDS * entries_before_the_end + COMPARE_B] ^= COMPARE_B_BIT
        words[-1] = crc(words[:-1])
        self.file.write_text(text_of(words))

    def test_stepping_begins_where_it_departs_beside_what_was_recorded(self):
        self.record("s1", "--set", FAULT)
        self.alter_an_output(250)
        run = self.stepped("stages\nback\nprint out.compare.phase[1]\n")
        self.assertEqual(run.returncode, DEPARTS, run.stdout + run.stderr)
        tick, recorded, computed = re.search(
            r"departs at tick (\d+): out\.compare\.phase\[1\], recorded (\d+), computed (\d+)\n",
            run.stdout).groups()
        fault = re.search(r"fault at tick (\d+)", run.stdout)[1]
        self.assertLess(int(tick), int(fault))
        there, before = re.split(r"\(run\.log \d+\) back\n", run.stdout)
        self.assertIn(f"(run.log {tick}) stages\n", there)
        self.assertRegex(there, r"phase\[0\] +\S+ +raw (\d+) .*  recorded \1\n")
        self.assertRegex(there, rf"phase\[1\] +\S+ +raw {computed} .*  recorded {recorded} \*\n")
        self.assertRegex(before, r"phase\[1\] +\S+ +raw (\d+) .*  recorded \1\n")

    def test_a_bad_command_counts_more_than_a_departure(self):
        self.record("s1", "--set", FAULT)
        self.alter_an_output(300)
        run = self.stepped("nonsense\n")
        self.assertEqual(run.returncode, REFUSED, run.stdout + run.stderr)

    def test_a_configuration_that_changed_under_way_departs_or_is_refused(self):
        self.record("s1", "--set",
                    'scenario.fault=[{time_s = 0.3, what = "config_corrupt", value = 40}]')
        run = motorsim("replay", self.file)
        self.assertEqual(run.returncode, REFUSED, run.stdout)
        self.assertIn("configuration was damaged", run.stderr)

    def test_bad_input_is_refused_in_one_line(self):
        foreign = self.file.with_name("foreign")
        foreign.write_bytes(bytes(range(256)))
        for arguments, text in (((self.file,), "cannot read"),
                                ((self.file.parent,), "cannot read"),
                                ((foreign,), "there is no recording in it"),
                                ((foreign, "--script", "x"), "--script needs --debug"),
                                ((), "file is required")):
            with self.subTest(arguments):
                run = motorsim("replay", *arguments)
                self.assertEqual(run.returncode, REFUSED)
                self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
                self.assertIn(text, run.stderr)

    def test_what_never_ends_is_refused_in_one_line(self):
        for endless in ("cat /dev/zero", "yes '12:00:00 READY, at ~0 rpm'"):
            with self.subTest(endless):
                run = subprocess.run(["sh", "-c", f'{endless} | "$0" replay /dev/stdin', MOTORSIM],
                                     capture_output=True, text=True, timeout=60)
                self.assertEqual(run.returncode, REFUSED)
                self.assertRegex(run.stderr, r"\Amotorsim: /dev/stdin: it is longer than 64 MiB; [^\n]+\n\Z")

    def test_a_long_log_and_a_pipe_are_read(self):
        self.record("s1", "--set", FAULT)
        self.file.write_text("READY, at 0 rpm\n" * 1000000 + self.file.read_text())
        run = subprocess.run(["sh", "-c", 'cat "$1" | "$0" replay /dev/stdin', MOTORSIM, self.file],
                             capture_output=True, text=True)
        self.assertEqual(run.returncode, SAME, run.stderr)

    def test_a_recording_is_not_written_over_another_output(self):
        run = motorsim("run", "s1", "--record", self.file, "--trace", self.file)
        self.assertEqual(run.returncode, REFUSED)
        self.assertIn("cannot go to the same file", run.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
