# SPDX-License-Identifier: MIT
"""The tests that ctest runs: each one's command, folder and surroundings."""

import json
import re
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path


OBJECT_OF = re.compile(r"CMakeFiles/([^/]+)\.dir/")


def matches(expression, output):
    """As ctest searches: a point stands for the end of a line too."""
    return re.search(expression, output, re.DOTALL)


@dataclass(frozen=True)
class Test:
    """`title`: its name, with the arguments that were added."""

    title: str
    command: tuple
    folder: Path
    environment: dict
    pass_expressions: tuple
    fail_expressions: tuple = ()
    labels: frozenset = frozenset()
    sets_up: frozenset = frozenset()  # fixtures

    def with_arguments(self, title, arguments):
        return replace(self, title=title, command=(*self.command, *arguments))

    def passes(self, status, output):
        if status < 0 or any(matches(expression, output) for expression in self.fail_expressions):
            return False
        if self.pass_expressions:
            return any(matches(expression, output) for expression in self.pass_expressions)
        return status == 0


def compiled(build):
    """(source, target) of each object of a build. The output comes last: a precompiled header of another target may be before."""
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        for target in OBJECT_OF.findall(entry["command"])[-1:]:
            yield Path(entry["file"]), target


def listed(build, folder="", whole=True):
    """The tests of a build, or of one folder of it, that are not disabled, by name. `whole`: all have to be built."""
    if not (build / "compile_commands.json").is_file():
        sys.exit(f"{build}: no build; expected one of the preset host, with all tests")
    shown = subprocess.run(["ctest", "--test-dir", build / folder, "--show-only=json-v1"], capture_output=True,
                           text=True, check=True)
    found = {}
    for test in json.loads(shown.stdout[shown.stdout.index("{"):])["tests"]:
        properties = {entry["name"]: entry["value"] for entry in test.get("properties", [])}
        if "command" not in test and whole:
            sys.exit(f"{build}: {test['name']} is not built; `cmake --build --preset host` builds all tests")
        if "command" in test and not properties.get("DISABLED"):
            environment = dict(pair.split("=", 1) for pair in properties.get("ENVIRONMENT", []))
            found[test["name"]] = Test(test["name"], tuple(test["command"]), Path(properties.get("WORKING_DIRECTORY", build)),
                                       environment, tuple(properties.get("PASS_REGULAR_EXPRESSION", [])),
                                       tuple(properties.get("FAIL_REGULAR_EXPRESSION", [])),
                                       frozenset(properties.get("LABELS", [])),
                                       frozenset(properties.get("FIXTURES_SETUP", [])))
    return found
