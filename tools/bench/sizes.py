# SPDX-License-Identifier: MIT
"""What an image is made of: code by source file, constants and variables by name.

Optimised at the link, an image has no modules any more: its map knows one object file. Code goes by the
line that each address comes from, so a function that was inlined counts to its own file; the debug
information says nothing of the kind about constants and variables, which go by name.
"""

from collections import Counter
from dataclasses import dataclass

from .profile import LIBRARY, owner, short

CORE = "firmware/"
STATE = "app"  # of hal/mps2/main.c: the drive, its frames and the command
HALFWORD = 2


@dataclass(frozen=True)
class Sizes:
    code: dict       # bytes by source file
    constants: dict  # bytes by name
    variables: dict
    sections: dict   # bytes of .text, .rodata, .data, .bss
    state: int

    @property
    def core_code(self):
        """The core's code and all that it may have of the compiler's library."""
        return sum(size for file, size in self.code.items() if file.startswith((CORE, LIBRARY)))

    @property
    def core(self):
        """Code and tables; of the constants all, the few of the replay included."""
        return self.core_code + self.sections[".rodata"]


def measure(image):
    sections = {name: image.sections.get(name, (0, 0))[1]
                for name in (".text", ".rodata", ".data", ".bss")}
    return Sizes(code_by_file(image), by_name(image, ".rodata"),
                 by_name(image, ".data") | by_name(image, ".bss"), sections,
                 image.symbol(STATE).size)


def code_by_file(image):
    start, size = image.sections[".text"]
    chains = image.frames(range(start, start + size, HALFWORD))
    code = Counter()
    for chain in chains.values():
        frame = owner(chain)
        code[short(frame.file) if frame else LIBRARY] += HALFWORD
    return dict(code.most_common())


def by_name(image, section):
    start, size = image.sections.get(section, (0, 0))
    found = Counter({one.name.partition(".")[0]: one.size for one in image.symbols
                     if start <= one.address < start + size})
    if size > found.total():
        found["(text and padding)"] = size - found.total()
    return dict(found.most_common())
