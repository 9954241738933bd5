# SPDX-License-Identifier: MIT
"""Where the drive and its frames lie in the program that gdb has, and which word of the table lies where."""

import re
from pathlib import Path

import gdb

from . import table

ISR, STEP = "control_isr", "drive_step"
# Where a tick begins. Images are optimised as a whole: what is left as a function of their interrupt is its own.
ENTRIES = ("control_interrupt", "ADC1_2_IRQHandler", ISR, STEP)


def is_readable(value):
    """It is somewhere."""
    return value is not None and not value.is_optimized_out


def variable(frame, name):
    """A variable of a frame that can be read, or None."""
    try:
        value = frame.read_var(name)
        return value if is_readable(value) else None
    except (ValueError, gdb.error):
        return None


def frames():
    """From the selected one outwards."""
    try:
        frame = gdb.selected_frame()
    except gdb.error:
        return
    while frame is not None:
        yield frame
        try:
            frame = frame.older()
        except gdb.error:
            return


def homes_of_app(app):
    """An app_t's parts."""
    return {"drive": app["drive"], "in": app["in"], "out": app["out"]}


def homes_of_frame(frame):
    """What a frame of the interrupt or of the step was given, or None."""
    if frame.name() == ISR:
        app = variable(frame, "app")
        return None if app is None else homes_of_app(app.dereference())
    if frame.name() == STEP:
        given = {name: variable(frame, name) for name in ("drive", "in", "out")}
        if given["drive"] is not None:
            return {name: value.dereference() for name, value in given.items() if value is not None}
    return None


def homes_of_program():
    """A static app_t, as images have it, or None."""
    for lookup in (gdb.lookup_static_symbol, gdb.lookup_global_symbol):
        symbol = lookup("app")
        if symbol is not None and str(symbol.type) == "app_t":
            return homes_of_app(symbol.value())
    return None


def member(home, path):
    """compare.phase[0] of a struct."""
    value = home
    for name, index in re.findall(r"(\w+)(?:\[(\d+)\])?", path):
        value = value[name]
        if index:
            value = value[int(index)]
    return value


class Program:
    """What is known of the program in gdb: its drive, and its table."""

    def __init__(self):
        self._homes = None
        self._places = {}
        self._checked = None
        self.table = None
        gdb.events.exited.connect(self._forget)

    def _forget(self, _event):
        self._homes = None

    def choose(self, new_table):
        """The table to show words with. Raises TableError when it is of another configuration; the one before stays."""
        before = self.table
        self._places = {}
        self._checked = None
        self.table = new_table
        try:
            self.homes()
        except table.TableError:
            self.table = before
            raise

    def homes(self):
        """The struct behind each home, or None before the program has made them."""
        found = next(filter(None, map(homes_of_frame, frames())), None)
        try:
            self._use(found or self._homes or homes_of_program())
        except gdb.error:  # memory of a program that does not run yet
            self._homes = None
        return self._homes

    def _use(self, found):
        self._homes = None
        if found is None or int(found["drive"]["cfg"]) == 0:
            return
        found["cfg"] = found["drive"]["cfg"].dereference()
        if self.table is None:
            self.table = own_table()
        self._check(found["cfg"])
        self._homes = found

    # Once for each drive: who changes its configuration in the debugger seals it anew.
    def _check(self, cfg):
        address = int(cfg.address)
        if self.table is None or self._checked == address:
            return
        own, scenario = int(cfg["crc"]), self.table.scenario
        if own != self.table.crc:
            other, self.table = self.table.crc, None
            raise table.TableError(f"the drive's configuration has crc {own:#010x}, that of {scenario} "
                                   f"{other:#010x}: choose the one that the program was built for")
        self._checked = address

    def value(self, name):
        """A word of the table as an integer, or None where its home is unknown."""
        word = self.table.words[name]
        homes = self.homes() or {}
        return int(member(homes[word.home], word.member)) if word.home in homes else None

    def word_at(self, value):
        """The table's word that a value is, or None."""
        if value.address is None or not self.homes() or self.table is None:
            return None
        return self._index().get((int(value.address), value.type.sizeof))

    def _index(self):
        key = tuple(int(home.address) for home in self._homes.values())
        if key not in self._places:
            places = {}
            for word in self.table.words.values():
                if word.home in self._homes:
                    value = member(self._homes[word.home], word.member)
                    places[int(value.address), value.type.sizeof] = word
            self._places = {key: places}
        return self._places[key]


def own_table():
    """Of motorsim itself, by its arguments; else None: `scales` chooses one."""
    name = gdb.current_progspace().filename
    if name is None or Path(name).name != "motorsim":
        return None
    shown = re.search(r'started is "(.*)"', gdb.execute("show args", to_string=True), re.DOTALL)
    choice = table.choice_of(shown[1])
    try:
        return None if choice is None else table.load(choice, name)
    except table.TableError:  # motorsim says itself what is wrong with its arguments
        return None


program = Program()
