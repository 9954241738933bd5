# SPDX-License-Identifier: MIT
"""gate.tidy: clang-tidy over firmware, hal, host_sim and tools, as the given build compiles them."""

import argparse
import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import sources

FOLDERS = {"firmware", "hal", "host_sim", "tools"}
TOOL = Path(sys.executable).with_name("clang-tidy")
# The analyzer goes path by path. In C++ these paths lead through the templates of the libraries, and sanitizers watch that code
# run. Of what the proof reads, all paths are proven free of what the analyzer looks for on some; unused values are found by
# cppcheck (gate.misra).
# C++ sources that are compiled together are included by a source that CMake makes.
WITHOUT_ANALYZER = "--checks=-clang-analyzer-*,-bugprone-suspicious-include"
# Of the libraries' templates only those that are used are parsed; the headers that gcc has precompiled are read as they are, and
# what only gcc is told is passed over.
USED_TEMPLATES = ("--extra-arg=-fdelayed-template-parsing", "--extra-arg=-Wno-ignored-gch",
                  "--extra-arg=-Wno-unused-command-line-argument")
PROOF = sources.ROOT / "tests/proof"
PROVEN = {(PROOF / name).resolve()
          for name in re.findall(r'#include "(\S+\.c)"', (PROOF / "firmware.h").read_text(encoding="utf-8"))}

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("build", type=Path, help="a build folder with compile_commands.json")
parser.add_argument("--beside", type=Path, help="another one; what it compiles as well is looked at there")
args = parser.parse_args()


def is_ours(path):
    return (path.match("Unity/unity_*_cxx.cxx")
            or path.is_relative_to(sources.ROOT) and path.relative_to(sources.ROOT).parts[0] in FOLDERS)


def options_of(path):
    if path.suffix in (".cpp", ".cxx"):
        return WITHOUT_ANALYZER, *USED_TEMPLATES
    return (WITHOUT_ANALYZER,) if path in PROVEN else ()


def tidy(path):
    run = subprocess.run([TOOL, "--quiet", "-p", str(args.build), *options_of(path), str(path)],
                         capture_output=True, text=True)
    return run.stdout if run.returncode == 0 else run.stdout + run.stderr, run.returncode


def compiled(build):
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    return {Path(c["file"]) for c in commands if is_ours(Path(c["file"]))}


paths = sorted(compiled(args.build) - (compiled(args.beside) if args.beside else set()))
with ThreadPoolExecutor(max_workers=2) as pool:
    results = list(pool.map(tidy, paths))
bad = [output.strip() for output, code in results if code]
sources.finish("tidy", bad, "Change the code; a check that is wrong for the project is "
               "switched off in .clang-tidy with its reason.")
