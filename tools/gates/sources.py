# SPDX-License-Identifier: MIT
"""What the gates share: which files are ours, and how to read C without its comments."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# A comment, a string or a character, whichever starts first.
_NOT_CODE = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)


def files(root, *patterns):
    """The files that git tracks or would track, as paths relative to root."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *patterns],
        cwd=root, check=True, capture_output=True, text=True).stdout
    return sorted({Path(name) for name in listed.split("\0") if name and (root / name).is_file()})


def strip(text):
    """The text with comments, strings and characters blanked; line numbers stay."""
    return _NOT_CODE.sub(lambda match: " " + "\n" * match.group().count("\n"), text)


def finish(gate, findings, advice):
    """Prints the findings and ends the program: 0 without any, else 1 with what to do."""
    for finding in findings:
        print(finding)
    if findings:
        print(f"gate.{gate}: {len(findings)} finding(s). {advice}")
    else:
        print(f"gate.{gate}: clean")
    sys.exit(1 if findings else 0)
