# SPDX-License-Identifier: MIT
"""The report: the numbers beside the claim, and a page that needs nothing from elsewhere."""

import json
import re
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path

from jinja2 import UndefinedError

import synthetic
from support import COARSE_S, FolderTest
from report import claim
from report.assemble import write_report
from report.metrics import limit_text, tables, text_of, without
from report.page import page
from report.render import render
from report.runs import Run, read_runs

VOID = {"meta", "link", "br", "wbr", "img", "hr", "input"}


class Page(HTMLParser):
    """Checks that tags close in order, and collects identifiers and references."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.references, self.labels = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            if name in ("href", "src", "xlink:href"):
                self.references.append(value)
            if name == "aria-label" and tag == "svg":
                self.labels.append(value)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()


def run(name="s1", **metrics):
    return Run(name, None, {"scenario": name, **metrics})


class Claim(unittest.TestCase):
    def test_rated_current_of_motor_a(self):
        self.assertAlmostEqual(claim.MOTOR_A.i_q_a, 6.72, places=2)

    def test_percentages(self):
        speed, settled, current, angle = claim.values(run(
            speed_error_max_rpm=9.0, speed_error_max_pct=0.5, command_error_settled_pct=2.5,
            iq_error_max_a=claim.MOTOR_A.i_q_a / 50, angle_error_max_deg=3.6))
        self.assertEqual((speed.percent, settled.percent, angle.percent), (0.5, 2.5, 1.0))
        self.assertAlmostEqual(current.percent, 2.0)
        self.assertTrue(speed.within and current.within)
        self.assertFalse(settled.within)

    def test_absent_and_null_do_not_apply(self):
        self.assertEqual(claim.values(run(command_error_settled_pct=None)), (None,) * 4)

    def test_rated_speed_from_the_metrics_first(self):
        odd = run("odd", speed_error_max_rpm=30.0, speed_error_max_pct=1.0)
        self.assertAlmostEqual(claim.rated_speed(odd), 3000.0)
        self.assertEqual(claim.rated_speed(run()), 1800.0)
        self.assertIsNone(claim.rated_speed(run("odd")))

    def test_limits_of_the_scenario(self):
        for metrics, kept in (({}, None), ({"accepted": True}, True),
                              ({"accepted": False, "failed_limits": ["x"]}, False),
                              ({"failed_limits": []}, True), ({"limits_failed": ["x"]}, False),
                              ({"accepted": "?"}, None)):
            self.assertEqual(claim.accepted(metrics), kept, metrics)

    def test_metric_texts(self):
        for value, text in ((True, "yes"), (0, "0"), ([], "none"), (-0.00123456, "−0.001235"), ({"a": 0}, "none"),
                            ({"a": 2, "b": 0}, "a: 2"), (["x", "y"], "x, y")):
            self.assertEqual(text_of(value), text)

    def test_a_limit_that_was_broken_has_the_name_and_the_unit_of_its_metric(self):
        self.assertEqual(limit_text("id_settled_a = 3.477, limit: 0.02"), "d current, settled = 3.477 A, limit: 0.02")
        self.assertEqual(limit_text("in a fault at the end"), "in a fault at the end")

    def test_what_has_members_is_a_table_and_what_does_not_apply_is_only_named(self):
        measured = run(settling_time_s=None, saturations={"voltage": 3}, motor={"pole_pairs": 2, "max_current_a": 6.3},
                       parameters={"flux_linkage_wb": {"configured": 0.375, "estimated": 0.37}})
        self.assertEqual(without(measured), ["settling time"])
        self.assertEqual(tables(measured), [
            ("motor", ["", "value"], [["pole pairs", "2"], ["max current, A", "6.3"]]),
            ("parameters", ["", "configured", "estimated"], [["flux linkage, Wb", "0.375", "0.37"]])])


class OfOneFolder(unittest.TestCase):
    """A page of several runs, which is written once."""

    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        for name, scenario in (("s1", "s1"), ("s2", "s2"), ("s3", "s3"), ("s2_robust", "s2")):
            synthetic.write(cls.folder, name, scenario, period=COARSE_S)
        cls.path = write_report(cls.folder, cls.folder / "out" / "report")
        cls.text = cls.path.read_text(encoding="utf-8")

    def test_it_is_complete(self):
        checked = Page(self.text)
        self.assertEqual(checked.open, [])
        self.assertEqual(len(checked.ids), len(set(checked.ids)))
        for name in ("s1_fig5", "s2_fig6", "s2_fig8", "s2_robust_fig8", "s3_fig7"):
            self.assertIn(f"{name}.png", checked.references)
        self.assertEqual(len(checked.labels), 12)   # six figures, each wide and narrow
        self.assertTrue(all(checked.labels))

    def test_references_stay_in_the_folder(self):
        checked = Page(self.text)
        for reference in checked.references:
            if reference.startswith("#"):
                self.assertIn(reference[1:], checked.ids)
            else:
                self.assertTrue((self.path.parent / reference).is_file(), reference)
        for address in re.findall(r"https?://[^\s\"']+", self.text):
            self.assertTrue(address.startswith("http://www.w3.org/"), address)
        self.assertNotIn(str(self.folder), self.text)

    def test_the_part_before_zero_is_not_judged(self):
        for shown in read_runs(self.folder):
            self.assertLess(shown.trace["time_s"][0], 0.0)
        self.assertNotIn("at −0.", self.text)


class Report(FolderTest):
    def report(self):
        path = write_report(self.folder, self.folder / "out" / "report")
        return path, path.read_text(encoding="utf-8")

    def test_a_scenario_that_the_paper_does_not_have(self):
        self.run_files("coast", "s1")
        path = self.folder / "coast.json"
        metrics = json.loads(path.read_text(encoding="utf-8"))
        metrics.update(scenario="coast", unheard_of=7)
        path.write_text(json.dumps(metrics), encoding="utf-8")
        _, text = self.report()
        self.assertIn("coast_overview.png", text)
        self.assertIn("unheard of", text)

    def test_texts_are_escaped(self):
        odd = Run("s1", None, {"scenario": "s1", "faults": ["<b>"], "with": ["<i>"],
                               "failed_limits": ["a < b"]})
        text = page([(odd, [])])
        for raw in ("<b>", "<i>", "a < b"):
            self.assertNotIn(raw, text)
        self.assertEqual(Page(text).open, [])

    def test_a_value_that_a_template_lacks_is_an_error(self):
        with self.assertRaisesRegex(UndefinedError, "'columns' is undefined"):
            render("report/voltage_drive.jinja", key="k", rows=[])

    def test_same_runs_same_page(self):
        self.run_files("s3")
        self.assertEqual(self.report()[1], self.report()[1])


if __name__ == "__main__":
    unittest.main()
