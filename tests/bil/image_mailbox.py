# SPDX-License-Identifier: MIT
"""The command mailbox of an image."""

import struct

from elf import address_of, offsets

SLOT = struct.Struct("<iBB2xI")  # command_slot_t


class Mailbox:
    def __init__(self, board, image, gdb):
        self.board = board
        self.address = address_of(image, "app") + offsets(gdb, image, "(int)&((app_t *)0)->mailbox")[0]

    def command(self):
        """Target, mode and request that the next tick finds."""
        data = bytes(self.board.core.uc.mem_read(self.address, 2 * SLOT.size + 4))
        in_force = data[-4] & 1
        return SLOT.unpack_from(data, in_force * SLOT.size)[:3]
