# SPDX-License-Identifier: MIT
"""As much of an ELF file as the test needs: what a programmer writes into the flash."""

import struct

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
