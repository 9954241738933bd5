# SPDX-License-Identifier: MIT
"""target.loop.command: the control tick finds whole commands only, wherever it interrupts the background.

test_command.py IMAGE BOARD CLOCK GDB
"""

import struct
import sys
import unittest
from pathlib import Path

import board
from copies import in_a_copy
from elf import address_of, offsets
from rig import BOARD, CLOCK, IMAGE, MIDDLE

GDB = Path(sys.argv[4])
COMMAND = struct.Struct("<iBB2x")  # target, mode, request; as gdb is asked below
RUN = 1
TYPED = b"speed 1000\rrun\r"
COARSE = 32  # instructions, more than a post has: what a tick could find amiss lies as near to a change


class Command(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        app = address_of(IMAGE, "app")
        taken, *layout = offsets(
            GDB, IMAGE, "(int)&((app_t *)0)->in.command", "sizeof(drive_command_t)",
            "(int)&((drive_command_t *)0)->mode", "(int)&((drive_command_t *)0)->request")
        assert layout == [COMMAND.size, 4, 5], layout
        cls.taken = app + taken

    def setUp(self):
        self.board = board.Board(IMAGE, BOARD, CLOCK)
        self.board.set_inputs(MIDDLE, MIDDLE, MIDDLE)
        self.board.boot()
        self.board.chip.usart.FIFO = len(TYPED)  # both lines in one pass
        self.board.tick(3)
        self.board.tick_to_take()
        self.board.tick(board.SLOW_TICKS - 1)  # one more tick, then the one that takes

    def memory(self, address, size):
        return bytes(self.board.core.uc.mem_read(address, size))

    def found(self):
        """What the last tick has taken."""
        target, mode, request = COMMAND.unpack(self.memory(self.taken, COMMAND.size))
        return f"{target} {mode} {request}"

    def tick_after(self, instructions):
        """The commands `speed` and `run` in one pass, and a tick that comes upon it after so many instructions."""
        self.board.chip.usart.receive_at_once(TYPED)
        self.board.tick(background=instructions)
        slept = self.board.core.asleep
        self.board.tick()
        return f"{'slept' if slept else 'interrupted'}\n{self.found()}"

    def look(self, instructions):
        """Whether the pass was interrupted or slept, and what a tick finds then."""
        how, _, found = in_a_copy(lambda: self.tick_after(instructions)).partition("\n")
        return how, found

    def looks(self):
        """(instructions, what a tick finds then), to the end of the background's pass."""
        instructions, how = 1, "interrupted"
        while how == "interrupted":
            how, found = self.look(instructions)
            yield instructions, found
            instructions += COARSE

    def test_a_tick_at_each_instruction_takes_what_was_posted_and_nothing_else(self):
        coarse = list(self.looks())
        changed = [at for (at, found), (_, before) in zip(coarse[1:], coarse) if found != before]
        posted = coarse[-1][1]
        step = int(posted.split()[0])
        self.assertGreater(step, 0)
        self.assertGreater(changed[0], 2 * COARSE)
        seen = []
        for at in sorted({at for change in changed for at in range(change - 2 * COARSE, change + COARSE)}):
            _, found = self.look(at)
            if found not in seen[-1:]:
                seen.append(found)
        self.assertEqual(seen, ["0 0 0", f"{step} 0 0", f"{step} 0 {RUN}"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
