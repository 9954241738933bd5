# SPDX-License-Identifier: MIT
"""target.refuses: what is not identical is found, and a board that cannot replay says why.

test_identity.py QEMU BOARD IMAGE FOLDER, as identity.py.
"""

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

QEMU, BOARD, IMAGE, FOLDER = sys.argv[1:5]
IDENTITY = Path(__file__).with_name("identity.py")
HEADER, FRAME, RESULT = 16, 18, 12
CONFIG_HASH = 8


class Refuses(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for name in ("frames.nfr", "results.nfr"):
            shutil.copy(Path(FOLDER) / name, self.folder)

    def flip(self, name, at):
        path = self.folder / name
        data = bytearray(path.read_bytes())
        data[at] ^= 1
        path.write_bytes(data)

    def assert_fails(self, *texts):
        run = subprocess.run([sys.executable, IDENTITY, QEMU, BOARD, IMAGE, self.folder],
                             capture_output=True, text=True)
        self.assertEqual(run.returncode, 1, run.stdout)
        for text in texts:
            self.assertIn(text, run.stderr)

    def test_one_bit_of_one_result(self):
        self.flip("results.nfr", HEADER + 1234 * RESULT + 2)
        self.assert_fails("tick 1234: compare b")

    def test_one_bit_of_a_measurement_shows_in_the_tick(self):
        self.flip("frames.nfr", HEADER + 5000 * FRAME)
        self.assert_fails("tick 5000:", "state hash")

    def test_recording_of_another_configuration(self):
        self.flip("frames.nfr", CONFIG_HASH)
        self.assert_fails("ends with 2", "another configuration")

    def test_frames_that_end_too_early(self):
        path = self.folder / "frames.nfr"
        path.write_bytes(path.read_bytes()[:-1])
        self.assert_fails("ends with 2", "frames.nfr ends too early")

    def test_no_frames(self):
        (self.folder / "frames.nfr").unlink()
        self.assert_fails("ends with 2", "frames.nfr cannot be read")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
