# SPDX-License-Identifier: MIT
"""Figures: the panels of the paper, shared ranges, and the same bytes for the same run."""

import itertools
import math
import unittest

from support import COARSE_S, FolderTest
from report import claim, style, weakening
from report.caption import alternative, caption
from report.draw import draw
from report.layouts import SCENARIOS, layouts, overview
from report.panels import CATALOGUE, Panel
from report.picture import save
from report.runs import PlotError, Run, read_runs
from report.svg import svg

VOLTAGE = {"fig6": ["command and actual speed", "actual d current", "actual q current", "voltage",
                    "actual − estimated angle"]}
PAPER = {   # scenario: figure: what its panels (a), (b), … show
    "s1": {"fig5": ["command and actual speed", "command and estimated speed",
                    "actual q current", "estimated q current", "actual and estimated angle"]},
    "s2": {"fig6": ["command and actual speed", "command and estimated speed",
                    "actual q current", "estimated q current", "actual and estimated angle"],
           "fig8": ["command − estimated speed", "actual − estimated speed",
                    "actual − estimated q current", "actual − estimated angle"]},
    "s3": {"fig7": ["command, actual and estimated position", "actual and estimated speed",
                    "actual and estimated angle", "actual q current", "estimated q current"]},
    "s4": VOLTAGE,
    "s5": VOLTAGE,
}


class Layouts(unittest.TestCase):
    def test_the_paper_s_panels(self):
        shown = {scenario: {layout.key: [panel.title for panel in layout.panels]
                            for layout in figures} for scenario, figures in SCENARIOS.items()}
        lettered = {scenario: {key: [f"({letter}) {title}" for letter, title in zip("abcde", titles)]
                               for key, titles in figures.items()}
                    for scenario, figures in PAPER.items()}
        self.assertEqual(shown, lettered)

    def test_a_title_names_the_lines_of_its_panel(self):
        for layout in (layout for figures in SCENARIOS.values() for layout in figures):
            for panel in layout.panels:
                roles = {line.role for line in panel.lines} - {"d", "q"}    # the legend names those
                named = {role for role in ("command", "actual", "estimated")
                         if role in panel.title}
                self.assertEqual(roles if roles != {"difference"} else named, named, panel.title)


class Figures(FolderTest):
    def run_of(self, scenario):
        self.run_files(scenario)
        run, = read_runs(self.folder)
        return run

    def drawn(self, run, number=0, shape=style.PRINT):
        layout = layouts(run)[number]
        return draw(run.trace.cut(0.0), layout, shape, claim.bases(run))

    def axes(self, figure, title):
        return next(ax for ax in figure.axes if ax.get_title(loc="left").startswith(title))

    def test_both_q_currents_share_their_range(self):
        figure = self.drawn(self.run_of("s1"))
        self.assertEqual(self.axes(figure, "(c)").get_ylim(), self.axes(figure, "(d)").get_ylim())

    def test_all_panels_but_the_zoom_share_the_time(self):
        figure = self.drawn(self.run_of("s2"))
        for letter in "abcd":
            low, high = self.axes(figure, f"({letter})").get_xlim()
            self.assertEqual(low, 0.0)
            self.assertAlmostEqual(high, 1.0 + COARSE_S)
        self.assertLess(self.axes(figure, "(e)").get_xlim()[1], 1.0)

    def test_the_claim_is_in_view_of_every_error(self):
        run = self.run_of("s2")
        figure = self.drawn(run, 1)
        bases = claim.bases(run)
        for letter, base in zip("abcd", ("speed", "speed", "current", "turn")):
            low, high = self.axes(figure, f"({letter})").get_ylim()
            self.assertLess(low, -0.02 * bases[base])
            self.assertGreater(high, 0.02 * bases[base])

    def test_units_on_all_panels(self):
        for panel in CATALOGUE.values():
            self.assertEqual(panel.unit == "", panel.kind == "state", panel.title)

    def test_same_run_same_bytes(self):
        run = self.run_of("s1")
        for suffix in ("png", "svg", "pdf"):
            paths = [self.folder / f"{k}.{suffix}" for k in (1, 2)]
            for path in paths:
                save(self.drawn(run), style.PRINT, path)
            self.assertEqual(paths[0].read_bytes(), paths[1].read_bytes(), suffix)

    def test_unknown_format_is_refused(self):
        with self.assertRaisesRegex(PlotError, r"x\.doc: .*expected \.png"):
            save(self.drawn(self.run_of("s1")), style.PRINT, self.folder / "x.doc")

    def test_svg_follows_the_page(self):
        text = svg(self.drawn(self.run_of("s2"), 1, style.NARROW), style.NARROW, "name", 'a "b"')
        self.assertTrue(text.startswith('<svg role="img" aria-label="a &quot;b&quot;"'))
        self.assertIn("var(--difference)", text)
        self.assertNotIn('id="axes_1"', text)
        self.assertNotRegex(text, r"(fill|stroke): #[0-9a-f]{6}")

    def test_words_give_steps_and_largest_values(self):
        run = self.run_of("s2")
        trace, errors = run.trace.cut(0.0), layouts(run)[1]
        words = alternative(trace, errors, claim.bases(run))
        self.assertIn("load 3 N·m at 0.5 s, no load at 0.8 s", words)
        self.assertRegex(caption(trace, errors, claim.bases(run)), r"\(d\) .*° el\. \([\d.e−]+ %\)")

    def test_overview_leaves_out_what_does_not_move(self):
        titles = [panel.title for panel in overview(self.run_of("s1").trace)]
        self.assertIn("speed", titles)
        self.assertNotIn("state of the drive", titles)      # RUN all the time
        self.assertNotIn("position (mechanical)", titles)   # no position command

    def test_states_of_the_drive(self):
        trace = self.run_of("s1").trace
        trace["state"][:100] = "ALIGN"
        panels = overview(trace)
        self.assertEqual(panels[0].kind, "state")
        figure = draw(trace, layouts_of(panels), style.PRINT)
        self.assertIn("RUN", [text.get_text() for ax in figure.axes for text in ax.texts])


