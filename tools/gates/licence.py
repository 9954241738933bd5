# SPDX-License-Identifier: MIT
"""gate.licence: every source file says its licence, in its first line or in the one after `#!`. --fix writes it there.

A file that leaves the project, alone or in an archive, still says on what terms it may be used. Data and prose carry no
such line; LICENSE covers them. A kind of file that is neither is a finding: nobody has said what it is.
"""

import argparse
from pathlib import Path

import sources

SAYS = "SPDX-License-Identifier: MIT"
OF_KIND = {kind: form for form, kinds in {
    f"/* {SAYS} */": (".c", ".h", ".S", ".ld", ".def", ".css"),
    f"// {SAYS}": (".cpp", ".hpp", ".mjs", ".rs", ".ts", ".tsx"),
    f"# {SAYS}": (".py", ".cmake"),
    f"{{# {SAYS} #}}": (".jinja",),
    f"<!-- {SAYS} -->": (".html",),
}.items() for kind in kinds}
OF_SCRIPT = f"# {SAYS}"
DATA = {".bin", ".json", ".lock", ".md", ".nfr", ".png", ".svg", ".toml", ".txt", ".xml", ".xz"}


def line_of(path, text):
    """The line that this file has to have, None if its kind has none."""
    is_script = path.name in ("CMakeLists.txt", "Containerfile") or text.startswith("#!")
    return OF_SCRIPT if is_script else OF_KIND.get(path.suffix)


def is_data(path):
    """Data, prose, and the settings of tools."""
    return path.suffix in DATA or path.name.startswith(".") or path.name == "LICENSE"


def place_of(lines):
    """How many lines stand before it: `#!` has to be the first of all."""
    return 1 if lines and lines[0].startswith("#!") else 0


def findings(root, fix):
    for path in sources.files(root, "*"):
        text = (root / path).read_text(encoding="utf-8", errors="replace")
        asked = line_of(path, text)
        if not asked and not is_data(path):
            yield f"{path}:1: nobody has said whether a '{path.suffix or path.name}' is a source file"
        lines = text.splitlines(keepends=True)
        at = place_of(lines)
        if asked and [line.rstrip("\n") for line in lines[at:at + 1]] != [asked]:
            if fix:
                (root / path).write_text("".join([*lines[:at], asked + "\n", *lines[at:]]), encoding="utf-8")
            else:
                yield f"{path}:{at + 1}: the line is not '{asked}'"


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("--fix", action="store_true", help="write the line where it is missing")
args = parser.parse_args()
sources.finish("licence", list(findings(args.root, args.fix)),
               "Run `tools/gates/licence.py --fix`.")
