# SPDX-License-Identifier: MIT
"""Model of an STM32G4's flash: its controller, and the pages at its end: six of the black box, two of the store. RM0440 3.3
and 3.7.

A page has 2 KiB. In a flash of one bank the core stands still until an erase or a programming has ended. One of two banks has
the factory's option bytes (DBANK = 1), the store in its second bank and the image in its first: the core goes on. Each erase
or programming is a step; in the step number `cut` power fails, and leaves half done what it was about to change. Half done
is, by chance for each double word, what it was, what it should become, or a mixture. A double word that the code cannot
correct is left to test_faults.py: the NMI that it raises comes within a block of instructions, and exceptions are taken
between two blocks here.
"""

import random

import g4
from registers import Block, Register, need

STORE_BYTES = 0x1000
KEPT_BYTES = 0x4000  # black box and store
PAGE = 0x800
UNIT = 8
ERASED = 2 ** 64 - 1
CYCLES_PER_S = 170e6
ERASE_CYCLES = round(24.5e-3 * CYCLES_PER_S)  # data sheet DS12589, at most
PROGRAM_CYCLES = round(85e-6 * CYCLES_PER_S)  # as long as a watchdog and a tick have to bear it
KEYS = (0x45670123, 0xCDEF89AB)
ERRORS = 0xC3FA
PROGERR, WRPERR = 1 << 3, 1 << 4
SR_OFFSET = 0x10
LOCK, OPTLOCK = 1 << 31, 1 << 30
PG, PER, STRT = 1, 2, 1 << 16
BANK_2 = 1 << 11
CACHES = 3 << 9
BOR_LEVEL, NO_PARITY = 7 << 8, 1 << 24  # of OPTR, RM0440 3.7.8
GOOD_OPTIONS = 0xFAEFF8AA | 4 << 8      # those of a new chip, with a brown-out reset at 2.8 V, parity, and no BOOT0 pin
BSY = 1 << 16


def store_of(facts):
    """The address of the store: the last pages of the flash."""
    return g4.FLASH + facts.flash_bytes - STORE_BYTES


def box_of(facts):
    """The address of the black box: the pages before those of the store."""
    return g4.FLASH + facts.flash_bytes - KEPT_BYTES


class PowerFails(Exception):
    """Within a step of the flash."""


