# SPDX-License-Identifier: MIT
"""gate.build_types: the C of firmware, plant and host binding compiles without a warning in each of CMake's build types.

The host is built in one of them; what a compiler finds out, and warns of, depends on how much it optimises. Each file is
compiled as the given build does it, with the build type's options in place of that one's.
"""

import argparse
import json
import shlex
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import sources

FOLDERS = ("firmware", "hal/host", "host_sim/plant")
TYPES = {"Debug": ["-O0", "-g"], "Release": ["-O3", "-DNDEBUG"], "MinSizeRel": ["-Os", "-DNDEBUG"]}
REPLACED = ("-O", "-g", "-DNDEBUG")

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("build", type=Path, help="a build folder with compile_commands.json")
args = parser.parse_args()


def is_concerned(path):
    return path.suffix == ".c" and any(path.is_relative_to(args.root / folder) for folder in FOLDERS)


def command_of(entry, options):
    """The compiler's command line with other options, and without a launcher before it or an output."""
    words = shlex.split(entry["command"])
    kept = [word for word in words[:words.index("-o")] if not word.startswith(REPLACED)]
    return [*kept, *options, "-o", "/dev/null", "-c", entry["file"]]


def complaint(work):
    entry, build_type = work
    run = subprocess.run(command_of(entry, TYPES[build_type]), cwd=entry["directory"],
                         capture_output=True, text=True, check=False)
    return f"{build_type}: {run.stderr.strip()}" if run.returncode else ""


commands = json.loads((args.build / "compile_commands.json").read_text(encoding="utf-8"))
concerned = [entry for entry in commands if is_concerned(Path(entry["file"]))]
with ThreadPoolExecutor(max_workers=2) as pool:
    found = list(pool.map(complaint, [(entry, name) for entry in concerned for name in TYPES]))
missing = [] if concerned else [f"{args.build}: compiles nothing of {', '.join(FOLDERS)}"]
sources.finish("build_types", missing + [text for text in found if text],
               "To see it alone: cmake -B build/TYPE -G Ninja -DCMAKE_BUILD_TYPE=TYPE.")
