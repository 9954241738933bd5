# SPDX-License-Identifier: MIT
"""The decisions of the board's own code in an image, and which way each has gone while it was emulated.

A decision is an instruction that does one thing or another: a conditional branch, cbz, cbnz, or the `it` before
conditional instructions. With `--branches FILE` on a test's command line it writes there which of them it has seen go which
way; tools/evidence/board.py asks for both ways of each.
"""

import atexit
import ctypes
import functools
import hashlib
import json
import mmap
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from unicorn import arm_const as arm

OWN = re.compile(r"hal/stm32g4/(\w+\.[ch])$")
ON_A_PC = {"codes.c", "led.c"}  # evidence.coverage asks for these
CONDITIONS = ("eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le")
DECISION = re.compile(rf"^ *([0-9a-f]+):\t((?:b|it[te]*\t)({'|'.join(CONDITIONS)})\b|cb(n?)z\tr(\d))", re.MULTILINE)
IS_ZERO, IS_NOT_ZERO = len(CONDITIONS), len(CONDITIONS) + 1
READ = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(ctypes.c_uint32))


@dataclass(frozen=True)
class Decision:
    """`where`: (function, file of the project, line), the innermost first, of what was inlined into what."""

    address: int
    condition: int  # of CONDITIONS, or whether a register is zero
    register: int
    where: tuple


class Seen(ctypes.Structure):
    """core_clock.c: a decision, and how often it was found so and otherwise."""

    _fields_ = [("read", ctypes.c_void_p), ("register_", ctypes.c_int32), ("condition", ctypes.c_int32),
                ("counts", ctypes.c_uint64 * 2)]


def places(image, addresses):
    """Of each address the functions and lines, the innermost first."""
    said = subprocess.run(["arm-none-eabi-addr2line", "-a", "-i", "-f", "-e", image], check=True, capture_output=True, text=True,
                          input="".join(f"{address:#x}\n" for address in addresses)).stdout
    for block in re.split(r"^0x[0-9a-f]+\n", said, flags=re.MULTILINE)[1:]:
        lines = block.splitlines()
        yield tuple((function, *re.sub(r" \(discriminator \d+\)$", "", place).rsplit(":", 1))
                    for function, place in zip(lines[::2], lines[1::2]))


@functools.cache
def listed(image):
    """The decisions that the lines of the board's own files make, by address."""
    shown = subprocess.run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", image], check=True, capture_output=True,
                           text=True).stdout
    found = list(DECISION.finditer(shown))
    decisions = []
    for match, where in zip(found, places(image, [int(match[1], 16) for match in found]), strict=True):
        own = OWN.search(where[0][1])
        if own and own[1] not in ON_A_PC:
            frames = tuple((function, OWN.search(file)[0], int(line)) for function, file, line in where if OWN.search(file))
            condition = CONDITIONS.index(match[3]) if match[3] else IS_NOT_ZERO if match[4] else IS_ZERO
            register = arm.UC_ARM_REG_R0 + int(match[5]) if match[5] else arm.UC_ARM_REG_CPSR
            decisions.append(Decision(int(match[1], 16), condition, register, frames))
    return decisions


def fingerprint(image):
    return hashlib.sha256(Path(image).read_bytes()).hexdigest()


class Record:
    """Of one process and its copies (copies.py), which see the same memory."""

    def __init__(self, path):
        self.path, self.images = path, {}
        atexit.register(self.write)

    def of(self, image):
        if image not in self.images:
            shared = mmap.mmap(-1, max(ctypes.sizeof(Seen) * len(listed(image)), 1))
            self.images[image] = (Seen * len(listed(image))).from_buffer(shared)
        return self.images[image]

    def watch(self, emulator, image, library, uclib, kind):
        """Before it has run: unicorn puts the calls into the code that it makes."""
        image = Path(image)
        hook = ctypes.cast(library.core_clock_decision, ctypes.c_void_p)
        for decision, seen in zip(listed(image), self.of(image), strict=True):
            seen.read = ctypes.cast(uclib.uc_reg_read, ctypes.c_void_p).value
            seen.register_, seen.condition = decision.register, decision.condition
            handle = ctypes.c_size_t()
            status = uclib.uc_hook_add(emulator, ctypes.byref(handle), kind, hook, ctypes.byref(seen),
                                       ctypes.c_uint64(decision.address), ctypes.c_uint64(decision.address))
            if status != 0:
                raise RuntimeError(f"unicorn takes no hook at {decision.address:#x}: {status}")

    def write(self):
        record = {fingerprint(image): {f"{decision.address:#x}": [int(count) for count in seen.counts]
                                       for decision, seen in zip(listed(image), self.of(image))}
                  for image in self.images}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def asked():
    """The record that the command line asks for, without the option there; None if it does not."""
    if "--branches" not in sys.argv:
        return None
    at = sys.argv.index("--branches")
    path = Path(sys.argv[at + 1])
    del sys.argv[at:at + 2]
    return Record(path)


RECORD = asked()
