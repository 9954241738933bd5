# SPDX-License-Identifier: MIT
"""gate.format: every C and C++ file has the project's format. --fix brings it there."""

import argparse
import subprocess
from pathlib import Path

import sources

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("--fix", action="store_true")
args = parser.parse_args()

paths = sources.files(args.root, "*.c", "*.h", "*.cpp", "*.hpp")
mode = ["-i"] if args.fix else ["--dry-run", "-Werror"]
bad = []
for path in paths:
    run = subprocess.run(["clang-format-19", *mode, str(path)], cwd=args.root,
                         capture_output=True, text=True)
    if run.returncode:
        first = run.stderr.splitlines()[0] if run.stderr else "clang-format failed"
        bad.append(first)
sources.finish("format", bad, "Run `tools/dev format`; each line shows a file's first place.")
