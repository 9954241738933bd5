# SPDX-License-Identifier: MIT
"""What the tests of the tools share: the path of the tools and made-up runs."""

import os
import sys
import tempfile
import unittest
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))
os.environ.setdefault("MPLCONFIGDIR", os.path.join(tempfile.gettempdir(), "neurofoc-matplotlib"))

import synthetic  # noqa: E402

COARSE_S = 2e-3     # period of the runs of most tests: small files, quick figures


def captured(main, *words):
    """Exit status, output and errors of a command line in this process."""
    out, err = StringIO(), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            status = main([str(word) for word in words])
        except SystemExit as ended:
            status = ended.code
    return status, out.getvalue(), err.getvalue()


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
