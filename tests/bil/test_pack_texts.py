# SPDX-License-Identifier: MIT
"""target.pack_texts: what the packed texts of an image stand for, and what stays as it is.

test_pack_texts.py IMAGE...: the images are the packed ones.
"""

import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "hal/stm32g4"))
import pack_texts

PIECES = pack_texts.read_pieces(ROOT / "firmware/app/text_pieces.def")
PACK = pack_texts.packer(PIECES)
SOURCES = [path for folder in ("app", "protect", "config", "drive") for path in sorted((ROOT / "firmware" / folder).glob("*.c"))]


def unpacked(text):
    """A second time, the other way round."""
    def piece(code):
        number = int(code[1], 8) - pack_texts.FIRST_CODE
        return PIECES[number] if number >= 0 else code[0]

    return re.sub(r"\\([0-7]{3})", piece, text)


class Texts(unittest.TestCase):
    def texts(self):
        for path in SOURCES:
            source = path.read_text(encoding="utf-8")
            for begin, end in pack_texts.texts_of(source):
                yield source[begin:end]

    def test_each_text_of_the_sources_comes_out_again(self):
        texts = list(self.texts())
        self.assertGreater(len(texts), 100)
        for text in texts:
            self.assertEqual(unpacked(PACK(text)), text)
        self.assertLess(sum(map(len, map(unpacked, texts))), sum(map(len, texts)) + 1)

    def test_escapes_stay(self):
        piece = next(piece for piece in PIECES if piece.startswith("n"))
        self.assertEqual(PACK("\\" + piece)[:2], "\\n")
        self.assertEqual(PACK("\\r\\n"), "\\r\\n")

    def test_what_is_no_text_stays(self):
        long = PIECES[0] * 8
        for source in (f'asm("{long}");', f'__attribute__((section("{long}"))) int a;', f'_Static_assert(1, "{long}");',
                       f'# 1 "{long}"\n', 'f("' + PIECES[0] + '");', "f('\"'); /* none */",
                       f'.name = "neurofoc: {long}"'):
            self.assertEqual(pack_texts.packed(source, PACK), source)
        self.assertNotIn(long, pack_texts.packed(f'asm("x" : "y" (b)); f("{long}");', PACK))

    def test_the_images_have_packed_texts(self):
        for image in sys.argv[1:]:
            found = subprocess.run(["strings", "-n", "16", image], capture_output=True, text=True, check=True).stdout
            self.assertNotIn("short circuit or noise: check cable", found)
            self.assertNotIn("keeps the recording of a fault", found)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
