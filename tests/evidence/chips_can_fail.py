# SPDX-License-Identifier: MIT
"""evidence.chips_can_fail: a file of facts that differs from the crate is found. Without cargo: the crate says here what the files
say, but for one change.
"""

import copy
import shutil
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import chips
from chips import facts

CHIP = "stm32g431cb"


class ChipsCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        shutil.copy(facts.file_of(CHIP), self.folder)
        self.now = facts.read(CHIP)

    def wrong(self, now):
        return facts.compared(CHIP, now, self.folder)

    def test_equal_facts_are_no_finding(self):
        self.assertEqual(self.wrong(self.now), [])

    def test_each_kind_of_fact_that_differs_is_one_finding(self):
        for path, value in ((("peripherals", "TIM1", "base"), "0x40012c04"), (("interrupts", "ADC1_2"), 19),
                            (("pins", "PA8", "TIM1_CH1"), 4), (("pins", "PA8", "TIM9_CH1"), 4),
                            (("codes", "rcc/g4/RCC", "CFGR.SW", "HSE"), 3), (("peripherals", "ADC1", "enable"), "AHB2ENR.ADC345EN")):
            with self.subTest(path):
                now = copy.deepcopy(self.now)
                *way, last = path
                at = now
                for key in way:
                    at = at[key]
                at[last] = value
                (line,) = self.wrong(now)
                self.assertTrue(line.startswith(f"{CHIP}: {'/'.join(path)}: the file has "), line)

    def test_a_mask_that_differs_and_a_register_that_is_gone_are_found(self):
        now = copy.deepcopy(self.now)
        now["registers"]["timer/v2/TIM_ADV"]["CR1"][2]["CEN"] = "0x2"
        self.assertEqual(len(self.wrong(now)), 1)
        del now["registers"]["timer/v2/TIM_ADV"]["CR1"]
        self.assertGreater(len(self.wrong(now)), 1)

    def test_another_layout_and_a_file_that_is_cut_or_gone_are_found(self):
        file = facts.file_of(CHIP, self.folder)
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace("\n", " \n", 1), encoding="utf-8")
        self.assertIn("the layout is another one", self.wrong(self.now)[0])
        file.write_text(text[:1000], encoding="utf-8")
        with self.assertRaisesRegex(facts.Unable, "write it anew"):
            self.wrong(self.now)
        file.unlink()
        with self.assertRaisesRegex(facts.Unable, "write it anew"):
            self.wrong(self.now)

    def part(self, crate):
        """Rows and findings of the part, with what the crate says."""
        with mock.patch.object(facts, "need_cargo", return_value="cargo"), \
                mock.patch.object(facts, "fresh", return_value=crate), mock.patch("builtins.print"):
            return chips.compared([CHIP])

    def test_the_part_compares_each_chip(self):
        rows, findings = self.part(facts.read(CHIP))
        self.assertEqual((rows[0][0], rows[0][2], findings), (CHIP, 0, []))
        self.now["interrupts"]["ADC1_2"] = 19
        rows, findings = self.part(self.now)
        self.assertEqual((rows[0][2], len(findings)), (1, 1))
        self.assertFalse(all(figure["ok"] for figure in chips.result([CHIP], rows)[0]))

    def test_without_a_cargo_that_is_new_enough_it_fails_and_says_what_is_needed(self):
        for said, found in ((None, "there is no cargo"), ("cargo 1.75.0", "found cargo 1.75.0"), ("error: no toolchain", "error: no toolchain")):
            answer = mock.Mock(stdout=said)
            with mock.patch.object(facts.shutil, "which", return_value=said and "/usr/bin/cargo"), \
                    mock.patch.object(facts.subprocess, "run", return_value=answer):
                rows, findings = chips.compared([CHIP])
            self.assertEqual(rows, [])
            self.assertIn(found, findings[0])
            self.assertIn("expected cargo 1.85 or later", findings[0])
            self.assertFalse(all(figure["ok"] for figure in chips.result([CHIP], rows)[0]))

    def test_each_chip_has_a_file_and_each_file_a_chip(self):
        self.assertEqual(facts.chips(), sorted(path.stem for path in facts.FOLDER.glob("stm32*.json")))


if __name__ == "__main__":
    unittest.main()
