# SPDX-License-Identifier: MIT
"""Sessions of gdb in batch mode, and what motorsim says of the same tick."""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools/gdb/neurofoc.py"
TIMEOUT_S = 250
PROMPT = "here it goes on"
SESSION = """
for command in {start}:
    gdb.execute(command)
for command in {commands}:
    print("{prompt}")
    try:
        gdb.execute(command)
    except gdb.error as error:
        print(error)
print("{prompt}")
"""


class GdbTest(unittest.TestCase):
    """Set: GDB, what starts it with its program; MOTORSIM, CHOICE, a configuration for it."""

    GDB, MOTORSIM, CHOICE = (), "", ()

    def gdb(self, commands, start=()):
        """The answers, one text a command; an error is the answer of its command."""
        with tempfile.NamedTemporaryFile("w", suffix=".py", encoding="utf-8") as script:
            script.write(SESSION.format(prompt=PROMPT, start=list(start), commands=commands))
            script.flush()
            run = subprocess.run(
                [self.GDB[0], "-q", "-nx", "-batch", "-iex", "set pagination off", "-x", SCRIPT,
                 "-x", script.name, *self.GDB[1:]], stdin=subprocess.DEVNULL, cwd=ROOT, text=True,
                capture_output=True, check=False, timeout=TIMEOUT_S)
        answers = run.stdout.split(PROMPT + "\n")[1:-1]
        self.assertEqual(len(answers), len(commands), run.stdout + run.stderr)
        return answers

    def motorsim(self, commands):
        """The stepper's answers."""
        run = subprocess.run([self.MOTORSIM, "debug", *self.CHOICE], input="\n".join(commands) + "\n", text=True,
                             capture_output=True, check=True)
        return re.split(r"^\(\w+ \d+\) .*\n", run.stdout, flags=re.MULTILINE)[1:]

    def assert_same_stages(self, shown, tick):
        """gdb's stages of a tick are motorsim's, but for what no word of the firmware holds."""
        state = self.motorsim([f"goto {tick}", "stages"])[1].splitlines()
        lines = [line for line in state[1:] if not line.startswith("  ") or " raw " in line]
        expected = [line for line, following in zip(lines, [*lines[1:], ""])
                    if line.startswith("  ") or following.startswith("  ")]  # no title without a word
        self.assertGreater(len(expected), 40)
        self.assertRegex(state[0], rf"^tick {tick} ")
        self.assertEqual(shown.splitlines()[0].split()[:2], ["tick", str(tick)])
        self.assertIn(shown.splitlines()[0].split()[2], state[0])
        self.assertEqual(shown.splitlines()[1:], expected)

    def assert_shows(self, shown, name, tick):
        """A value of gdb is what motorsim prints of it: SI value, raw value and format."""
        line = self.motorsim([f"goto {tick}", f"print {name}"])[1]
        si, raw, form = re.search(r"^\S+ +(.+?) +raw (-?\d+) +(.+)$", line).groups()
        self.assertEqual(shown.split(" = ", 1)[1].strip(), f"{si} (raw {raw}, {form})")
