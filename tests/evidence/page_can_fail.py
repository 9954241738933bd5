# SPDX-License-Identifier: MIT
"""evidence.page_can_fail: the page is refused when a part is missing or keeps no threshold, and shows which."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import part

PAGE = part.ROOT / "tools" / "evidence" / "page.py"


class PageCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, ok=True, rows=2):
        part.end(self.folder / f"{name}.json", name, name.capitalize(), "What <is> shown.",
                 [part.figure("share", "98 %", "≥ 95 %", ok)],
                 [part.table("Rows", ("Name", "Value"), [(f"row {k}", "a < b") for k in range(rows)],
                             "A <note>.")])

    def page(self, *parts):
        """Exit status, page and what is printed."""
        out = self.folder / "page.html"
        run = subprocess.run([sys.executable, "-B", PAGE, self.folder, out, *parts], capture_output=True, text=True,
                             check=False)
        return run.returncode, out.read_text(encoding="utf-8"), run.stdout

    def test_all_parts_are_there_and_kept(self):
        self.write("one")
        self.write("two")
        status, page, _ = self.page("one", "two")
        self.assertEqual((status, page.count("not kept")), (0, 0))
        self.assertLess(page.index('id="one"'), page.index('id="two"'))

    def test_a_missing_part_is_named(self):
        self.write("one")
        status, page, printed = self.page("one", "two")
        self.assertEqual(status, 1)
        self.assertIn("not kept: two", printed)
        self.assertIn("This part was not made.", page)

    def test_a_threshold_that_is_not_kept_is_named(self):
        self.write("one", ok=False)
        status, page, printed = self.page("one")
        self.assertEqual(status, 1)
        self.assertIn("not kept: one", printed)
        self.assertIn('<span class="verdict bad">not kept</span>', page)

    def test_a_finding_beside_figures_that_are_kept_is_named(self):
        part.end(self.folder / "one.json", "one", "One", "Shown.", [part.figure("share", 1, 1, True)], [], ["a:1: bad"])
        status, _, printed = self.page("one")
        self.assertEqual(status, 1)
        self.assertIn("not kept: one", printed)

    def test_a_part_without_figures_shows_nothing(self):
        part.end(self.folder / "one.json", "one", "One", "Nothing.", [], [])
        self.assertEqual(self.page("one")[0], 1)

    def test_texts_are_escaped_and_long_tables_are_closed(self):
        self.write("one", rows=40)
        _, page, _ = self.page("one")
        self.assertIn("What &lt;is&gt; shown.", page)
        self.assertIn("A &lt;note&gt;.", page)
        self.assertIn("<details>", page)
        self.assertNotIn("a < b", page)

    def test_the_same_parts_give_the_same_page(self):
        self.write("one")
        self.assertEqual(self.page("one")[1], self.page("one")[1])

    def test_an_earlier_part_does_not_stand_for_a_run_that_ended(self):
        self.write("one")
        out = self.folder / "one.json"
        code = "import argparse, part; part.arguments(argparse.ArgumentParser()); raise SystemExit(1)"
        subprocess.run([sys.executable, "-B", "-c", code, "--out", out], cwd=PAGE.parent, check=False)
        self.assertFalse(out.exists())


if __name__ == "__main__":
    unittest.main()
