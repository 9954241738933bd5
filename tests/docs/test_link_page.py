# SPDX-License-Identifier: MIT
"""docs.link: the page of the link says what link_messages.h says, and its frames are frames.

COBS and CRC are done here once more, by other means than the firmware's.
"""
import re
import unittest
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/link.md").read_text(encoding="utf-8")
HEADER = (ROOT / "firmware/app/link_messages.h").read_text(encoding="utf-8")
FRAME = re.compile(r"^(00(?: [0-9a-f]{2})+ 00) +([0-9a-f ]+)$", re.MULTILINE)
ROW = re.compile(r"^\| (0x[0-9A-F]{2}|\d+) \| `([A-Z]+)` \|", re.MULTILINE)
ENUMERATOR = re.compile(r"^    LINK_([A-Z]+)(?:\s*=\s*(0x[0-9A-F]+|\d+))?", re.MULTILINE)


def frame(message):
    """A message on the line."""
    whole = message + zlib.crc32(message).to_bytes(4, "little")
    parts = whole.split(b"\0")
    return b"\0" + b"".join(bytes([len(part) + 1]) + part for part in parts) + b"\0"


def types():
    """The messages of the header, by their numbers."""
    found, number = {}, 0
    for name, given in ENUMERATOR.findall(HEADER):
        number = int(given, 0) if given else number + 1
        found[name] = number
    return found


class LinkPage(unittest.TestCase):
    def test_each_frame_of_the_page_is_the_frame_of_its_message(self):
        shown = FRAME.findall(PAGE)
        self.assertGreaterEqual(len(shown), 5)
        for line, message in shown:
            self.assertEqual(bytes.fromhex(line), frame(bytes.fromhex(message)), message)

    def test_the_page_names_each_message_with_its_number_and_no_other(self):
        named = {name: int(number, 0) for number, name in ROW.findall(PAGE)}
        self.assertEqual(named, {name: number for name, number in types().items() if name != "REFUSED"})
        self.assertIn(f"type 0x{types()['REFUSED']:X}", PAGE)


if __name__ == "__main__":
    unittest.main()
