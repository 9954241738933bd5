# SPDX-License-Identifier: MIT
"""As much of an ELF file as the tests need: what a programmer writes into the flash, and where variables are."""

import struct
import subprocess

_HEADER = struct.Struct("<16sHHIIIIIHHHHHH")
_PROGRAM = struct.Struct("<IIIIIIII")
_LOAD = 1


def segments(path):
    """(address, bytes) of all that is loaded, at the addresses where it is stored."""
    data = path.read_bytes()
    if data[:6] != b"\x7fELF\x01\x01":
        raise ValueError(f"{path} is no 32-bit little-endian ELF file")
    header = _HEADER.unpack_from(data)
    start, size, count = header[5], header[9], header[10]
    for k in range(count):
        kind, offset, _, physical, length, *_ = _PROGRAM.unpack_from(data, start + k * size)
        if kind == _LOAD and length:
            yield physical, data[offset:offset + length]


def _output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def offsets(gdb, image, *members):
    """Of members of the types in the image's debug information."""
    asked = [part for one in members for part in ("-ex", f"output/d {one}", "-ex", "echo \\n")]
    return [int(number) for number in _output(gdb, "-nx", "-batch", *asked, image)]


def address_of(image, name):
    """Of a static variable. Where the image is linked in parts, its name goes on behind a point."""
    words = _output("arm-none-eabi-nm", image)
    at = next(k for k, word in enumerate(words) if word.partition(".")[0] == name)
    return int(words[at - 2], 16)
