# SPDX-License-Identifier: MIT
"""An emulated core that runs a whole image and writes down the way of one function's every call."""

import struct

from unicorn import UC_ARCH_ARM, UC_HOOK_BLOCK, UC_HOOK_INTR, UC_MODE_THUMB, Uc, UcError
from unicorn import arm_const as arm

from .image import BenchError
from .semihost import Semihost

# By model, because the emulator's M-class mode stands for a Cortex-M33 whatever the image is for.
CPU = {
    "cortex-m0plus": arm.UC_CPU_ARM_CORTEX_M0,  # same instructions; its cycles are cycles.py's
    "cortex-m3": arm.UC_CPU_ARM_CORTEX_M3,
    "cortex-m4": arm.UC_CPU_ARM_CORTEX_M4,
}
FLASH, FLASH_BYTES = 0x00000000, 256 * 1024  # hal/mps2/mps2.ld
RAM, RAM_BYTES = 0x20000000, 16 * 1024
PAINT = b"\xa5"


class Trails:
    """The blocks that each call of the function at `entry` ran through, and the stack it took.

    Blocks and not single instructions, because the emulator's hook for those leaves out what an
    IT block skips, though the core fetches it and spends a cycle on it. The blocks of `caller`, a
    range of addresses, are none of it: they run without a hook, which is most of the time saved.
    """

    def __init__(self, core, entry, caller):
        self.calls = []   # a trail's number for each call
        self.trails = {}  # tuple of block addresses, the last one where it returns to: its number
        self.sizes = {}   # bytes by block address
        self.stack_bytes = 0
        self._entry = entry
        self._trail = None
        self._back = None
        self._listen(core, FLASH, caller.start - 1)
        self._listen(core, caller.stop, FLASH + FLASH_BYTES)
        core.ctl_flush_tb()

    def _listen(self, core, first, last):
        core.hook_add(UC_HOOK_BLOCK, self._block, begin=first, end=last)

    def _block(self, core, address, size, _data):
        if self._trail is None:
            if address != self._entry:
                return
            self._begin(core)
        self._trail.append(address)
        if address == self._back:
            self._end(core)
        elif self.sizes.setdefault(address, size) != size:
            raise BenchError(f"the block at {address:#x} has two sizes")

    def _begin(self, core):
        self._trail = []
        back = core.reg_read(arm.UC_ARM_REG_LR) & ~1
        if self._back is None:
            self._listen(core, back, back)  # of the caller, which is not translated from there on yet
        elif back != self._back:
            raise BenchError(f"the function at {self._entry:#x} is called from two places")
        self._back = back
        self._free = core.reg_read(arm.UC_ARM_REG_SP) - RAM  # the stack lies at the RAM's bottom
        core.mem_write(RAM, PAINT * self._free)

    def _end(self, core):
        used = len(core.mem_read(RAM, self._free).lstrip(PAINT))
        self.stack_bytes = max(self.stack_bytes, used)
        self.calls.append(self.trails.setdefault(tuple(self._trail), len(self.trails)))
        self._trail = None


def run(cpu, content, entry, caller, files, on_read=lambda _bytes: None):
    """Runs the image from its reset vector to its exit; (Trails of `entry`, which `caller` calls, Semihost)."""
    core = Uc(UC_ARCH_ARM, UC_MODE_THUMB)
    core.ctl_set_cpu_model(CPU[cpu])
    core.mem_map(FLASH, FLASH_BYTES)
    core.mem_map(RAM, RAM_BYTES)
    core.mem_write(FLASH, content)
    host = Semihost(files, on_read)
    core.hook_add(UC_HOOK_INTR, host.interrupt)
    trails = Trails(core, entry, caller)
    stack, reset = struct.unpack_from("<2I", content)
    core.reg_write(arm.UC_ARM_REG_SP, stack)
    try:
        core.emu_start(reset | 1, FLASH + FLASH_BYTES)
    except UcError as error:
        pc = core.reg_read(arm.UC_ARM_REG_PC)
        raise BenchError(f"the program fails at {pc:#x}: {error}") from error
    return trails, host
