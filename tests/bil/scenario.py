"""A scenario of the simulator with the image in the loop.

scenario.py IMAGE BOARD CLOCK BIL_PLANT SCENARIO IMPERFECTIONS: the image runs from its reset vector on the board of
the file BOARD, its time is kept by the library CLOCK (core_clock.c); the plant, and the judgement, are those of BIL_PLANT. Exit status as that program's.
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
    before, ticks = None, 0
    while record := plant.stdout.read(ASKED.size):
        asked = ASKED.unpack(record)
        if before is None:
            board.set_inputs(*asked[:MEASURED])
            board.boot()
            before = (0,) * len(asked)
        type_changes(board, before, asked)
        if board.ticks != ticks:
            sys.exit(f"a tick came upon the command before tick {ticks}: it was not the plant's")
        answer(plant, board, asked)
        before = asked
        ticks += 1


def main(image, board_file, clock, program, scenario, imperfections):
    board = Board(Path(image), Path(board_file), Path(clock))
    with subprocess.Popen([program, scenario, imperfections, f"board={board_file}"],
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE) as plant:
        loop(plant, board)
    board.type("status")
    said = board.said()
    if " late 0," not in said.splitlines()[-1] or "error" in said:
        sys.exit(f"the console said:\n{said}")
    sys.exit(plant.returncode)


if __name__ == "__main__":
    if len(sys.argv) != 7:
        sys.exit(__doc__)
    main(*sys.argv[1:])
