# SPDX-License-Identifier: MIT
"""What the console says, line by line."""

import re

STATE = re.compile(r"([A-Z_]+), speed (?:unknown, asked -?\d+|-?\d+ of -?\d+) rpm, phases (?:-?\d+\.\d{3} ){3}A,"
                   r" bus \d+\.\d{3} V, -?\d+ C, late \d+, load \d+ %(?:, by \w+)?")


def lines(said):
    """All of them; of one that shows a state without a fault, whole and nothing else, only the state's name."""
    return [match[1] if (match := STATE.fullmatch(line)) else line for line in said.splitlines()]
