# SPDX-License-Identifier: MIT
"""The board of IMAGE BOARD CLOCK, a test's first arguments: as it comes, ready and running, without a motor."""

import sys
import tomllib
from pathlib import Path

import unicorn

import board
import elf
from wiring import Wiring, port_and_number

IMAGE, BOARD, CLOCK = (Path(argument) for argument in sys.argv[1:4])
FILE = tomllib.loads(BOARD.read_text(encoding="utf-8"))
STAGE, HAL = FILE["board"], FILE["hal"]
WIRING = Wiring(HAL)
MIDDLE = 2048
WORD_BYTES = 4
BUS = round(STAGE["bus_nominal_v"] / STAGE["bus_full_scale_v"] * 4096)
HALF_PERIOD = round(STAGE["timer_clock_hz"] / STAGE["pwm_frequency_hz"] / 2)
FULL_SCALE_A = STAGE["current_full_scale_a"]
CALIBRATION_TICKS = 260  # 256 samples and the changes of state


def make(image=IMAGE, **arguments):
    made = board.Board(image, BOARD, CLOCK, **arguments)
    made.set_inputs(MIDDLE, MIDDLE, BUS)
    return made


def booted(**arguments):
    made = make(**arguments)
    made.boot()
    return made


def ready(**arguments):
    made = booted(**arguments)
    made.tick(CALIBRATION_TICKS)
    return made


def instant(**arguments):
    """Ready, and its console takes no time: without a motor the drive does not run on for as long as a line takes."""
    made = ready(**arguments)
    made.said()
    made.chip.usart.instant = True
    return made


def running(**arguments):
    made = instant(**arguments)
    run(made)
    made.said()
    return made


def reset(made, flags, ram=True, **arguments):
    """The board after a reset at this moment, before its first instruction. Without `ram` the supply was off."""
    power = made.chip.power
    again = make(reset_flags=flags | board.PIN_FLAG, flashed=power.flash.content(), kept=power.backup.words if ram else (), **arguments)
    if ram:
        again.core.set_ram(made.core.ram())
    return again


def run(made):
    """The line is typed right after a tick, and the next one takes it."""
    made.tick()
    made.tick_to_take()
    made.type("run")
    made.take()
    made.tick(2)


def gates_are_inputs(made):
    """Whether the chip has let go of all gates."""
    pins = [port_and_number(pin.name) for pin in made.wiring.gates]
    return all(made.chip.ports[port].mode(pin) == 0 for port, pin in pins)


def answer(made, line):
    """What the console says of a line, and of nothing before it."""
    made.said()
    made.type(line)
    return made.said()


def lose_a_conversion(made):
    """The next one does not come: the tick's guard does."""
    trigger = made.chip.timer.trigger
    made.chip.timer.trigger = lambda: setattr(made.chip.timer, "trigger", trigger)
    return made.handle_next()


def change_what_is_read(made, place, read):
    """Before each look at the word of the RAM at `place`, it becomes what `read` makes of it."""
    uc = made.core.uc

    def look(*_):
        word = int.from_bytes(uc.mem_read(place, WORD_BYTES), "little")
        uc.mem_write(place, read(word).to_bytes(WORD_BYTES, "little"))

    uc.hook_add(unicorn.UC_HOOK_MEM_READ, look, begin=place, end=place + WORD_BYTES - 1)


def address_of(name):
    """Of a variable, to whose name the linker may have added something."""
    return elf.address_of(IMAGE, name)
