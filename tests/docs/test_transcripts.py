# SPDX-License-Identifier: MIT
"""docs.transcripts: the transcripts in the guides are what the programs print today. To renew: tools/dev figures --write.

test_transcripts.py PROGRAMS GDB     PROGRAMS: the folder that has motorsim, nfconfig and gaindesign
"""
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/docs"))
import transcripts  # noqa: E402
from transcripts import departure, renewed  # noqa: E402

PROGRAMS, GDB = Path(sys.argv[1]).resolve(), sys.argv[2]


class Transcripts(unittest.TestCase):
    def test_each_command_prints_what_the_guide_shows(self):
        count = 0
        for _, _, of_block in transcripts.run(PROGRAMS, GDB):
            count += len(of_block)
            for one in of_block:
                with self.subTest(guide=one.guide.name, command=one.command):
                    self.assertIsNone(one.departure())
        self.assertGreater(count, 4)


class TheTest(unittest.TestCase):
    def test_a_line_that_is_not_printed_is_found(self):
        self.assertIsNone(departure(["a", "...", "d"], ["a", "b", "c", "d"]))
        self.assertEqual(departure(["a", "...", "e"], ["a", "b", "d"]), ("e", ["b", "d"]))
        self.assertEqual(departure(["a", "c"], ["a", "b", "c"]), ("c", ["b", "c"]))
        self.assertEqual(departure(["a"], ["a", "b"]), ("the end", ["b"]))
        self.assertIsNone(departure(["a", "..."], ["a"]))

    def test_a_command_goes_on_after_a_backslash(self):
        self.assertEqual(transcripts.commands("$ a \\\n    b\nshown\n$ c\n"), [("a \\\n    b", ["shown"]), ("c", [])])

    def test_digits_of_a_checksum_stand_for_any_and_those_of_a_number_do_not(self):
        self.assertIsNone(departure(["configuration 12ab34cd,"], ["configuration 00000000,"]))
        self.assertIsNotNone(departure(["raw 14387285"], ["raw 14387286"]))

    def test_what_is_renewed_shows_the_lines_in_place_of_the_old_ones(self):
        printed = ["head", "speed 3", "current 7", "more", "angle 5", "end 2"]
        self.assertEqual(renewed(["speed 1"], printed), printed)
        self.assertEqual(renewed(["head", "...", "angle 4", "..."], printed), ["head", "...", "angle 5", "..."])
        self.assertEqual(renewed(["...", "current 6", "...", "end 1"], printed), ["...", "current 7", "...", "end 2"])
        self.assertEqual(renewed(["head", "...", "end 2"], printed), ["head", "...", "end 2"])
        for shown in (["head 2", "...", "more", "...", "end 1"], ["...", "angle"], ["x", "..."], ["...", "x", "y", "..."]):
            self.assertIsNone(departure(renewed(shown, printed), printed), shown)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
