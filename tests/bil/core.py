# SPDX-License-Identifier: MIT
"""The emulated Cortex-M4, and what its instructions cost.

The cost is the upper one of tools/bench/cycles.py with a refill of the pipeline behind each block, and no wait states: flash
and caches are not modelled. It is counted by blocks, so an access to a register is late by a part of its block at most.
Exceptions are taken between two blocks.
"""

import ctypes
import functools
import hashlib
import struct
import sys
from pathlib import Path

import unicorn
from unicorn import arm_const as arm
from unicorn.unicorn_py3.unicorn import uclib

import decisions
import elf
from flash import box_of
from g4 import FLASH, RAM
from registers import Bus, WrongAccess

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
from bench.blocks import Decoder  # noqa: E402
from bench.cycles import MODELS, block_cycles  # noqa: E402

PAGE = 0x1000
NEVER = 1 << 62
ACCESS_CYCLES = 8     # of a register, by way of the buses
EXCEPTION_CYCLES = 12  # its entry, and its return
EXC_RETURN = 0xFFFFFFF9  # to thread mode, main stack
WFI = b"\x30\xbf"
THREAD = 0x100           # the priority of what is no exception
IT_STATE = 0x0600FC00    # of XPSR: which of the next instructions an IT makes conditional
FRAME = [arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3,
         arm.UC_ARM_REG_R12, arm.UC_ARM_REG_LR, arm.UC_ARM_REG_PC, arm.UC_ARM_REG_XPSR]
REGISTERS = [*range(arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R12 + 1), *FRAME[5:], arm.UC_ARM_REG_SP]
M4 = next(model for model in MODELS if model.core == "cortex-m4")
COST_OF = ctypes.CFUNCTYPE(ctypes.c_uint16, ctypes.c_uint64, ctypes.c_uint32)
READ = ctypes.CFUNCTYPE(ctypes.c_uint64, ctypes.c_uint64, ctypes.c_uint32)
WRITE = ctypes.CFUNCTYPE(None, ctypes.c_uint64, ctypes.c_uint32, ctypes.c_uint64)


class Clock(ctypes.Structure):
    """core_clock.c: the time of the whole chip, in cycles of 170 MHz."""

    _fields_ = [("now", ctypes.c_int64), ("limit", ctypes.c_int64), ("cycle", ctypes.c_int64),
                ("stopped", ctypes.c_int64), ("flash", ctypes.c_uint64), ("stop", ctypes.c_void_p),
                ("cost_of", COST_OF), ("cost", ctypes.POINTER(ctypes.c_uint16)), ("halfwords", ctypes.c_uint64),
                ("access", ctypes.c_int64),
                ("held", ctypes.c_uint64), ("value", ctypes.c_uint64), ("until", ctypes.c_int64),
                ("read", READ), ("write", WRITE)]


class Page(ctypes.Structure):
    """core_clock.c: one of registers."""

    _fields_ = [("clock", ctypes.POINTER(Clock)), ("address", ctypes.c_uint64)]


def succeed(status):
    if status != unicorn.UC_ERR_OK:
        raise unicorn.UcError(status)


