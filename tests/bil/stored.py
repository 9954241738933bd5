# SPDX-License-Identifier: MIT
"""A configuration in the flash of a board, as its store keeps it."""

import binascii
import struct
import subprocess
import tempfile
from pathlib import Path

from flash import store_of

STAMPS = 192 * 8  # bytes of a slot of the store before its stamp, store.h


def stored(nfconfig, facts, motor, board, tuning, settings):
    """The store's pages, (address, bytes). `settings`: by their keys."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.nfb"
        words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        subprocess.run([nfconfig, "block", "--motor", motor, "--board", board, "--tuning", tuning, *words, "-o", file], check=True)
        data = file.read_bytes()
    stamp = struct.pack("<I", 2)
    stamp += struct.pack("<I", binascii.crc32(stamp + data[-4:]))
    address = store_of(facts)
    return [(address, data), (address + STAMPS, stamp)]