class Weakening(FolderTest):
    """The plane of the currents, of a run of made-up motor data."""

    def run_with(self, rated_speed_rpm, inductance_q_h=0.01):
        self.run_files("s1")
        run, = read_runs(self.folder)
        actual = {"resistance_ohm": 2.0, "inductance_d_h": 0.01, "inductance_q_h": inductance_q_h, "flux_linkage_wb": 0.4}
        return Run("s_weakening", run.trace.cut(0.0), {
            "parameters": {name: {"actual": value} for name, value in actual.items()},
            "motor": {"pole_pairs": 2, "rated_speed_rpm": rated_speed_rpm, "max_current_a": 10.0}})

    def test_only_a_run_beyond_rated_speed_has_it(self):
        self.assertTrue(weakening.goes_beyond(self.run_with(1000.0)))
        self.assertFalse(weakening.goes_beyond(self.run_with(2500.0)))
        unknown = self.run_with(1000.0)
        del unknown.metrics["motor"]
        self.assertFalse(weakening.goes_beyond(unknown))

    def test_the_curve_is_the_current_s_torque_and_falls_where_the_voltage_ends(self):
        motor = weakening.Motor(self.run_with(1000.0).metrics)
        slow, fast, braking = (motor.limits([rpm], 179.0, sign)[0] for rpm, sign in ((100, 1), (2600, 1), (2600, -1)))
        self.assertAlmostEqual(slow, 1.5 * 2 * 0.4 * 10, places=6)
        self.assertLess(fast, 0.7 * slow)
        self.assertGreater(-braking, fast)
        self.assertTrue(math.isnan(motor.limits([20000], 179.0, 1)[0]))

    def test_no_other_current_has_more_torque_than_the_line_of_a_salient_motor(self):
        motor = weakening.Motor(self.run_with(1000.0, inductance_q_h=0.03).metrics)
        for i_q in (-9.0, 2.0, 6.0):
            i_d = motor.most_torque_d(i_q)
            size = math.hypot(i_d, i_q)
            torque = abs(motor.torque(i_d, i_q))
            for turn in (-0.02, 0.02):
                angle = math.atan2(i_q, i_d) + turn
                self.assertLess(abs(motor.torque(size * math.cos(angle), size * math.sin(angle))), torque)
        self.assertFalse(weakening.Motor(self.run_with(1000.0).metrics).is_salient())

    def test_it_fits_both_widths(self):
        for run, shape in itertools.product((self.run_with(1000.0), self.run_with(1000.0, inductance_q_h=0.03)),
                                            (style.PRINT, style.NARROW)):
            figure = weakening.draw(run, shape)
            self.assertEqual([ax.get_title(loc="left") for ax in figure.axes], ["(a) torque over speed", "(b) currents"])
            text = svg(figure, shape, "plane", weakening.WORDS)
            self.assertNotRegex(text, r"(fill|stroke): #[0-9a-f]{6}")


def layouts_of(panels: tuple[Panel, ...]):
    from report.layouts import Layout
    return Layout("k", "title", panels)


if __name__ == "__main__":
    unittest.main()
