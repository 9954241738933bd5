# SPDX-License-Identifier: MIT
"""The host's side of semihosting (hal/mps2/semihost.c), with files that are bytes in memory."""

import struct

from unicorn.arm_const import UC_ARM_REG_PC, UC_ARM_REG_R0, UC_ARM_REG_R1

from .image import BenchError

OPEN, CLOSE, WRITE0, WRITE, READ, EXIT = 0x01, 0x02, 0x04, 0x05, 0x06, 0x20
BREAKPOINT_BYTES = 2
FAILED = 0xFFFFFFFF


class Semihost:
    def __init__(self, files, on_read=lambda _bytes: None):
        self.files = dict(files)  # what the program reads, and later what it wrote
        self.text = ""
        self.exit_code = None
        self._open = []  # [name, place] by handle − 1
        self._on_read = on_read

    def interrupt(self, core, _number, _data):
        """The hook of the core's exceptions: the only one that may come is the breakpoint."""
        pc = core.reg_read(UC_ARM_REG_PC)
        if bytes(core.mem_read(pc, BREAKPOINT_BYTES)) != b"\xab\xbe":
            raise BenchError(f"the program ran into an exception at {pc:#x}")
        operation = core.reg_read(UC_ARM_REG_R0)
        answer = self._do(core, operation, core.reg_read(UC_ARM_REG_R1))
        core.reg_write(UC_ARM_REG_R0, answer)
        core.reg_write(UC_ARM_REG_PC, (pc + BREAKPOINT_BYTES) | 1)

    def _do(self, core, operation, argument):
        if operation == WRITE0:
            self.text += string(core, argument)
            return 0
        words = struct.unpack("<3I", core.mem_read(argument, 12))
        actions = {OPEN: self._open_file, READ: self._read, WRITE: self._write,
                   CLOSE: lambda _core, _handle, *_: 0, EXIT: self._exit}
        return actions[operation](core, *words)

    def _open_file(self, core, name_at, mode, length):
        name = core.mem_read(name_at, length).decode()
        if mode >= 4:  # "w"
            self.files[name] = bytearray()
        elif name not in self.files:
            return FAILED
        self._open.append([name, 0])
        return len(self._open)

    def _read(self, core, handle, to, size):
        name, place = self._open[handle - 1]
        chunk = self.files[name][place:place + size]
        core.mem_write(to, bytes(chunk))
        self._open[handle - 1][1] += len(chunk)
        self._on_read(len(chunk))
        return size - len(chunk)

    def _write(self, core, handle, at, size):
        self.files[self._open[handle - 1][0]] += core.mem_read(at, size)
        return 0

    def _exit(self, core, _reason, code, _):
        self.exit_code = code
        core.emu_stop()
        return 0


def string(core, at):
    text = bytearray()
    while (byte := core.mem_read(at + len(text), 1)[0]) != 0:
        text.append(byte)
    return text.decode()
