# SPDX-License-Identifier: MIT
"""What the tests of the tools share: the path of the tools and made-up runs."""

import os
import sys
import tempfile
import unittest
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))
os.environ.setdefault("MPLCONFIGDIR", os.path.join(tempfile.gettempdir(), "neurofoc-matplotlib"))

import synthetic  # noqa: E402

COARSE_S = 2e-3     # period of the runs of most tests: small files, quick figures


class FolderTest(unittest.TestCase):
    """A test with an empty folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_files(self, name, scenario=None):
        return synthetic.write(self.folder, name, scenario, period=COARSE_S)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path
