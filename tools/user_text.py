# SPDX-License-Identifier: MIT
"""What a user gave: as a message repeats it, and as the argument of a program."""

import argparse
import sys

WORD, LINE = 60, 4000  # characters; a line is far longer than any message of ours
CONTROLS = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}


def is_no_utf8(character):
    """Python keeps a byte that is not UTF-8 as half of a pair."""
    return "\udc80" <= character <= "\udcff"


def shown(character):
    if is_no_utf8(character):
        return f"\\x{ord(character) - 0xDC00:02x}"
    if ord(character) < 0x20 or 0x7F <= ord(character) < 0xA0:
        return CONTROLS.get(character, f"\\x{ord(character):02x}")
    return character


def readable(text, most=WORD):
    """At most so many characters, and then "…"; control characters are shown as \\n or \\x1b."""
    return "".join(map(shown, text[:most])) + ("…" if len(text) > most else "")


def in_short(message, words):
    """A message, in which words of the command line, or their part behind a '=', are readable."""
    for word in words:
        for part in (word, word.partition("=")[2]):
            if part and readable(part) != part:
                message = message.replace(part, readable(part))
    return readable(message, LINE)


def tell(program, problem):
    """One line on standard error."""
    print(f"{program}: {in_short(str(problem), sys.argv[1:])}", file=sys.stderr)


class Parser(argparse.ArgumentParser):
    """Takes UTF-8 alone, and repeats what it refuses in short."""

    words = ()

    def parse_args(self, args=None, namespace=None):
        Parser.words = [str(word) for word in (sys.argv[1:] if args is None else args)]
        for number, word in enumerate(Parser.words, start=1):
            if any(map(is_no_utf8, word)):
                self.error(f"argument {number}: \"{readable(word)}\" is not UTF-8; allowed: UTF-8 text")
        return super().parse_args(Parser.words, namespace)

    def error(self, message):
        super().error(in_short(message, Parser.words))
