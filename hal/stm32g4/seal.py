# SPDX-License-Identifier: MIT
"""Writes the CRC-32 of an image behind it.

seal.py ELF FIRST: FIRST is the address of its first byte. The section .checksum holds the number of words before the CRC, and the CRC (image.c). All that is loaded lies in one
piece from the first address on, so that a programmer leaves no byte to chance.
"""

import struct
import sys
import zlib
from pathlib import Path

HEADER = struct.Struct("<16sHHIIIIIHHHHHH")
PROGRAM = struct.Struct("<IIIIIIII")
SECTION = struct.Struct("<IIIIIIIIII")
SEAL = struct.Struct("<II")
WORD_BYTES = 4
LOAD = 1


def fail(message):
    sys.exit(f"seal.py: {message}")


def seal_place(elf, header):
    """Offset in the file, and address, of the seal."""
    _, _, _, _, _, _, sections, _, _, _, _, size, count, names = header
    rows = [SECTION.unpack_from(elf, sections + k * size) for k in range(count)]
    for row in rows:
        at = rows[names][4] + row[0]
        if elf[at:elf.index(0, at)] == b".checksum":
            return row[4], row[3]
    return fail("there is no section .checksum")


def loaded(elf, header, first):
    """All that is loaded, from the address `first` on."""
    _, _, _, _, _, programs, _, _, _, size, count, *_ = header
    image = b""
    rows = (PROGRAM.unpack_from(elf, programs + k * size) for k in range(count))
    for kind, offset, _, address, length, *_ in sorted(rows, key=lambda row: row[3]):
        if kind == LOAD and length:
            if address != first + len(image):
                fail(f"a gap ends at {address:#010x}")
            image += elf[offset:offset + length]
    return image


def main(path, first):
    elf = bytearray(path.read_bytes())
    header = HEADER.unpack_from(elf)
    offset, address = seal_place(elf, header)
    words, _ = SEAL.unpack_from(elf, offset)
    image = loaded(elf, header, first)
    if words * WORD_BYTES != address + WORD_BYTES - first or len(image) != words * WORD_BYTES + WORD_BYTES:
        fail("the seal is not at the end of the image")
    crc = zlib.crc32(image[:words * WORD_BYTES])
    SEAL.pack_into(elf, offset, words, crc)
    path.write_bytes(elf)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2], 0))
