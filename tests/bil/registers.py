# SPDX-License-Identifier: MIT
"""Registers of a chip as tables, and what is wrong about an access to them.

An access to a block without a clock is not wrong on the chip, and nobody says so: it does not act.
"""


class WrongAccess(Exception):
    """The image did something that the model, or the reference manual, does not allow."""


def bit(value, number):
    return value >> number & 1


def need(holds, otherwise):
    if not holds:
        raise WrongAccess(otherwise)


class Register:
    """32 bits, of which `writable` can be set; hooks replace a read, or follow or replace a write."""

    __slots__ = ("value", "reset", "writable", "on_read", "on_write")

    def __init__(self, reset=0, writable=0xFFFFFFFF, on_read=None, on_write=None):
        self.value = self.reset = reset
        self.writable = writable
        self.on_read = on_read    # () → value
        self.on_write = on_write  # (value) → None; it stores what is to be kept


class Block:
    """The registers of one peripheral by name. `clocked` says whether it has its clock."""

    def __init__(self, name, base, registers, clocked=None):
        self.name = name
        self.base = base
        self.clocked = clocked or (lambda: True)
        self._by_name = {key: register for key, (_, register) in registers.items()}
        self.by_address = {base + offset: (key, register)
                           for key, (offset, register) in registers.items()}

    def __getitem__(self, key):
        return self._by_name[key].value

    def __setitem__(self, key, value):
        self._by_name[key].value = value

    def register(self, key):
        return self._by_name[key]


class Bus:
    """All blocks, found by address."""

    def __init__(self, blocks):
        self._found = {address: (block, key, register) for block in blocks
                       for address, (key, register) in block.by_address.items()}

    def pages(self, size):
        return sorted({address - address % size for address in self._found})

    def _find(self, address, size, what):
        found = self._found.get(address)
        if found is None:
            raise WrongAccess(f"{what} of {address:#010x}, which has no model")
        block, key, register = found
        if size != 4:
            raise WrongAccess(f"{what} of {size} byte(s) of {block.name}_{key}, which takes words")
        return block, key, register

    def read(self, address, size):
        block, _, register = self._find(address, size, "read")
        if not block.clocked():
            return 0
        return register.value if register.on_read is None else register.on_read()

    def write(self, address, size, value):
        """The block, if it has taken notice."""
        block, key, register = self._find(address, size, "write")
        if not block.clocked():
            return None
        reserved = value & ~(register.writable | register.reset)
        if reserved:
            raise WrongAccess(f"write of {value:#010x} to {block.name}_{key} sets bits {reserved:#x}")
        if register.on_write is None:
            register.value = value
        else:
            register.on_write(value)
        return block
