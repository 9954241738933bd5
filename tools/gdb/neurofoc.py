# SPDX-License-Identifier: MIT
"""Shows the firmware's numbers in gdb: `gdb -x tools/gdb/neurofoc.py ...`, or `source` it. docs/debugging.md."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from nfgdb import commands, printers  # noqa: E402: its folder is known from here on

printers.register()
commands.register()
