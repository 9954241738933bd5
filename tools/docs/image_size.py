# SPDX-License-Identifier: MIT
"""The tables of docs/board_bring_up.md that say what of flash and RAM the image takes, out of the image.

image_size.py           says whether the page is as the image has it; exit status 1 if not
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

LEAST = 1024  # bytes of a part that the page names
MARGIN = 0.05  # as a share: what the page shows need not follow each change
PAGE = "docs/board_bring_up.md"
KINDS = {"T": "code", "W": "code", "R": "constants", "D": "initialised variables", "B": "variables"}
FLASH = (".vectors", ".text", ".rodata", ".note.gnu.build-id", ".data", ".checksum")
RAM = (".stack", ".data", ".bss", ".noinit")


def memory(image):
    def of_all(names):
        return sum(image.sections.get(name, (0, 0))[1] for name in names)

    users, total = bounds.board_rows(image)
    needed = ", ".join(f"`{name}` {size}" for name, size, _ in users)
    return generated.table(["what", "bytes"], [
        ["flash", of_all(FLASH)],
        ["RAM", of_all(RAM)],
        ["of these with initial values", of_all([".data"])],
        ["of these as stack", f"{of_all(['.stack'])}; at most {total} are needed: {needed}"]])


def parts(image):
    ordered = sorted(image.symbols, key=lambda symbol: (-symbol.size, symbol.name))
    return generated.table(["part", "what", "bytes"], (
        [f"`{re.sub(r'[.].*', '', symbol.name)}`", KINDS[symbol.kind], symbol.size]
        for symbol in takewhile(lambda symbol: symbol.size >= LEAST, ordered)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables anew")
    write = parser.parse_args().write
    image = Image(bounds.BOARD)
    made = {"memory": memory(image), "parts": parts(image)}
    generated.finish(PAGE, generated.kept(PAGE, made, MARGIN), "the image", write)


if __name__ == "__main__":
    main()
