# SPDX-License-Identifier: MIT
"""Reading runs: what is accepted, and the one line that says what is wrong."""

import unittest

import numpy as np

from support import FolderTest
from report.runs import PlotError, Run, read_metrics, read_runs, read_trace

HEADER = "time_s,state,speed_rpm\n"


class Traces(FolderTest):
    def read(self, text):
        return read_trace(self.write("t.csv", text))

    def refused(self, text, *words):
        with self.assertRaises(PlotError) as caught:
            self.read(text)
        line = str(caught.exception)
        self.assertNotIn("\n", line)
        for word in ("t.csv", "expected", *words):
            self.assertIn(word, line)

    def test_numbers_and_words(self):
        trace = self.read(HEADER + "0,RUN,1.5\n1e-4,FAULT,-2\n")
        np.testing.assert_array_equal(trace["speed_rpm"], [1.5, -2])
        self.assertEqual(list(trace["state"]), ["RUN", "FAULT"])

    def test_cut_keeps_both_ends(self):
        trace = self.read("time_s\n-1\n0\n1\n2\n")
        np.testing.assert_array_equal(trace.cut(start=0.0)["time_s"], [0, 1, 2])
        np.testing.assert_array_equal(trace.cut(end=0.0)["time_s"], [-1, 0])

    def test_cut_beyond_the_trace(self):
        with self.assertRaisesRegex(PlotError, "expected a part of -1 s to 2 s"):
            self.read("time_s\n-1\n0\n1\n2\n").cut(start=5.0)

    def test_refusals(self):
        self.refused("", "time_s")
        self.refused("speed_rpm\n1\n", "time_s")
        self.refused("time_s,a,a\n0,1,2\n", "twice")
        self.refused(HEADER + "0,RUN\n", "line 2 has 2 fields")
        self.refused(HEADER + "0,RUN,fast\n1,RUN,2\n", "speed_rpm", "fast")
        self.refused(HEADER + "0,RUN,1\n1,RUN,nan\n", "speed_rpm", "nan in line 3")
        self.refused(HEADER + "0,RUN,1\n", "does not rise")
        self.refused(HEADER + "0,RUN,1\n0,RUN,1\n", "does not rise")

    def test_a_header_alone_is_refused(self):
        self.refused(HEADER, "does not rise")

    def test_a_trace_cut_off_anywhere_is_read_or_refused_in_one_line(self):
        whole = HEADER + "0,RUN,1.5\n1e-4,FAULT,-2\n2e-4,FAULT,nan\n"
        for length in range(len(whole)):
            with self.subTest(whole[:length]):
                try:
                    self.read(whole[:length])
                except PlotError as error:
                    self.assertNotIn("\n", str(error))

    def test_missing_column_names_those_there(self):
        trace = self.read(HEADER + "0,RUN,1\n1,RUN,1\n")
        with self.assertRaisesRegex(PlotError, r"t\.csv: no column 'i_q_a'.*time_s, state"):
            _ = trace["i_q_a"]


class Metrics(FolderTest):
    def test_refusals(self):
        for text in ("", "[1, 2]", "{", "3"):
            with self.subTest(text), self.assertRaisesRegex(PlotError, r"m\.json: .*expected"):
                read_metrics(self.write("m.json", text))

    def test_scenario_of_a_run(self):
        for named, scenario in (("S2", "s2"), ("s2_robust", "s2"), ("scenarios/s2.toml", "s2"),
                                (None, "other"), ("s2nd_try", "s2nd_try")):
            self.assertEqual(Run("other", None, {"scenario": named}).scenario, scenario)


class Folders(FolderTest):
    def test_runs_in_natural_order(self):
        for name in ("s10", "s2", "s1"):
            self.write(f"{name}.csv", "time_s\n0\n1\n")
            self.write(f"{name}.json", "{}")
        self.assertEqual([run.name for run in read_runs(self.folder)], ["s1", "s2", "s10"])

    def test_half_a_run(self):
        self.write("s1.csv", "time_s\n0\n1\n")
        with self.assertRaisesRegex(PlotError, r"s1\.json: No such file.*expected the metrics"):
            read_runs(self.folder)
        (self.folder / "s1.csv").rename(self.folder / "s1.json")
        with self.assertRaisesRegex(PlotError, r"s1\.csv: No such file.*expected the CSV"):
            read_runs(self.folder)

    def test_no_runs(self):
        with self.assertRaisesRegex(PlotError, "no runs; expected NAME.csv"):
            read_runs(self.folder)
        with self.assertRaisesRegex(PlotError, "no such folder"):
            read_runs(self.folder / "none")


if __name__ == "__main__":
    unittest.main()
