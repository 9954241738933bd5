# SPDX-License-Identifier: MIT
"""The tables of docs/board_bring_up.md that say what flash and RAM each shipped board's image takes, out of the images.

image_size.py           says whether the page is as the images have it; exit status 1 if not
image_size.py --write   writes the tables anew
"""
import argparse
import re
import sys
from itertools import takewhile

import generated

sys.path += [str(generated.ROOT / "tools"), str(generated.ROOT / "tools/evidence")]
import bounds  # pylint: disable=wrong-import-position
from bench.image import Image  # pylint: disable=wrong-import-position

IMAGES = generated.ROOT / "hal/stm32g4/CMakeLists.txt"
OF_BOARD = re.compile(r"^nf_add_g4_image\((\w+) MOTOR \w+ BOARD (\w+) TUNING \w+\)", re.MULTILINE)
BUILT = bounds.BOARD.parent
SEGMENT_MARGIN = 17  # entries of a segment that hold no history: docs/configuration.md, board.recorder_entries
LEAST = 1024  # bytes of a part that the page names
MARGIN = 0.05  # as a share: what the page shows need not follow each change
PAGE = "docs/board_bring_up.md"
KINDS = {"T": "code", "W": "code", "R": "constants", "D": "initialised variables", "B": "variables"}
FLASH = (".vectors", ".text", ".rodata", ".note.gnu.build-id", ".data", ".checksum")
RAM = (".stack", ".data", ".bss", ".noinit", ".kept")


def length(script, region):
    """Bytes of a memory of the chip that the linker may fill."""
    return 1024 * int(re.search(rf"{region} .*LENGTH = (\d+)K", script)[1])


def ticks(header):
    """What the recorder's ring holds at any time."""
    entries, slow = (int(re.search(pattern, header)[1])
                     for pattern in (r"DRIVE_RECORDER_ENTRIES \((\d+)U\)", r"[.]slow_ticks = (\d+)U"))
    return 3 * (entries - SEGMENT_MARGIN) - slow


class Board:
    """An image of a shipped board, and what nfconfig has written for it."""

    def __init__(self, name, board):
        self.image = Image(BUILT / f"{name}.elf")
        folder = BUILT / f"hal/stm32g4/{name}_config"
        self.script, self.header = ((folder / file).read_text(encoding="utf-8")
                                    for file in ("hal_memory.ld", "drive_config.h"))
        self.title = f"`{board}`, {re.search(r'stm32g4[0-9a-z]+', self.script)[0].upper()}"

    def bytes_of(self, names):
        return sum(self.image.sections.get(name, (0, 0))[1] for name in names)

    def memory_row(self):
        ring = self.image.symbol("ring").size
        return [self.title, f"{self.bytes_of(FLASH)} of {length(self.script, 'flash')}",
                f"{self.bytes_of(RAM) - ring} of {length(self.script, 'ram')}", ring, ticks(self.header)]

    def stack_row(self):
        users, total = bounds.board_rows(self.image)
        return [self.title, self.bytes_of([".stack"]), total, *(size for _, size, _ in users)]


def boards():
    """Of each image whose board is not chosen by the user."""
    return [Board(*names) for names in OF_BOARD.findall(IMAGES.read_text(encoding="utf-8"))]


def memory(rows):
    return generated.table(["board file, chip", "flash", "RAM without the ring", "ring", "ticks in the ring"],
                           (board.memory_row() for board in rows))


def stack(rows):
    users = [f"`{entry}`" for entry in (bounds.BACKGROUND, *bounds.EXCEPTIONS)]
    return generated.table(["board file, chip", "reserved", "needed at most", *users], (board.stack_row() for board in rows))


def parts(image):
    ordered = sorted(image.symbols, key=lambda symbol: (-symbol.size, symbol.name))
    return generated.table(["part", "what", "bytes"], (
        [f"`{re.sub(r'[.].*', '', symbol.name)}`", KINDS[symbol.kind], symbol.size]
        for symbol in takewhile(lambda symbol: symbol.size >= LEAST, ordered)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables anew")
    write = parser.parse_args().write
    rows = boards()
    made = {"memory": memory(rows), "stack": stack(rows), "parts": parts(Image(bounds.BOARD))}
    generated.finish(PAGE, generated.kept(PAGE, made, MARGIN), "each board's image", write)


if __name__ == "__main__":
    main()
