# SPDX-License-Identifier: MIT
"""target.products: which functions of the compiler's library a tick can reach on a core without long products.

test_products.py FOLDER: of the builds for Cortex-M0+, whose images lie there.
"""

import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from bench import replay, stack  # noqa: E402
from bench.image import Image  # noqa: E402

IMAGES = sorted(Path(sys.argv[1]).glob("replay_*.elf"))
# Copies, and quotients of 32 bits and their remainders, with what a division by zero calls, which none is.
ALLOWED = {"memcpy", "memset", "__aeabi_idiv", "__aeabi_idivmod", "__divsi3", "__aeabi_uidiv", "__aeabi_ldiv0"}
DIVISION = "__aeabi_idiv"  # there has to be one: else the library would not be seen at all


class Products(unittest.TestCase):
    def test_a_tick_reaches_no_product_and_no_quotient_of_64_bits(self):
        self.assertGreater(len(IMAGES), 0)
        for path in IMAGES:
            with self.subTest(path.name):
                found = stack.of_library(Image(path), replay.ENTRY)
                self.assertIn(DIVISION, found)
                self.assertEqual(found - ALLOWED, set())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
