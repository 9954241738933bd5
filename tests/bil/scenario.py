"""A scenario of the simulator with the image in the loop.

scenario.py IMAGE BOARD BIL_PLANT SCENARIO IMPERFECTIONS: the image runs from its reset vector on the board of
the file BOARD; the plant, and the judgement, are those of BIL_PLANT. Exit status as that program's.
"""

import struct
import subprocess
import sys
from pathlib import Path

from board import Board

ASKED = struct.Struct("<HHHHii")  # bil_plant.cpp
MEASURED = 4  # of what is asked
DONE = struct.Struct("<HHHH")


def answer(plant, board, asked):
    board.set_inputs(*asked[:MEASURED])
    board.tick()
    timer = board.chip.timer
    plant.stdin.write(DONE.pack(*timer.preloaded(), timer.gates_on()))
    plant.stdin.flush()


def type_changes(board, before, asked):
    (run_before, speed_before), (run, speed) = before[-2:], asked[-2:]
    if speed != speed_before:
        board.type(f"speed {speed}")
    if run != run_before:
        board.type("run" if run else "stop")


def loop(plant, board):
    before = None
    while record := plant.stdout.read(ASKED.size):
        asked = ASKED.unpack(record)
        if before is None:
            board.set_inputs(*asked[:MEASURED])
            board.boot()
            before = (0,) * len(asked)
        type_changes(board, before, asked)
        answer(plant, board, asked)
        before = asked


def main(image, board_file, program, scenario, imperfections):
    board = Board(Path(image), Path(board_file))
    with subprocess.Popen([program, scenario, imperfections, f"board={board_file}"],
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE) as plant:
        loop(plant, board)
    board.type("status")
    said = board.said()
    if " late 0," not in said.splitlines()[-1] or "error" in said:
        sys.exit(f"the console said:\n{said}")
    sys.exit(plant.returncode)


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    main(*sys.argv[1:])
