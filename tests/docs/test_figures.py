# SPDX-License-Identifier: MIT
"""docs.figures: `tools/dev figures` knows every generated table, finds what is stale and writes that alone."""
import sys
import tempfile
import unittest
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/docs"))
import figures  # noqa: E402
import generated  # noqa: E402
from figures import FIGURES, ROOT, Figure  # noqa: E402

PAGE = "before\n<!-- one -->\n| a | 1.00 |\n| b | 2.00 |\n<!-- end -->\nbetween\n<!-- other -->\nas it was\n<!-- end -->\n"


def called(*words):
    """Exit status and output of the command, without a build."""
    out = StringIO()
    with redirect_stdout(out), redirect_stderr(out), mock.patch.object(figures, "build", return_value=0):
        try:
            return figures.main(words), out.getvalue()
        except SystemExit as exit_:
            return exit_.code, out.getvalue()


class TheList(unittest.TestCase):
    def test_each_page_with_a_generated_table_is_in_it(self):
        named = " ".join(figure.where for figure in FIGURES)
        for page in sorted((ROOT / "docs").rglob("*.md")):
            name = page.relative_to(ROOT).as_posix()
            self.assertTrue(name in named or not generated.tables(name), name)

    def test_each_script_that_it_calls_is_there(self):
        for figure in FIGURES:
            for write in (False, True):
                scripts = [word for word in figure.command(write) if word.startswith("tools/")]
                for path in scripts:
                    self.assertTrue((ROOT / path).is_file(), path)
                self.assertTrue(scripts, figure.name)


class Calls(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(mock.patch.object(figures, "FIGURES", (
            self.figure("good"), self.figure("stale"), self.figure("part", of="good"), self.figure("slow", dear=True))))
        for name in ("good", "part", "slow"):
            (self.folder / name).touch()

    def figure(self, name, **options):
        """It holds as long as there is a file of its name."""
        path = self.folder / name
        return Figure(name, "docs/x.md", 1, ("sh", "-c", f"[ -e {path} ] || {{ echo not as made; echo more; exit 1; }}"),
                      ("touch", str(path), str(self.folder / "written")), **options)

    def test_what_is_stale_is_said_in_one_line_with_how_to_renew_it(self):
        status, said = called()
        self.assertEqual(status, 1)
        self.assertIn("\nstale: stale: not as made\n", said)
        self.assertRegex(said, "1 of 3 stale: stale; to renew: tools/dev figures --write stale\n$")
        self.assertFalse((self.folder / "written").exists())

    def test_only_what_is_stale_is_written(self):
        status, said = called("--write")
        self.assertEqual((status, said.count("written anew")), (0, 1))
        self.assertEqual(called()[0], 0)

    def test_a_dear_one_is_made_where_it_is_asked_for_and_what_a_figure_is_made_of_before_it(self):
        self.assertIn("good, docs", called("part")[1])
        self.assertNotIn("slow, docs", called()[1])
        for words, others in ((("--with", "slow"), True), (("slow",), False)):
            said = called(*words)[1]
            self.assertIn("slow, docs", said)
            self.assertEqual("stale, docs" in said, others)

    def test_another_name_is_refused(self):
        status, said = called("none")
        self.assertEqual(status, 2)
        self.assertIn("found 'none'; allowed: good, stale, part, slow", said)


class Tables(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(mock.patch.object(generated, "ROOT", folder))
        self.page = folder / "page.md"
        self.page.write_text(PAGE, encoding="utf-8")

    def finish(self, made, write):
        generated.finish("page.md", made, "the test", write)

    def test_the_first_row_that_differs_is_said_and_the_table_alone_is_written(self):
        made = {"one": "| a | 1.00 |\n| b | 3.00 |\n"}
        with self.assertRaisesRegex(SystemExit, r"page.md, one: shown: \| b \| 2.00 \|  now: \| b \| 3.00 \|"):
            self.finish(made, False)
        self.finish(made, True)
        self.assertEqual(self.page.read_text(encoding="utf-8"), PAGE.replace("2.00", "3.00"))
        self.finish(made, False)

    def test_a_table_that_the_page_does_not_have_is_refused(self):
        for write in (False, True):
            with self.assertRaisesRegex(SystemExit, "page.md has no table 'none'; it has one, other"):
                self.finish({"none": "| a |\n"}, write)

    def test_a_row_within_its_margin_stays_and_another_does_not(self):
        def kept(text, margin, rounded=0.0):
            return generated.kept("page.md", {"one": text}, margin, rounded)["one"]

        self.assertEqual(kept("| a | 1.10 |\n", 0.1), "| a | 1.00 |\n")
        self.assertEqual(kept("| a | 1.10 |\n", 0.0, 0.11), "| a | 1.00 |\n")
        for moved in ("| a | 1.10 |\n", "| c | 1.00 |\n", "| a | 1.00° |\n", "| a | 1.00, 1.00 |\n"):
            self.assertEqual(kept(moved, 0.05), moved)


if __name__ == "__main__":
    unittest.main()
