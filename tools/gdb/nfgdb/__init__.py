# SPDX-License-Identifier: MIT
"""Pretty-printers and commands of gdb for the firmware, on the PC and on targets."""
