# SPDX-License-Identifier: MIT
"""config.refused: what the programs refuse, each row of refused.toml: exit status 2, nothing on stdout, one line on stderr.

test_refused.py PROGRAM...: the programs, by their paths.
"""

import os
import shlex
import subprocess
import sys
import tomllib
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROWS = {(program, name): row for program, rows in tomllib.loads((HERE / "refused.toml").read_text(encoding="utf-8")).items()
        for name, row in rows.items()}
PROGRAMS = {Path(path).name: str(Path(path).resolve()) for path in sys.argv[1:]}


def run(program, row):
    data = {"NEUROFOC_DATA": row["data"]} if "data" in row else {}
    return subprocess.run([PROGRAMS[program], *shlex.split(row["run"])], cwd=HERE, env={**os.environ, **data},
                          capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)


def wrong(program, row, ended):
    """What is not as it has to be, each in a line."""
    if (ended.returncode, ended.stdout) != (2, ""):
        yield f"exit status {ended.returncode}, expected 2; stdout: {ended.stdout!r}"
    if not ended.stderr.startswith(f"{program}: ") or ended.stderr.find("\n") != len(ended.stderr) - 1:
        yield f"stderr is not one line of {program}"
    yield from (f"does not say: {words}" for words in row["says"] if words not in ended.stderr)


class Refused(unittest.TestCase):
    def test_each_row_is_refused_with_place_key_value_and_range(self):
        with ThreadPoolExecutor(max_workers=2) as pool:
            ends = pool.map(lambda named: run(named[0][0], named[1]), ROWS.items())
            for ((program, name), row), ended in zip(ROWS.items(), ends):
                with self.subTest(f"{program}.{name}"):
                    self.assertEqual(list(wrong(program, row, ended)), [], ended.stderr)

    def test_what_is_not_so_is_wrong(self):
        row = {"says": ["key = 1", "0 to 2"]}
        for status, stdout, stderr, count in ((2, "", "x: key = 1: 0 to 2\n", 0), (0, "", "x: key = 1: 0 to 2\n", 1),
                                              (2, "z", "x: key = 1: 0 to 2\n", 1), (2, "", "x: key = 1: 0 to 2\nmore\n", 1),
                                              (2, "", "x: key = 1\n", 1), (-6, "", "", 4)):
            with self.subTest(stderr):
                self.assertEqual(len(list(wrong("x", row, subprocess.CompletedProcess([], status, stdout, stderr)))), count)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
