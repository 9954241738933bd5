# SPDX-License-Identifier: MIT
"""The command line: what it writes, what it says, how it exits."""

import subprocess
import sys
import unittest

from support import TOOLS, FolderTest, captured
import plot
from report.panels import CATALOGUE

PNG_START = b"\x89PNG\r\n"


class Commands(FolderTest):
    def refused(self, *arguments, says):
        status, out, err = captured(plot.main, *arguments)
        self.assertEqual((status, out), (2, ""))
        self.assertRegex(err, says)
        self.assertEqual(err.count("\n"), 1, err)

    def test_trace_beside_the_file(self):
        path = self.run_files("s1")
        status, out, err = captured(plot.main, "trace", path)
        self.assertEqual((status, err), (0, ""))
        self.assertEqual(out.strip(), str(path.with_suffix(".png")))
        self.assertTrue(path.with_suffix(".png").read_bytes().startswith(PNG_START))

    def test_every_panel_can_be_chosen(self):
        path = self.run_files("s3")
        picture = self.folder / "all.png"
        status, _, err = captured(plot.main, "trace", path, "--panels", ",".join(CATALOGUE), "--out", picture,
                                "--from", "-0.02", "--to", "0.5", "--title", "all")
        self.assertEqual((status, err), (0, ""))
        self.assertTrue(picture.is_file())

    def test_a_zoom_alone(self):
        path = self.run_files("s2")
        self.assertEqual(captured(plot.main, "trace", path, "--panels", "angle-zoom")[0], 0)

    def test_report(self):
        self.run_files("s1")
        status, out, err = captured(plot.main, "report", "--runs", self.folder, "--out", self.folder / "r")
        self.assertEqual((status, err), (0, ""))
        self.assertEqual(out.strip(), str(self.folder / "r" / "index.html"))
        self.assertTrue((self.folder / "r" / "index.html").is_file())

    def test_one_clear_line(self):
        path = self.run_files("s1")
        self.refused("trace", self.folder / "no.csv", says=r"no\.csv: No such file.*; expected")
        self.refused("trace", path, "--panels", "speed,sped", says="'sped'.*expected.*speed-error")
        self.refused("trace", path, "--from", "7", says=r"s1\.csv: fewer than two.*expected")
        self.refused("trace", path, "--out", self.folder / "no" / "x.png", says=r"x\.png: .*place")
        self.refused("report", "--runs", self.folder / "no", says="no such folder")
        self.refused("design", self.folder / "no.json", says=r"no\.json: No such file.*; expected")
        few = self.write("few.csv", "time_s,speed_rpm\n0,1\n1,2\n")
        self.refused("trace", few, "--panels", "iq", says=r"few\.csv: no column '.*expected")
        self.refused("trace", few, says=r"few\.csv: .*expected")

    def test_a_figure_of_the_paper_needs_its_columns(self):
        path = self.run_files("s1")
        text = path.read_text(encoding="utf-8").replace("i_q_estimated_a", "unheard_of", 1)
        path.write_text(text, encoding="utf-8")
        self.refused("report", "--runs", self.folder, "--out", self.folder / "r",
                     says=r"s1\.csv: no column 'i_q_estimated_a'; expected it in the header")

    def test_help_teaches(self):
        for arguments, words in ((["--help"], ("motorsim run s1", "trace", "report")),
                                 (["trace", "--help"], ("--panels", *CATALOGUE)),
                                 (["report", "--help"], ("--runs", "fig. 5", "NAME.json")),
                                 (["design", "--help"], ("gaindesign", "4a", "--out"))):
            status, out, _ = captured(plot.main, *arguments)
            self.assertEqual(status, 0)
            for word in words:
                self.assertIn(word, out)

    def test_usage(self):
        self.assertEqual(captured(plot.main)[0], 2)
        self.assertEqual(captured(plot.main, "draw")[0], 2)

    def test_as_a_program(self):
        done = subprocess.run([sys.executable, TOOLS / "plot.py", "report", "--runs", self.folder],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("no runs; expected", done.stderr)


if __name__ == "__main__":
    unittest.main()
