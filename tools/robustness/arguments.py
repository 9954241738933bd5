# SPDX-License-Identifier: MIT
"""Types of command line arguments."""

import argparse


def whole(low):
    """A whole number from `low` on."""
    def parse(text):
        value = int(text) if text.isascii() and text.isdigit() else -1
        if value < low:
            raise argparse.ArgumentTypeError(f"{text}; allowed: a whole number, {low} or more")
        return value
    return parse
