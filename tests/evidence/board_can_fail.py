# SPDX-License-Identifier: MIT
"""evidence.board_can_fail: a branch that no test takes both ways is found, and so is a justification that nothing needs."""

import json
import tempfile
import unittest
from pathlib import Path

import board
import part

IMAGE = part.ROOT / "build" / "stm32g4" / "neurofoc_310v.elf"
RECORDS = sorted((part.ROOT / "build" / "host" / "evidence" / "branches").glob("*.json"))


class BoardCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.register = self.folder / "justified.toml"
        self.register.write_text((part.ROOT / board.REGISTER).read_text(encoding="utf-8"), encoding="utf-8")
        self.listed = board.decisions.listed(IMAGE)

    def findings(self, total=None):
        measured, bad = board.counts(IMAGE, RECORDS)
        self.assertEqual(bad, [])
        return board.judge(self.listed, total or measured, part.ROOT, self.register)[0]

    def test_nothing_is_found_in_what_there_is(self):
        self.assertEqual(self.findings(), [])

    def test_each_way_that_no_test_goes_is_found(self):
        whole, _ = board.counts(IMAGE, RECORDS)
        for decision in self.listed:
            for way in (0, 1):
                if whole[decision.address, way]:
                    total = whole.copy()
                    total[decision.address, way] = 0
                    with self.subTest(decision=decision, way=way):
                        key = next(key for key, _, one in board.gaps(self.listed, total, part.ROOT) if one == decision)
                        known = board.justified(self.register)[0]
                        self.assertTrue(key in known or any(f"{decision.address:#x}" in line for line in self.findings(total)))

    def test_each_file_that_no_pc_runs_has_branches(self):
        files = {Path(decision.where[0][1]).name for decision in self.listed}
        self.assertLessEqual({"clock.c", "guard.c", "hal_g4.c", "main.c", "pwm.c", "sensing.c", "trip.c", "uart.c"},
                             files | {Path(place[1]).name for decision in self.listed for place in decision.where})

    def test_a_record_of_another_image_is_found(self):
        other = self.folder / "other.json"
        other.write_text(json.dumps({"0" * 64: {}}), encoding="utf-8")
        self.assertEqual(board.counts(IMAGE, [other, self.folder / "none.json"])[1],
                         [f"{name}.json: no record of this image; its test of target.loop writes it" for name in ("other", "none")])

    def test_a_justification_that_nothing_needs_is_found(self):
        with self.register.open("a", encoding="utf-8") as file:
            file.write('\n[[justified]]\nfile = "a.c"\nfunction = "f"\ntext = "x"\ncaller = ""\nway = "never"\nreason = "r"\n')
        self.assertEqual(self.findings(), [f"{board.REGISTER}: a.c (f): 'x' needs no justification"])


if __name__ == "__main__":
    unittest.main()
