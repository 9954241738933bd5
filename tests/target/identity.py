# SPDX-License-Identifier: MIT
"""Replays a recording on an emulated board and compares every tick with the PC's results.

identity.py QEMU BOARD IMAGE FOLDER: FOLDER holds frames.nfr and results.nfr of `record`.
Exit status: 0 when the board's file is the same, byte for byte; else 1 with the first difference.
"""

import struct
import subprocess
import sys
import tempfile
from pathlib import Path

HEADER = struct.Struct("<IHHII")  # hal/mps2/recording.h
RESULT = struct.Struct("<HHHBBI")
NAMES = ("compare a", "compare b", "compare c", "gate_enable", "state", "state hash")
TIMEOUT_S = 120


def replay(qemu, board, image, folder, work):
    """The file that the board wrote; ends the program when the board does not get to the end."""
    (work / "frames.nfr").symlink_to(folder.resolve() / "frames.nfr")
    run = subprocess.run(
        [qemu, "-M", board, "-kernel", image.resolve(), "-nodefaults", "-nic", "none", "-display", "none",
         "-monitor", "none", "-serial", "null", "-semihosting-config", "enable=on,target=native"],
        cwd=work, capture_output=True, text=True, timeout=TIMEOUT_S)
    if run.returncode:
        sys.exit(f"{board} ends with {run.returncode}: {run.stdout}{run.stderr}".rstrip())
    return (work / "results.nfr").read_bytes()


def difference(board, expected, actual):
    """Where two files of results differ first, as text."""
    if expected[:HEADER.size] != actual[:HEADER.size] or len(expected) != len(actual):
        return f"{board}: another header or length ({len(actual)} bytes, PC {len(expected)})"
    for tick, at in enumerate(range(HEADER.size, len(expected), RESULT.size)):
        ours, theirs = expected[at:at + RESULT.size], actual[at:at + RESULT.size]
        if ours != theirs:
            fields = zip(NAMES, RESULT.unpack(ours), RESULT.unpack(theirs))
            return f"{board}: tick {tick}: " + ", ".join(
                f"{name} {there:#x}, PC {here:#x}" for name, here, there in fields if here != there)
    return None


def main(qemu, board, image, folder):
    folder = Path(folder)
    expected = (folder / "results.nfr").read_bytes()
    with tempfile.TemporaryDirectory() as work:
        actual = replay(qemu, board, Path(image), folder, Path(work))
    if expected != actual:
        sys.exit(difference(board, expected, actual))
    ticks = (len(expected) - HEADER.size) // RESULT.size
    print(f"{board}: {ticks} ticks, each as on the PC")


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
