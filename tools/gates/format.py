# SPDX-License-Identifier: MIT
"""gate.format: every C and C++ file has the project's format. --fix brings it there."""

import argparse
import re
import subprocess
from pathlib import Path

import sources

PLACE = re.compile(r"[^\s:]+:\d+:\d+: ")

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("--fix", action="store_true")
args = parser.parse_args()

paths = sources.files(args.root, "*.c", "*.h", "*.cpp", "*.hpp")
mode = ["-i"] if args.fix else ["--dry-run", "-Werror"]
run = subprocess.run(["clang-format-19", *mode, *map(str, paths)], cwd=args.root, capture_output=True, text=True)
first = {}
for line in run.stderr.splitlines():
    if PLACE.match(line):
        first.setdefault(line.split(":")[0], line)
bad = list(first.values())
if run.returncode and not bad:
    bad = [run.stderr.strip() or f"clang-format ended with {run.returncode}"]
sources.finish("format", bad, "Run `tools/dev format`; each line shows a file's first place.")
