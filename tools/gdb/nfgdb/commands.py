# SPDX-License-Identifier: MIT
"""Commands: scales, step-isr, stages."""

import gdb

from . import table
from .memory import ENTRIES, STEP, frames, program
from .printers import NAMED

STEPS_MAX = 1_000_000_000


def find_homes():
    """The drive and its frames, or None."""
    try:
        return program.homes()
    except table.TableError as error:
        raise gdb.GdbError(f"scales: {error}") from error


def need_table():
    """Homes, with a table to show them by."""
    homes = find_homes()
    if homes is None:
        raise gdb.GdbError("there is no drive yet: `step-isr` runs to its first tick")
    if program.table is None:
        raise gdb.GdbError("the scales are not known: `scales SCENARIO` chooses them")
    return homes


def position_text(homes):
    """The tick whose results the drive holds."""
    drive = homes["drive"]
    state = str(drive["state"].cast(drive["state"].type.strip_typedefs()))
    ended = int(drive["tick"])
    text = f"tick {ended - 1}" if ended else "before the first tick"
    text += f"  {state.removeprefix(NAMED['drive_state_t'])}"
    if any(frame.name() == STEP for frame in frames()):
        return f"{text}, and within the next: what that has not come to is of this one"
    return text


class Scales(gdb.Command):
    """Choose the scales of the firmware's numbers: scales SCENARIO [--with SET]... [--set KEY=VALUE]...

    As for `motorsim run`, and of the configuration that the program was built with. motorsim itself needs no such
    command, its arguments tell."""

    def __init__(self):
        super().__init__("scales", gdb.COMMAND_DATA)

    def invoke(self, argument, _from_tty):
        """gdb calls it."""
        try:
            program.choose(table.load(gdb.string_to_argv(argument)))
        except table.TableError as error:
            raise gdb.GdbError(f"scales: {error}") from error
        print(program.table)


def steps_of(argument):
    """How many."""
    try:
        count = int(argument or "1")
    except ValueError:
        count = 0
    if not 1 <= count <= STEPS_MAX:
        raise gdb.GdbError(f"step-isr: how many ticks is a whole number from 1 to {STEPS_MAX}, found '{argument}'")
    return count


class StepIsr(gdb.Command):
    """Go on to the N-th next entry of the control interrupt, or of drive_step where there is none: step-isr [N]

    Starts a program that does not run. There the drive holds the results of the tick before; `stages` shows them."""

    def __init__(self):
        super().__init__("step-isr", gdb.COMMAND_RUNNING)

    def invoke(self, argument, _from_tty):
        """gdb calls it."""
        count = steps_of(argument)
        entry = next((name for name in ENTRIES if gdb.lookup_global_symbol(name)), None)
        if entry is None:
            raise gdb.GdbError(f"step-isr: the program has none of {', '.join(ENTRIES)}")
        stop = gdb.Breakpoint(entry, internal=True)
        stop.silent = True
        stop.ignore_count = count - 1
        try:
            running = gdb.selected_inferior().pid != 0
            said = gdb.execute("continue" if running else "run", to_string=True)
            arrived = stop.hit_count == count
        finally:
            stop.delete()
        if not arrived:
            print(said.strip())
            return
        homes = find_homes()
        print(f"at the first tick of {entry}" if homes is None else position_text(homes))


class Stages(gdb.Command):
    """Every intermediate of one control tick in the order in which the drive computes it: stages

    Of the last tick that has ended; within one, of what it has already computed."""

    def __init__(self):
        super().__init__("stages", gdb.COMMAND_DATA)

    def invoke(self, argument, _from_tty):
        """gdb calls it."""
        if argument:
            raise gdb.GdbError(f"stages: '{argument}' is one word too many")
        print(position_text(need_table()))
        for stage in program.table.stages:
            if self._is_shown(stage):
                self._show(stage)

    @staticmethod
    def _is_shown(stage):
        here = "states" not in stage or program.value("drive.state") in stage["states"]
        return here and ("flag" not in stage or
                         (program.value(stage["flag"]) != 0) == stage["shown_with"])

    @staticmethod
    def _show(stage):
        print(stage["title"])
        for name in stage["signals"]:
            raw = program.value(name)
            print("  " + (f"{name}: not known here" if raw is None
                          else program.table.words[name].line(raw)))


def register():
    """From here on."""
    for command in (Scales, StepIsr, Stages):
        command()
