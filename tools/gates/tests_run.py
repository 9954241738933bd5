# SPDX-License-Identifier: MIT
"""gate.tests_run: each file of tests is run by ctest.

A file that no CMakeLists.txt names passes unseen. Looked at are all that is called test_*, reference_*, fuzz_* or *_can_fail:
a Python file has to be in the command of a test, what of a C or C++ file is compiled in the program of one.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import sources

sys.path.insert(0, str(sources.ROOT / "tools/evidence"))
import ctested  # noqa: E402

NAMES = ("test_*", "reference_*", "fuzz_*", "*_can_fail")
PATTERNS = [f"tests/**/{name}.{kind}" for name in NAMES for kind in ("c", "cpp", "py")]

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("build", type=Path, help="the build folder whose tests are meant")
args = parser.parse_args()


def commands(build):
    """The words of each test's command, and the folder in which it runs. ctest tells no command whose program is not built
    yet; its test is called as the program."""
    listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, check=True, capture_output=True, text=True)
    for test in json.loads(listed.stdout)["tests"]:
        properties = {p["name"]: p["value"] for p in test.get("properties", [])}
        yield test.get("command", [test["name"]]), Path(properties.get("WORKING_DIRECTORY", build))


def run_by_python(words, folder):
    """The Python files of a command: given as files, or as modules of its folder."""
    modules = [folder / f"{word}.py" for word in words] if "unittest" in words else []
    return {Path(word) for word in words if word.endswith(".py")} | set(modules)


def compiled_into(build):
    """Source -> the targets that it is compiled for."""
    found = {}
    for path, target in ctested.compiled(build):
        found.setdefault(path, set()).add(target)
    return found


def findings(root, build):
    every = list(commands(build))
    scripts = {path for words, folder in every for path in run_by_python(words, folder)}
    programs = {Path(word).name for words, _ in every for word in words}
    targets = compiled_into(build)
    for path in sources.files(root, *PATTERNS):
        whole = root / path
        runs = whole in scripts if path.suffix == ".py" else not programs.isdisjoint(targets.get(whole, ()))
        if not runs:
            yield f"{path}: no test of {build} runs it"


sources.finish("tests_run", list(findings(args.root.resolve(), args.build)),
               "Name it in the CMakeLists.txt of its folder.")
