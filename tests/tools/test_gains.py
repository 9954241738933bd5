# SPDX-License-Identifier: MIT
"""The figures of a gain design, from a made-up design."""

import json
import unittest

from support import FolderTest
from report import design_section, gains
from report.runs import PlotError
from report.style import NARROW, PRINT


def made_up_response(step, pair):
    return {"step": step, "pair": pair, "time_s": [0, 0.01, 0.02], "speed_rad_s": [0, -0.1, -0.05],
            "i_d_a": [0, 0.2, 0.1], "settled_i_d_a": 0.15}


def made_up_model(matrices):
    pairs = [("arbitrary", 0.04, 0.0001), ("published", 0.264, 0.035), ("optimum", 0.3, 0.036)]
    return {
        "matrices": matrices,
        "stable_region": {"kp": [-1, 0, 0.4], "largest_ki_per_s": [0, 0.7, 0]},
        "optimum": {"kp": 0.3, "ki_per_s": 0.036},
        "pairs": [{"name": name, "kp": kp, "ki_per_s": ki} for name, kp, ki in pairs],
        "responses": [made_up_response(step, name) for name, _, _ in pairs
                      for step in ("load", "speed")]}


COMPARISON = [
    {"quantity": "optimum_ki_per_s", "paper": 0.035, "printed": None, "computed": -0.0361119, "remark": "a & b"}]


class GainFigures(FolderTest):
    def design(self, *matrices):
        return self.write("design.json",
                          json.dumps({"models": [made_up_model(name) for name in matrices],
                                      "comparison": COMPARISON}))

    def test_six_figures_are_written(self):
        path = self.design("computed", "printed")
        written = gains.write_figures(path, self.folder / "report")
        self.assertEqual([one.name for one in written], [
            f"design_{key}.png" for key in ("fig3", "fig4a", "fig4b", "fig5a", "fig5b", "fig6")])
        for one in written:
            self.assertTrue(one.read_bytes().startswith(b"\x89PNG"))

    def test_the_papers_gains_are_marked_and_named_in_the_zoom(self):
        whole, near = gains.draw_region(gains.read_design(self.design("computed")), PRINT).axes
        named = [text.get_text() for text in near.texts]
        self.assertEqual(named, [
            "paper, fig. 4a, 5a\n0.04, 0.0001", "paper, fig. 4b, 5b, 6\n0.264, 0.035",
            "other sign: unstable\n0.264, \N{MINUS SIGN}0.035", "optimum, computed\n0.3, 0.036"])
        places = [(line.get_xdata()[0], line.get_ydata()[0]) for line in near.lines
                  if line.get_marker() != "None"]
        self.assertEqual(places, [(0.04, 0.0001), (0.264, 0.035), (0.264, -0.035), (0.3, 0.036)])
        self.assertFalse(whole.texts)

    def test_every_mark_is_within_the_zoom(self):
        (left, right), (low, high) = gains.zoom(
            gains.read_design(self.design("computed", "printed")))
        for kp, ki in ((0.04, 0.0001), (0.264, 0.035), (0.264, -0.035), (0.3, 0.036)):
            self.assertTrue(left < kp < right and low < ki < high)

    def test_a_response_shows_its_signal_for_each_set_of_matrices(self):
        design = gains.read_design(self.design("computed", "printed"))
        figure = gains.draw_response(design, gains.RESPONSES[-1], NARROW)
        drawn = [list(line.get_ydata()) for line in figure.axes[0].lines]
        self.assertEqual(drawn.count([0, 0.2, 0.1]), 2)
        self.assertEqual(drawn.count([0.15, 0.15]), 2)     # where it settles

    def test_the_section_has_each_figure_and_each_quantity_with_its_unit(self):
        name, _, text = design_section.entry(self.design("computed", "printed"), self.folder)
        self.assertEqual(text.count("<figure>"), 6)
        self.assertEqual(text.count('aria-label="'), 12)
        self.assertIn(f'id="{name}"', text)
        self.assertIn("<th scope=row>optimum K_i, 1/s</th>", text)
        for cell in ('"paper">0.035<', '"printed matrices">–<', '"computed">−0.0361119<', '"remark">a &amp; b<'):
            self.assertIn(f"data-label={cell}", text)
        self.assertIn("printed: 0 to 0.2, settles at 0.15.", text)

    def test_numbers_that_are_read_keep_their_digits(self):
        text = design_section.entry(self.design("computed"), self.folder)[2]
        self.assertIn("0.264, 0.035", text)

    def test_what_is_no_design_gets_one_line(self):
        for text, says in (("[", "Expecting"), ('{"models": []}', "IndexError"), ("[]", "TypeError")):
            path = self.write("x.json", text)
            with self.assertRaisesRegex(PlotError, rf"x\.json: .*{says}.*; expected the output"):
                gains.read_design(path)


if __name__ == "__main__":
    unittest.main()
