# SPDX-License-Identifier: MIT
"""An ELF image, read with the cross binutils: its bytes, symbols and source positions."""

import bisect
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

PREFIX = "arm-none-eabi-"


class BenchError(Exception):
    """One line for the user: what is wrong, and what was expected."""


def binutil(name, *arguments, text=None):
    """The output of a cross tool; `text` is what it reads."""
    command = [PREFIX + name, *map(str, arguments)]
    try:
        run = subprocess.run(command, input=text, capture_output=True, text=True)
    except FileNotFoundError as error:
        raise BenchError(f"there is no {command[0]}; run tools/dev setup") from error
    if run.returncode:
        raise BenchError(f"{command[0]}: {run.stderr.strip()}")
    return run.stdout


@dataclass(frozen=True)
class Symbol:
    name: str
    address: int
    size: int
    kind: str  # of nm: T code, R constant, D initialised, B zero
    file: str  # where it is defined, or "" (libraries without debug information)

    @property
    def addresses(self):
        return range(self.address, self.address + self.size)


@dataclass(frozen=True)
class Frame:
    """A source position: a function, and the file and line in it."""

    function: str
    file: str
    line: str


class Image:
    def __init__(self, path):
        self.path = Path(path)
        if not self.path.is_file():
            raise BenchError(f"{path}: no such image; build it with "
                             f"`tools/dev build {self.path.parent.name}`")

    @cached_property
    def content(self):
        """The bytes of the flash, which begins at address 0."""
        with tempfile.NamedTemporaryFile() as flat:
            binutil("objcopy", "-O", "binary", self.path, flat.name)
            return Path(flat.name).read_bytes()

    @cached_property
    def symbols(self):
        """Functions and objects in the order of their addresses."""
        found = []
        for line in binutil("nm", "-n", "-S", "-l", self.path).splitlines():
            words, _, where = line.partition("\t")
            fields = words.split()
            if len(fields) == 4 and fields[2].upper() in "TWRDB":
                address, size, kind, name = fields
                found.append(Symbol(name, int(address, 16) & ~1, int(size, 16), kind.upper(),
                                    where.rpartition(":")[0]))
        return found

    @cached_property
    def sections(self):
        """(address, bytes) of each section that lies in the target's memory, by name."""
        lines = [line.split() for line in binutil("size", "-A", self.path).splitlines()]
        return {words[0]: (int(words[2]), int(words[1])) for words in lines
                if len(words) == 3 and words[0].startswith(".") and not is_debug(words[0])}

    @cached_property
    def _all_names(self):
        """Addresses of all names. In the compiler's library some have no size: second names of what has one, and
        functions written in assembly language."""
        lines = [line.split() for line in binutil("nm", "-n", self.path).splitlines()]
        return {words[2]: int(words[0], 16) & ~1 for words in lines if len(words) == 3}

    @cached_property
    def _names_by_address(self):
        found = {}
        for name, address in self._all_names.items():
            found.setdefault(address, []).append(name)
        return found

    def names_at(self, name):
        """All names at the address of a name; none if it is not linked."""
        return self._names_by_address.get(self._all_names.get(name), [])

    def has(self, name):
        """Whether anything of exactly that name is linked."""
        return name in self._all_names

    def symbol(self, name):
        """The function or object of that name; the linker may have given a static one a suffix."""
        for symbol in self.symbols:
            if symbol.name == name or symbol.name.startswith(name + "."):
                return symbol
        address = self._all_names.get(name)
        for symbol in self.symbols:
            if symbol.address == address:
                return symbol
        if address is not None:
            behind = min(other for other in self._all_names.values() if other > address)
            return Symbol(name, address, behind - address, "T", "")
        raise BenchError(f"{self.path}: no symbol '{name}'; expected an image of hal/mps2")

    @cached_property
    def _functions(self):
        functions = [symbol for symbol in self.symbols if symbol.kind in "TW"]
        return [symbol.address for symbol in functions], functions

    def function_at(self, address):
        """The function that the linker put there, or None."""
        addresses, functions = self._functions
        at = bisect.bisect_right(addresses, address) - 1
        return functions[at] if at >= 0 else None

    def frames(self, addresses):
        """Source positions by address: the innermost inlined function first."""
        out = binutil("addr2line", "-e", self.path, "-f", "-i", "-a",
                      text="\n".join(map(hex, addresses)))
        found, chain, function = {}, None, None
        for line in out.splitlines():
            if line.startswith("0x"):
                chain = found[int(line, 16)] = []
                function = None
            elif function is None:
                function = line
            else:
                chain.append(Frame(function, *position(line)))
                function = None
        return found


def position(text):
    """(file, line) of addr2line's FILE:LINE, which may have a remark behind it."""
    file, _, line = text.split(" (")[0].rpartition(":")
    return ("" if file == "??" else file), line


def is_debug(section):
    return section.startswith((".debug", ".comment", ".ARM.attributes"))