class Flash(Block):
    """The controller. `units`: the double words of these pages by their place. It is busy for the next `busy` looks at its status, and
    for `lasting` ones behind each step; `deaf()` says whether it takes no key, `refuses` that it programs nothing."""

    def __init__(self, chip):
        self.chip = chip
        self.kept_address = box_of(chip.facts)
        self.dual_bank = chip.facts.dual_bank
        need(chip.facts.page_bytes == PAGE, "pages of another length than those of this model")
        self.first_page = (chip.facts.bank_bytes - KEPT_BYTES) // PAGE  # of the black box, in its bank
        self.ends = 0    # of the step that goes on beside the core
        self.units = {}  # that are not erased
        self.steps = 0
        self.cut = None
        self.chance = random.Random(1)
        self.busy = 0
        self.lasting = 0
        self.deaf = lambda: False
        self.refuses = False
        self.protected = False  # no page can be erased
        self._keys = []
        self._first = None  # of the two words of a double word
        super().__init__("FLASH", 0x40022000, {
            "ACR": (0x00, Register(0x40600, 0x1F0F, on_write=self._configure)),
            "KEYR": (0x08, Register(on_write=self._key)),
            "SR": (SR_OFFSET, Register(0, ERRORS | 1, self._status, self._clear)),
            "CR": (0x14, Register(LOCK | OPTLOCK, LOCK | STRT | 0x3FB | self._bank(), on_write=self._control)),
            "OPTR": (0x20, Register(GOOD_OPTIONS, 0)),
            "ECCR": (0x18, Register(0, 1 << 31, on_write=self._acknowledge)),
        })
        self.kept = Block("KEPT", self.kept_address, {
            f"{offset:#05x}": (offset, Register(0, on_read=self._reader(offset), on_write=self._writer(offset)))
            for offset in range(0, KEPT_BYTES, 4)})

    def load(self, address, data):
        """What is in these pages beside the image."""
        padded = data + b"\xFF" * (-len(data) % UNIT)
        for at in range(0, len(padded), UNIT):
            self.units[(address - self.kept_address + at) // UNIT] = int.from_bytes(padded[at:at + UNIT], "little")

    def content(self):
        """As (address, bytes), for another board with this flash."""
        return [(self.kept_address + unit * UNIT, value.to_bytes(UNIT, "little")) for unit, value in sorted(self.units.items())]

    def _bank(self):
        """The bit of CR that selects the store's bank."""
        return BANK_2 if self.dual_bank else 0

    def tear(self):
        """A double word was read whose bits are beyond correction: the NMI follows."""
        self["ECCR"] = 1 << 31

    def _acknowledge(self, value):
        self["ECCR"] &= ~value

    def _configure(self, value):
        need(not value & 3 << 11 or not value & CACHES, "a cache is emptied while it is on")
        self["ACR"] = value

    def _key(self, value):
        if self.deaf():
            return
        self._keys.append(value)
        need(tuple(self._keys) == KEYS[:len(self._keys)], "a wrong key: the flash is locked until reset")
        if len(self._keys) == len(KEYS):
            self["CR"] &= ~LOCK
            self._keys = []

    def _status(self):
        if self.chip.now < self.ends:
            self.chip.hold(self.base + SR_OFFSET, self["SR"] | BSY, self.ends)
            return self["SR"] | BSY
        if self.busy == 0:
            return self["SR"]
        self.busy -= 1
        return self["SR"] | BSY

    def _clear(self, value):
        self["SR"] &= ~value

    def _control(self, value):
        need(not self["CR"] & LOCK, "the flash is locked")
        self["CR"] = value & ~STRT | OPTLOCK
        if value & STRT:
            page = (value >> 3 & 0x7F) - self.first_page
            need(value & (PER | PG | BANK_2) == PER | self._bank() and page in range(KEPT_BYTES // PAGE),
                 "another page than those of black box and store is erased")
            if self.protected:
                self["SR"] |= WRPERR
                return
            first = page * PAGE // UNIT
            self._operate({unit: ERASED for unit in range(first, first + PAGE // UNIT)}, ERASE_CYCLES)

    def _reader(self, offset):
        def read():
            return self.units.get(offset // UNIT, ERASED) >> 8 * (offset % UNIT) & 0xFFFFFFFF
        return read

    def _writer(self, offset):
        def write(value):
            need(self["CR"] & ~OPTLOCK == PG, "the flash is written, and not set for programming")
            if offset % UNIT == 0:
                self._first = offset, value
            else:
                need(self._first is not None and self._first[0] == offset - 4, "half of a double word is programmed")
                self._program(offset // UNIT, value << 32 | self._first[1])
                self._first = None
        return write

    def _program(self, unit, value):
        if unit in self.units or self.refuses:
            self["SR"] |= PROGERR
        else:
            self._operate({unit: value}, PROGRAM_CYCLES)

    def _operate(self, changes, duration):
        need(not self.chip.timer.gates_on(), "the flash stops the core while the gates are on")
        need(not self["ACR"] & CACHES, "the caches would go on showing what was there")
        need(not self["SR"] & ERRORS, "an error of before is not cleared")
        need(self.chip.now >= self.ends, "the flash is still busy")
        fails = self.steps == self.cut
        self.steps += 1
        for unit, value in changes.items():
            before = self.units.get(unit, ERASED)
            self._keep(unit, self._half(before, value) if fails else value)
        if fails:
            raise PowerFails
        if self.dual_bank:
            self.ends = self.chip.now + duration
        else:
            self.chip.stand_still(duration)
        self["SR"] |= 1
        self.busy = self.lasting

    def _half(self, before, after):
        mask = self.chance.choice((0, ERASED, self.chance.getrandbits(64)))
        return before & ~mask | after & mask

    def _keep(self, unit, value):
        self.units[unit] = value
        if value == ERASED:
            del self.units[unit]
