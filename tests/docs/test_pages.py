# SPDX-License-Identifier: MIT
"""docs.pages: what a reader of the guides counts on."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
ONE_PAGE = 140      # lines of the README
SENTENCE_MIN = 60   # characters: shorter lines, as of a command, may well stand twice


class Pages(unittest.TestCase):
    def test_the_readme_is_one_page(self):
        self.assertLessEqual(len(README.splitlines()), ONE_PAGE)

    def test_every_link_leads_to_a_file(self):
        for page in PAGES:
            for link in LINK.findall(page.read_text(encoding="utf-8")):
                with self.subTest(page=page.name, link=link):
                    self.assertTrue("://" in link or (page.parent / link).exists())

    def test_every_public_header_is_in_the_api(self):
        shown = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/api").glob("*.md"))
        for header in [*(ROOT / "firmware").glob("*/*.h"), ROOT / "hal/hal.h"]:
            self.assertIn(f"doxygenfile}} {header.name}\n", shown)

    def test_no_line_of_the_readme_stands_in_a_guide_again(self):
        guides = [page for page in (ROOT / "docs").glob("*.md") if page.name != "index.md"]
        said = {line for page in guides for line in page.read_text(encoding="utf-8").splitlines()}
        twice = [line for line in README.splitlines() if len(line) >= SENTENCE_MIN and line in said]
        self.assertEqual(twice, [])


if __name__ == "__main__":
    unittest.main()
