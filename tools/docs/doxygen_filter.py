# SPDX-License-Identifier: MIT
"""Makes the comments of a header those that Doxygen reads: doxygen_filter.py FILE, the result on standard output.

The headers have plain comments: one above a declaration, one behind a field, one at the top of the file below the line
of the licence. That line is blanked. Nothing else is changed.
"""
import re
import sys
from pathlib import Path

LICENCE = re.compile(r"\A/\* SPDX-License-Identifier: .*")
BEFORE_CODE = re.compile(r"^(\s*)/\*(?![*<])", re.MULTILINE)
BEHIND_CODE = re.compile(r"(?m)^(?!\s*/\*)(.*\S.*?)/\*(?![*<])")


def with_doxygen_comments(text):
    text = LICENCE.sub("", text)
    top, _, rest = text.partition("*/")
    top = top.replace("/*", "/** @file\n *", 1)
    rest = BEHIND_CODE.sub(r"\1/**<", BEFORE_CODE.sub(r"\1/**", rest))
    return f"{top}*/{rest}"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8")
    print(with_doxygen_comments(Path(sys.argv[1]).read_text(encoding="utf-8")), end="")
