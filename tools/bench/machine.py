# SPDX-License-Identifier: MIT
"""An emulated core that runs a whole image and writes down the way of one function's every call."""

import ctypes
import functools
import struct
import subprocess
import tempfile
from pathlib import Path

from unicorn import UC_ARCH_ARM, UC_ERR_OK, UC_HOOK_BLOCK, UC_HOOK_INTR, UC_MODE_THUMB, Uc, UcError
from unicorn import arm_const as arm
from unicorn.unicorn_py3.unicorn import uc_hook_h, uclib

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
BLOCK = struct.Struct("<2I")  # address, bytes


class Noted(ctypes.Structure):
    """As trail_t in trail.c."""

    BLOCKS_MAX = 1 << 16
    CALLBACK = ctypes.CFUNCTYPE(None)
    _fields_ = (("entry", ctypes.c_uint32), ("back", ctypes.c_uint32), ("is_open", ctypes.c_uint32),
                ("count", ctypes.c_uint32), ("begin", CALLBACK), ("end", CALLBACK),
                ("blocks", ctypes.c_uint32 * 2 * BLOCKS_MAX))


@functools.cache
def native_hook():
    """note_block() of trail.c, which is compiled for it."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "trail.so"
        try:
            subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", library, Path(__file__).with_name("trail.c")], check=True,
                           capture_output=True, text=True)
        except (OSError, subprocess.CalledProcessError) as error:
            raise BenchError(f"trail.c: cc does not compile it: {getattr(error, 'stderr', error)}") from error
        return ctypes.CDLL(str(library)).note_block


class Trails:
    """The blocks that each call of the function at `entry` ran through, and the stack it took.

    Blocks and not single instructions, because the emulator's hook for those leaves out what an
    IT block skips, though the core fetches it and spends a cycle on it. The blocks of `caller`, a
    range of addresses, are none of it: they run without a hook.
    """

    def __init__(self, core, entry, caller):
        self.calls = []   # a trail's number for each call
        self.trails = {}  # tuple of block addresses, the last one where it returns to: its number
        self.sizes = {}   # bytes by block address
        self.stack_bytes = 0
        self.error = None  # what ended the run
        self._core = core
        self._numbers = {}  # blocks as noted: number of the trail
        self._noted = Noted(entry=entry, begin=Noted.CALLBACK(self._guarded(self._begin)),
                            end=Noted.CALLBACK(self._guarded(self._end)))
        self._listen(FLASH, caller.start - 1)
        self._listen(caller.stop, FLASH + FLASH_BYTES)
        core.ctl_flush_tb()

    def _listen(self, first, last):
        """As Uc.hook_add(), which takes Python functions alone."""
        status = uclib.uc_hook_add(self._core._uch, ctypes.byref(uc_hook_h()), UC_HOOK_BLOCK,
                                   ctypes.cast(native_hook(), ctypes.c_void_p), ctypes.addressof(self._noted), first, last)
        if status != UC_ERR_OK:
            raise UcError(status)

    def _guarded(self, do):
        """An exception cannot pass through the emulator: it ends the run."""
        def guarded():
            try:
                do()
            except Exception as error:  # noqa: BLE001: raised again by run()
                self.error = error
                self._core.emu_stop()
        return guarded

    def _begin(self):
        back = self._core.reg_read(arm.UC_ARM_REG_LR) & ~1
        if not self._noted.back:
            self._listen(back, back)  # of the caller, which is not translated from there on yet
        elif back != self._noted.back:
            raise BenchError(f"the function at {self._noted.entry:#x} is called from two places")
        self._noted.back = back
        self._free = self._core.reg_read(arm.UC_ARM_REG_SP) - RAM  # the stack lies at the RAM's bottom
        self._core.mem_write(RAM, PAINT * self._free)

    def _end(self):
        used = len(self._core.mem_read(RAM, self._free).lstrip(PAINT))
        self.stack_bytes = max(self.stack_bytes, used)
        if self._noted.count > Noted.BLOCKS_MAX:
            raise BenchError(f"a call of the function at {self._noted.entry:#x} has more than {Noted.BLOCKS_MAX} blocks")
        noted = ctypes.string_at(self._noted.blocks, 8 * self._noted.count)
        if noted not in self._numbers:
            self._numbers[noted] = self._new(list(BLOCK.iter_unpack(noted)))
        self.calls.append(self._numbers[noted])

    def _new(self, blocks):
        """The number of a way that no call before has taken."""
        for address, size in blocks[:-1]:
            if self.sizes.setdefault(address, size) != size:
                raise BenchError(f"the block at {address:#x} has two sizes")
        return self.trails.setdefault(tuple(address for address, _ in blocks), len(self.trails))


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
    if trails.error:
        raise trails.error
    return trails, host