@functools.cache
def _decoded(flash):
    """Of an image, for all boards that run it."""
    return Decoder(flash), (ctypes.c_uint16 * (len(flash) // 2))()


class Core:
    """Unicorn has no exceptions of its own: entry and return are made here."""

    def __init__(self, image, chip, library, flashed=()):
        self.chip = chip
        self.image_size = box_of(chip.facts) - FLASH  # black box and store behind it are read as registers: flash.py
        self.ram_end = RAM + chip.facts.ram_bytes
        self.bus = chip.bus = Bus(chip.blocks)
        chip.memory = self._write_by_dma
        chip.hold, chip.look_again = self._hold, self._set_limit
        self.failure = None
        self.asleep = False
        self._limit = NEVER
        self._counting = False
        self.priority = THREAD
        self.taken = {}  # how many of each exception have been handled to their end
        # The mode for microcontrollers would be another core, an M33.
        self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self.uc.mem_map(FLASH, self.image_size, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        self.uc.mem_map(RAM, self.ram_end - RAM, unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE)
        self.uc.mem_write(FLASH, b"\xFF" * self.image_size)
        for address, data in elf.segments(image):
            self._load(address, data)
        for address, data in flashed:
            chip.power.flash.load(address, data)
        self.uc.hook_add(unicorn.UC_HOOK_MEM_INVALID, self._invalid)
        self._library = ctypes.CDLL(str(library))
        self._start_clock()
        self._map_registers()
        if decisions.RECORD:
            decisions.RECORD.watch(self.uc._uch, image, self._library, uclib, unicorn.UC_HOOK_CODE)
        stack, start = struct.unpack("<II", self.uc.mem_read(FLASH, 8))
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_PC, start)

    def ram(self):
        """All that it holds."""
        return bytes(self.uc.mem_read(RAM, self.ram_end - RAM))

    def set_ram(self, data):
        """As another run has left it."""
        self.uc.mem_write(RAM, data)

    def _write_by_dma(self, address, word):
        if address % 4 or not RAM <= address < self.ram_end:
            raise WrongAccess(f"the DMA writes to {address:#010x}, where there is no word of RAM")
        self.uc.mem_write(address, struct.pack("<I", word))

    def _load(self, address, data):
        facts = self.chip.facts
        if facts.dual_bank and address + len(data) > FLASH + facts.bank_bytes:
            raise ValueError("the image reaches into the bank of the store: the core would stand still while that is written")
        self.uc.mem_write(address, data)

    def _start_clock(self):
        """Unicorn's Python would call a function of Python only, which costs more than the emulation."""
        decoder, costs = _decoded(bytes(self.uc.mem_read(FLASH, self.image_size)))

        def cost_of(address, size):
            try:
                return block_cycles(M4, decoder.block(address - FLASH, size))[1] + M4.refill.high
            except Exception as failure:  # as in _guarded
                self.failure = self.failure or failure
                self.uc.emu_stop()
                return 1

        clock = self.chip.clock
        clock.flash = FLASH
        clock.cost, clock.halfwords = costs, len(costs)
        clock.cost_of = COST_OF(cost_of)
        clock.stop = ctypes.cast(uclib.uc_emu_stop, ctypes.c_void_p).value
        hook = self._in_c("core_clock_block")
        handle = ctypes.c_size_t()
        succeed(uclib.uc_hook_add(self.uc._uch, ctypes.byref(handle), unicorn.UC_HOOK_BLOCK, hook,
                                  ctypes.byref(clock), ctypes.c_uint64(1), ctypes.c_uint64(0)))

    def _in_c(self, name):
        return ctypes.cast(getattr(self._library, name), ctypes.c_void_p)

    def _map_registers(self):
        """Past unicorn's Python, as in _start_clock."""
        clock = self.chip.clock
        clock.access = ACCESS_CYCLES
        clock.read, clock.write = READ(self._read), WRITE(self._write)
        self._pages = [Page(ctypes.pointer(clock), address) for address in self.bus.pages(PAGE)]
        read, write = self._in_c("core_clock_read"), self._in_c("core_clock_write")
        for page in self._pages:
            succeed(uclib.uc_mmio_map(self.uc._uch, page.address, PAGE, read, ctypes.byref(page), write, ctypes.byref(page)))

    def _guarded(self, access, *arguments):
        """What goes wrong must not pass through the emulator: it is kept until that has stopped."""
        try:
            return access(*arguments)
        except Exception as failure:  # any: it is raised again by run()
            self.failure = self.failure or failure
            self.uc.emu_stop()
            return 0

    def _read(self, address, size):
        return self._guarded(self._do_read, address, size)

    def _write(self, address, size, value):
        self._guarded(self._do_write, address, size, value)

    def _hold(self, address, value, until=NEVER):
        """For a register that is being read: looks at it see this again before the time `until`, until something is due, or
        the image does something else."""
        if not self._counting:
            clock = self.chip.clock
            clock.held, clock.value, clock.until = address, value, until

    def _pass_access(self):
        if (now := self.chip.clock.now + ACCESS_CYCLES) < self._limit:
            self.chip.clock.now = now
        else:
            self.chip.advance(ACCESS_CYCLES)
            self._set_limit()

    def _do_read(self, address, size):
        self._pass_access()
        return self.bus.read(address, size)

    def _do_write(self, address, size, value):
        self._pass_access()
        if self.bus.write(address, size, value) in self.chip.timed:  # what is due may be another time now
            self._set_limit()

    def _invalid(self, _, kind, address, size, value, __):
        if address != EXC_RETURN & ~1:
            self.failure = self.failure or WrongAccess(
                f"access of {size} byte(s) to {address:#010x}, where there is nothing")
        return False

    def _set_limit(self):
        """The core goes on until something happens, or at once no further if an exception waits."""
        waits = self.chip.system.first(self.priority) is not None
        self._limit = self.chip.now if waits else min(self.chip.next_due(), self.chip.held)
        self.chip.clock.limit = NEVER if self._counting else self._limit

    def _emulate(self, instructions=0):
        """Until the clock stops it, or after so many instructions if given. Whether that was it."""
        self.chip.clock.stopped = 0
        program = self.uc.reg_read(arm.UC_ARM_REG_PC)
        self._counting = instructions > 0
        if instructions:
            self.uc.ctl_flush_tb()  # what has run before would not be counted
        self._set_limit()
        try:
            self.uc.emu_start(program | 1, EXC_RETURN & ~1, count=instructions)
        except unicorn.UcError as error:
            if not self.left() and self.failure is None:
                raise WrongAccess(f"{error} at {program:#010x}") from error
        if self.failure is not None:
            failure, self.failure = self.failure, None
            raise failure
        return bool(self.chip.clock.stopped)

    def alive(self):
        """A digest of all that the program can go on from: its registers, and the memory without what lies beyond the stack."""
        registers = [self.uc.reg_read(register) for register in REGISTERS]
        stack = self.uc.reg_read(arm.UC_ARM_REG_SP)
        return hashlib.sha256(struct.pack("<17I", *registers) + self.uc.mem_read(stack, self.ram_end - stack)).hexdigest()

    def left(self):
        """Whether an exception has come to its end."""
        return self.uc.reg_read(arm.UC_ARM_REG_PC) == EXC_RETURN & ~1

    def step(self, instructions):
        """So many instructions at most, and no exception; not beyond a sleep or the end of one."""
        self._emulate(instructions)
        last = self.uc.reg_read(arm.UC_ARM_REG_PC) - len(WFI)
        self.asleep = not self.left() and self.uc.mem_read(last, len(WFI)) == WFI

    def run(self, until=NEVER, once=False):
        """Until the core sleeps, or an exception has come to its end; to the time `until` at most; with `once` until one more
        has come upon it. Its number, or None. What is due at `until` or later has not happened then."""
        try:
            return self._run(until, once)
        finally:
            self.chip.held = NEVER

    def _run(self, until, once):
        while self.chip.now < until:
            self.chip.held = until
            self.chip.advance()
            exception = self.chip.system.take(self.priority)
            if exception is not None:
                self.handle(exception)
                if once:
                    return exception
                continue
            if not self._emulate():
                self.asleep = not self.left()
                return None
        return None

    def handle(self, exception, instructions=0, then=None):
        """Runs the handler that the vector table names, from entry to return, or so many instructions of it; with `then`,
        that happens behind these, and the handler goes on to its end. Whether it had come there before."""
        stack = self.uc.reg_read(arm.UC_ARM_REG_SP)
        frame = [self.uc.reg_read(register) for register in FRAME]
        pushed = stack - 32 & ~7
        self.uc.mem_write(pushed, struct.pack("<8I", *frame))
        before, self.priority = self.priority, self.chip.system.priority(exception)
        handled = self.chip.system.handled
        self.chip.clock.now += EXCEPTION_CYCLES
        self._enter(exception, pushed)
        if instructions:
            self.step(instructions)
        ended = self.left()
        if then is not None:
            then()
        if not ended and (then is not None or not instructions):
            self.run()
        self.chip.clock.now += EXCEPTION_CYCLES
        self.priority = before
        self.chip.system.handled = handled
        self.taken[exception] = self.taken.get(exception, 0) + 1
        frame = struct.unpack("<8I", self.uc.mem_read(pushed, 32))
        for register, value in zip(FRAME, frame):
            self.uc.reg_write(register, value)
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        return ended

    def _enter(self, exception, stack):
        vector = self.chip.system["SCB_VTOR"] + 4 * exception
        self.chip.system.handled = exception
        handler, = struct.unpack("<I", self.uc.mem_read(vector, 4))
        self.uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.uc.reg_write(arm.UC_ARM_REG_LR, EXC_RETURN)
        # A block may end between an IT, at the end of a page, and what it makes conditional: that is not the handler.
        self.uc.reg_write(arm.UC_ARM_REG_XPSR, self.uc.reg_read(arm.UC_ARM_REG_XPSR) & ~IT_STATE)
        self.uc.reg_write(arm.UC_ARM_REG_PC, handler)

    def fault_without_stack(self, exception, instructions):
        """The handler's first instructions, with the stack pointer at the very end of the RAM."""
        self._enter(exception, RAM)
        self.step(instructions)
