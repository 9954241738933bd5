# SPDX-License-Identifier: MIT
"""A scenario of the simulator with the image in the loop.

scenario.py IMAGE BOARD CLOCK BIL_PLANT SCENARIO PARTS: the image runs from its reset vector on the board of
the file BOARD, its time is kept by the library CLOCK (core_clock.c); the plant, and the judgement, are those of BIL_PLANT. PARTS
says which the board has of many, see below; with others than ideal ones its switches make spikes, and the plant's sensors
have the errors of its amplifiers. Exit status as that program's.
"""

import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import analogue
import digital
from board import Board
from core import NEVER

ASKED = struct.Struct("<10Hiiii")  # bil_plant.cpp
MEASURED = 4  # of what is asked
SHAFT = slice(4, 9)
COMMANDED = slice(10, 12)
COLD = (0, 1, ~1 & 0xFFFFFFFF)  # what a reset has left of a winding without heat, kept_heat.c: that of the simulator
DONE = struct.Struct("<HHHHiBBH")
SCRIPTED = (0, 0, 0, 0)  # the image obeys the script: it has no command of its own
SPIKE_S = 100e-9  # as the switches make when they turn on
SPIKE = 4095  # counts of a pin, beyond every level
# That trips late, or early, or lies anywhere.
PARTS = {"ideal": analogue.ideal, "least": analogue.least, "most": analogue.most, "drawn": analogue.drawn(1)}


def imperfections(board, parts, folder):
    """Of the plant's sensors, for bil_plant: those that the simulator knows, or a file of the board's own."""
    if parts == "ideal":
        return "adc"
    offsets, gains = zip(*board.sensor_errors())
    path = Path(folder) / "parts.toml"
    path.write_text("[plant]\nadc_noise_lsb = 1\n"
                    f"adc_offset_lsb = {list(offsets)}\n"
                    f"adc_gain_error_pct = {[100 * (gain - 1) for gain in gains]}\n", encoding="utf-8")
    return path


def turn_on(board):
    """The spikes of all three phases, right behind the tick's update."""
    for pin in board.wiring.shunts:
        board.chip.spike(pin, SPIKE, SPIKE_S)


def set_shaft(board, reading, index, indexed, age_q8, frame):
    """What the sensor's pins are at, as the models of what reads them have it then: test_shaft.py has their edges."""
    chip = board.chip
    if chip.absolute:
        chip.absolute.angle = frame & chip.absolute.ANGLE
        if chip.spi.received and chip.spi.received != [reading]:
            chip.spi.received = [reading]  # the wires have disturbed it
    elif chip.hall and chip.hall.is_reset_by_edges():
        for sensor, pin in enumerate(board.wiring.hall):
            chip.signals.set(pin, reading >> sensor & 1)
        chip.hall.held = min(round((age_q8 - 0.5) * digital.CLOCK_HZ / (board.pwm_hz << 8)), 0xFFFF)
    elif chip.encoder:
        chip.encoder.counted = reading
        if indexed:
            channel = board.wiring.index_channel
            chip.encoder[f"CCR{channel}"] = index
            chip.encoder["SR"] |= 1 << channel


def answer(plant, board, asked, spikes, commanded=lambda: SCRIPTED):
    """`commanded`: target, mode and request of the next tick, and 1, where the image's background says them."""
    board.set_measured(*asked[:MEASURED])
    set_shaft(board, *asked[SHAFT])
    if spikes:
        turn_on(board)
    board.tick()
    timer = board.chip.timer
    plant.stdin.write(DONE.pack(*timer.preloaded(), timer.gates_on(), *commanded()))
    plant.stdin.flush()


def lines_of_changes(before, asked):
    """What somebody types for them."""
    (run_before, speed_before), (run, speed) = before[COMMANDED], asked[COMMANDED]
    lines = [f"speed {speed}"] if speed != speed_before else []
    if run != run_before:
        lines.append("run" if run else "stop")
    return b"".join(f"{line}\r".encode() for line in lines)


def loop(plant, board, spikes, mailbox=None):
    """What is typed comes at one go in each tick as far as the receiver has room, which is faster than any line: what the
    background does with it has to end before the next tick, which is the plant's. With the image's `mailbox` (image_mailbox.py)
    the plant's drive is commanded what the image is: a line that the receiver has no room for takes two ticks, so it comes late."""
    before, ticks, typed = None, 0, b""

    def type_changes(until=NEVER):
        nonlocal typed
        typed += lines_of_changes(before, asked)
        if typed and board.core.asleep:
            typed = board.send_at_once(typed, until)

    def commanded():
        type_changes(board.chip.timer.next_update())
        return (*mailbox.command(), 1)

    while record := plant.stdout.read(ASKED.size):
        asked = ASKED.unpack(record)
        if before is None:
            board.set_measured(*asked[:MEASURED])
            set_shaft(board, *asked[SHAFT])
            board.boot()
            before = (0,) * len(asked)
        if mailbox is None:
            type_changes()
        if board.ticks != ticks:
            sys.exit(f"a tick came upon the command before tick {ticks}: it was not the plant's")
        answer(plant, board, asked, spikes, commanded if mailbox else lambda: SCRIPTED)
        before = asked
        ticks += 1


def judge_console(board):
    board.type("status")
    said = board.said()
    last = said.splitlines()[-1]
    if not last.startswith("RUN, ") or " late 0," not in last or "error" in said:
        sys.exit(f"the console said:\n{said}")


def judge_stop(board):
    """Out of full speed and load."""
    running = board.chip.timer.gates_on()
    board.type("stop")
    board.take()
    if not running or board.chip.timer.gates_on():
        sys.exit("`stop` does not open the gates, or they were open before")


def main(image, board_file, clock, program, scenario, parts):
    board = Board(Path(image), Path(board_file), Path(clock), choose=PARTS[parts], kept=COLD)
    with tempfile.TemporaryDirectory() as folder, \
            subprocess.Popen([program, scenario, imperfections(board, parts, folder), f"board={board_file}"],
                             stdin=subprocess.PIPE, stdout=subprocess.PIPE) as plant:
        loop(plant, board, spikes=parts != "ideal")
    judge_console(board)
    judge_stop(board)
    sys.exit(plant.returncode)


if __name__ == "__main__":
    if len(sys.argv) != 7 or sys.argv[6] not in PARTS:
        sys.exit(__doc__)
    main(*sys.argv[1:])
