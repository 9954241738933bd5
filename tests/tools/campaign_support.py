# SPDX-License-Identifier: MIT
"""What the tests of campaigns share: campaign files, and the command line in this process."""

import contextlib
import os
from pathlib import Path
from unittest import mock

from support import FolderTest, captured
from robustness import campaign, cli, results

MOTORSIM = Path(os.environ["NF_MOTORSIM"])
RUNS = 6
# Some of the runs hold; the others end with the over-voltage of a ripple that no board allows.
MINE = """
title = "a few runs"
scenario = "campaign"
runs = 6
seed = 3

[set]
plant.adc_noise_lsb = 1
scenario.duration_s = 0.2

[vary]
plant.resistance_scale = { uniform = [0.9, 1.1] }
plant.inertia_scale = { log_uniform = [0.5, 2] }
plant.bus_ripple_pct = { choice = [0, 40] }
scenario.seed = { integer = [0, 4294967295] }
"""


class CampaignTest(FolderTest):
    def file(self, text=MINE, **replaced):
        """A campaign file; `replaced` gives top-level keys other values."""
        for key, value in replaced.items():
            text = "\n".join(f"{key} = {value}" if line.startswith(f"{key} =") else line
                             for line in text.splitlines())
        return self.write("mine.toml", text)

    def load(self, text=MINE):
        return campaign.load(str(self.file(text)))

    def called(self, *words):
        """Exit status, standard output and standard error."""
        return captured(cli.main, *words)

    def run_mine(self, *words, out="out", draws=False):
        """Without the map of the runs, if that is not what is tested: to draw it takes longer than the runs."""
        with contextlib.nullcontext() if draws else mock.patch("robustness.fail_map.write", return_value=None):
            return self.called("run", self.folder / "mine.toml", "--motorsim", MOTORSIM, "--out",
                               self.folder / out, *words)

    def rows(self, out="out"):
        return results.read(self.folder / out)[1]

    def lines(self, out="out"):
        return (self.folder / out / results.FILE).read_text(encoding="utf-8").splitlines()

    def assert_refused(self, done, says):
        status, out, err = done
        self.assertEqual((status, out), (2, ""))
        self.assertRegex(err, says)
        self.assertEqual(err.count("\n"), 1, err)
