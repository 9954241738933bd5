# SPDX-License-Identifier: MIT
"""target.states: the recording that all cores replay passes through every state of the start-up.

test_states.py DRIVE_H FOLDER: FOLDER holds results.nfr of `record`.
"""

import itertools
import re
import struct
import sys
import unittest
from pathlib import Path

DRIVE_H, FOLDER = sys.argv[1:3]
HEADER = struct.Struct("<IHHII")  # hal/mps2/recording.h
RESULT = struct.Struct("<HHHBBI")
STATE = 4
START_UP = "OFFSET_CAL READY FLYING_START ALIGN HOLD IF_RAMP HANDOVER RUN".split()


def states():
    """The names of the states in the order in which the run enters them."""
    listed = re.search(r"typedef enum \{([^}]*)\} drive_state_t;", Path(DRIVE_H).read_text())[1]
    names = {int(code, 16): name for name, code in re.findall(r"DRIVE_STATE_(\w+) = (0x\w+)", listed)}
    results = (Path(FOLDER) / "results.nfr").read_bytes()[HEADER.size:]
    of_tick = [names[result[STATE]] for result in RESULT.iter_unpack(results)]
    return [state for state, _ in itertools.groupby(of_tick)]


class States(unittest.TestCase):
    def test_every_state_of_the_start_up_is_in_the_recording_in_its_order(self):
        entered = states()
        first = [entered.index(state) if state in entered else None for state in START_UP]
        self.assertNotIn(None, first, f"entered are {entered}")
        self.assertEqual(first, sorted(first), f"entered are {entered}")

    def test_it_ends_without_a_fault(self):
        self.assertNotIn("FAULT", states())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
