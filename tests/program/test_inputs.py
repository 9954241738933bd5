# SPDX-License-Identifier: MIT
"""programs.inputs: what cannot be read, or is no text, is one short line; what is given is not repeated in full.

test_inputs.py MOTORSIM NFCONFIG TOOLS
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

MOTORSIM, NFCONFIG, TOOLS = (Path(word) for word in sys.argv[1:])
BAD_INPUT = 2
PATIENCE_S = 60
LONG = "x" * 100_000
SHORT = "x" * 60 + "…"
NOT_UTF8 = b"a\xff"
LINE_MOST = 1000  # characters of any message: the lists of what is allowed are the longest part
PARTS = ("--motor", "motor_a", "--board", "bench_310v")
# A command for each kind of file that is read.
READERS = {
    "script": (MOTORSIM, "debug", "s1", "--script"),
    "recording": (MOTORSIM, "replay"),
    "records": (MOTORSIM, "identify", *PARTS, "--records"),
    "scenario": (MOTORSIM, "run"),
    "motor": (NFCONFIG, "show", "--board", "bench_310v", "--motor"),
    "board": (NFCONFIG, "show", "--motor", "motor_a", "--board"),
    "estimator": (MOTORSIM, "run", "s1", "--estimator"),
    "block": (NFCONFIG, "show"),
    "flash": (MOTORSIM, "live", "--simulate", "s1", "--flash"),
    "campaign": (sys.executable, TOOLS / "campaign", "run"),
    "trace": (sys.executable, TOOLS / "plot.py", "trace"),
}
# A command for each kind of text that is given.
TAKERS = (
    (MOTORSIM,), (MOTORSIM, "run"), (MOTORSIM, "run", "s1", "--set"), (MOTORSIM, "run", "s1", "--motor"),
    (MOTORSIM, "run", "s1", "--with"), (MOTORSIM, "run", "s1", "--json"), (MOTORSIM, "run", "s1", "--trace"),
    (MOTORSIM, "run", "s1", "--vcd", "v", "--vcd-from"), (MOTORSIM, "live"), (MOTORSIM, "live", "--simulate"),
    (MOTORSIM, "live", "--simulate", "s1", "--link"), (MOTORSIM, "certify"), (MOTORSIM, "motor", "--kv"),
    (NFCONFIG, "keys"), (NFCONFIG, "zoo", "--out", "o"), (NFCONFIG, "header", *PARTS, "--set"),
    (sys.executable, TOOLS / "campaign", "run", "robust", "--set"), (sys.executable, TOOLS / "campaign", "run", "robust", "--runs"),
    *READERS.values())


def run(*words, **options):
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, **options}
    return subprocess.run([word if isinstance(word, bytes) else str(word) for word in words], stderr=subprocess.PIPE,
                          timeout=PATIENCE_S, check=False, **options)


class Inputs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def refused(self, *words, most=LINE_MOST, **options):
        """The line that says why. A program that shows how it is used does so above it."""
        done = run(*words, cwd=self.folder, **options)
        text = done.stderr.decode()
        self.assertEqual(done.returncode, BAD_INPUT, text[:LINE_MOST])
        lines = text.splitlines()
        self.assertTrue(len(lines) == 1 or lines[0].startswith("usage: "), text[:LINE_MOST])
        self.assertLess(len(lines[-1]), most)
        self.assertNotRegex(text, "Traceback|terminate|exception")
        return lines[-1]

    def test_a_byte_that_is_not_utf_8_is_shown_in_every_argument(self):
        for taker in TAKERS:
            with self.subTest(taker):
                self.assertRegex(self.refused(*taker, NOT_UTF8), r'argument \d+: "a\\xff" is not UTF-8.*; allowed: UTF-8')

    def test_what_is_long_is_repeated_in_short(self):
        for taker in TAKERS:
            with self.subTest(taker):
                self.assertNotIn("x" * 300, self.refused(*taker, LONG))
        self.assertIn(f"--set: {SHORT} = 1: unknown key", self.refused(MOTORSIM, "run", "s1", "--set", f"{LONG}=1"))
        self.assertIn(f'motor.name = "{SHORT}": has 100000', self.refused(MOTORSIM, "run", "s1", "--set", f"motor.name={LONG}"))

    def test_a_control_character_is_shown(self):
        self.assertIn('"a\\x1b[31m\\n"', self.refused(MOTORSIM, "run", "a\x1b[31m\n"))

    def test_a_folder_is_no_file(self):
        (self.folder / "folder.toml").mkdir()
        for kind, reader in READERS.items():
            with self.subTest(kind):
                self.assertRegex(self.refused(*reader, "./folder.toml"), r"folder\.toml: .*([Dd]irectory|regular file)")
        folder = os.open(self.folder, os.O_RDONLY)
        self.addCleanup(os.close, folder)
        self.assertIn("standard input: cannot read: Is a directory", self.refused(MOTORSIM, "debug", "s1", "--script", "-", stdin=folder))

    def test_a_device_without_an_end_is_no_file(self):
        for device in ("zero", "urandom"):
            (self.folder / f"{device}.toml").symlink_to(f"/dev/{device}")
            for kind, reader in READERS.items():
                with self.subTest((device, kind)):
                    self.assertIn(f"{device}.toml: ", self.refused(*reader, f"./{device}.toml"))

    def test_a_key_of_a_file_is_repeated_in_short(self):
        for text in (f"{LONG} = 1", f"[{LONG}]", f"[motor]\n{LONG} = 1", f"{LONG} = 1\n{LONG} = 2", f'[motor]\nname = "{LONG}"'):
            (self.folder / "m.toml").write_text(text + "\n")
            self.assertIn("m.toml:", self.refused(*READERS["motor"], "./m.toml", most=2 * LINE_MOST))

    def test_a_line_of_a_script_that_is_no_text_or_too_long_is_refused(self):
        script = self.folder / "script"
        script.write_bytes(b"step 1\nprint " + NOT_UTF8 + b"\nprint " + LONG[:50_000].encode() + b"\nbreak on " + b"(" * 50_000)
        done = run(MOTORSIM, "debug", "s1", "--script", script, stdout=subprocess.PIPE)
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn(b'"print a\\xff" is not UTF-8', done.stdout)
        self.assertNotIn(b"x" * 1000, done.stdout)
        script.write_text("x" * (2 << 20))
        self.assertIn("script: line 1 is too long for a command; allowed: at most 1048576 bytes",
                      self.refused(MOTORSIM, "debug", "s1", "--script", script))

    def test_a_pipe_is_read_line_by_line(self):
        with subprocess.Popen([MOTORSIM, "debug", "s1", "--script", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True) as started:
            for tick in (1, 2):
                started.stdin.write("step 1\n")
                started.stdin.flush()
                while not re.match(rf"tick {tick} ", line := started.stdout.readline()):
                    self.assertTrue(line)
            started.stdin.close()
            self.assertEqual(started.wait(PATIENCE_S), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
