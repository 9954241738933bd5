# SPDX-License-Identifier: MIT
"""The launch files of IDEs: readable, relative, and of what is there. test_launch.py"""

import json
import re
import sys
import unittest
import xml.etree.ElementTree as xml

import support

ROOT = support.ROOT
VSCODE = [ROOT / ".vscode/launch.json", ROOT / ".vscode/tasks.json"]
CLION = sorted((ROOT / ".run").glob("*.run.xml"))


class LaunchFiles(unittest.TestCase):
    """Of VS Code and CLion."""

    def test_they_are_what_their_ide_reads(self):
        launch, tasks = (json.loads(path.read_text(encoding="utf-8")) for path in VSCODE)
        labels = {task["label"] for task in tasks["tasks"]}
        self.assertLessEqual({one["preLaunchTask"] for one in launch["configurations"]}, labels)
        self.assertLessEqual({task["dependsOn"] for task in tasks["tasks"] if "dependsOn" in task}, labels)
        names = [xml.parse(path).getroot().find("configuration").get("name") for path in CLION]
        of_both = {one["name"] for one in launch["configurations"] if one["type"] == "cppdbg"}
        self.assertLessEqual(of_both, set(names))

    def test_no_path_is_of_one_machine(self):
        for path in [*VSCODE, *CLION, ROOT / ".gdbinit"]:
            text = path.read_text(encoding="utf-8").replace("/usr/bin/env", "")
            self.assertNotRegex(text, r'[\s"=(]/\w|file:///|[A-Z]:\\', path)

    def test_what_they_name_of_the_tree_is_there(self):
        for path in [*VSCODE, *CLION, ROOT / ".gdbinit"]:
            for name in re.findall(r"\btools/[\w./-]+", path.read_text(encoding="utf-8")):
                self.assertTrue((ROOT / name).is_file(), f"{path}: {name}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
