# SPDX-License-Identifier: MIT
"""gate.no_float: the firmware has no floating point, no allocation and no stdio.

Read three times: in the text (comments and strings left out); in the compiled libraries,
which may call nothing but themselves, the HAL and the compiler's memory helpers; and in their
debug information, which says of each type what it is, whatever its name.
"""

import argparse
import re
import subprocess
from pathlib import Path

import sources

WORDS = re.compile(
    r"\b(float|double|_Float\d+x?|_Decimal\d+x?|__fp16|__bf16|__float\d+|__ibm128|float\d*_t|double_t"
    r"|_Complex|_Imaginary|malloc|calloc|realloc|aligned_alloc|alloca|free"
    r"|v?(?:f|s|sn|d|as)?printf|puts|fputs|putchar|fopen|fwrite|FILE)\b")
# 1.5, 1., .5, 1e3, 0x1p3
NUMBER = re.compile(
    r"(?<![\w.])(\d+\.\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+"
    r"|0[xX][0-9a-fA-F.]+[pP][+-]?\d+)")
ALLOWED_CALLS = re.compile(
    r"hal_\w+|mem(?:cpy|set|move|cmp)|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail"
    r"|__aeabi_u?[il]div(?:mod)?|__aeabi_u?ldivmod|__aeabi_l(?:mul|lsl|lsr|asr)|__aeabi_mem\w+")
# A base type, as readelf says it: what it is, and its name.
BASE_TYPE = re.compile(r"DW_AT_encoding[^(\n]*\(([^)\n]*)\)\n[^\n]*DW_AT_name[^\n]*: ([^:\n]+)\n")
FLOATING = re.compile(r"float|complex|imaginary")
OF_STDDEF = "long double"  # in max_align_t; written out it is a word of the text


def in_text(root):
    for path in sources.files(root, "firmware/*.c", "firmware/*.h"):
        text = sources.strip((root / path).read_text(encoding="utf-8"))
        for number, line in enumerate(text.splitlines(), 1):
            for match in [*WORDS.finditer(line), *NUMBER.finditer(line)]:
                yield f"{path}:{number}: {match.group(1)}"


def symbols(library, option):
    listed = subprocess.run(["nm", "-A", option, library],
                            check=True, capture_output=True, text=True).stdout
    return [(line.split(":")[-2], line.split()[-1]) for line in listed.splitlines()]


def in_objects(libraries):
    own = {name for library in libraries for _, name in symbols(library, "--defined-only")}
    for library in libraries:
        for member, name in symbols(library, "--undefined-only"):
            if name not in own and not ALLOWED_CALLS.fullmatch(name):
                yield f"{Path(library).name}({member}) calls {name}"


def in_debug_information(libraries):
    for library in libraries:
        listed = subprocess.run(["readelf", "--debug-dump=info", library],
                                check=True, capture_output=True, text=True).stdout
        types = set(BASE_TYPE.findall(listed))
        if not types:
            yield f"{Path(library).name} has no debug information, which would say what its types are"
        for encoding, name in sorted(types):
            if FLOATING.search(encoding) and name != OF_STDDEF:
                yield f"{Path(library).name} uses {name}: {encoding}"


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("libraries", nargs="*", help="compiled firmware libraries")
args = parser.parse_args()
sources.finish("no_float", [*in_text(args.root), *in_objects(args.libraries),
                           *in_debug_information(args.libraries)],
               "The firmware computes in integers and owns all its memory: use fx.h.")
