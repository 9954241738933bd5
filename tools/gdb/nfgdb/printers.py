# SPDX-License-Identifier: MIT
"""Pretty-printers: a word with a place in the table in its unit; without one, what its type or name tells."""

import re

import gdb
import gdb.printing

from .memory import is_readable, program
from .table import TURN, TableError

Q_NAME = re.compile(r"_q(\d+)$")
SCALARS = (gdb.TYPE_CODE_INT, gdb.TYPE_CODE_BOOL)
VECTORS = {"dq_t": ("d", "q"), "ab_t": ("alpha", "beta"), "sincos_t": ("sin", "cos")}
NAMED = {"drive_state_t": "DRIVE_STATE_", "fault_id_t": "FAULT_"}
Q15 = 2**15


def word_of(value):
    """The table's word at a value's place, or None; a wrong table is none."""
    try:
        return program.word_at(value)
    except TableError:
        return None


class Text:
    """A value that is one line."""

    def __init__(self, text):
        self._text = text

    def to_string(self):
        """The line."""
        return self._text


class Fields:
    """A struct with numbers whose names tell their format, where the table does not."""

    def __init__(self, value):
        self._value = value

    def children(self):
        """Each field by its name."""
        for field in self._value.type.strip_typedefs().fields():
            value = self._value[field.name]
            bits = Q_NAME.search(field.name)
            if bits and value.type.strip_typedefs().code in SCALARS and word_of(value) is None:
                raw = int(value)
                yield field.name, f"{raw / 2**int(bits[1]):.6g} (raw {raw}, Q{bits[1]})"
            else:
                yield field.name, value


def angle_text(raw):
    """Within ±180°."""
    half = TURN // 2
    return f"{((raw + half) % TURN - half) / TURN * 360:.6g} deg el (raw {raw})"


def step_text(raw):
    """A step a tick, as speed where the tick is known."""
    try:
        known = program.homes() and program.table
    except TableError:
        known = None
    speed = known.speed_text(raw) if known else f"{raw / TURN:.6g} turns el a tick"
    return f"{speed} (raw {raw})"


def vector_text(value, axes):
    """Two components with one format."""
    raws = [int(value[axis]) for axis in axes]
    words = [word_of(value[axis]) for axis in axes]
    if all(words):
        values, form = [word.si_text(raw) for word, raw in zip(words, raws)], words[0].format
    else:
        values, form = [f"{raw / Q15:.6g}" for raw in raws], "as Q15"
    shown = ", ".join(f"{axis} {text}" for axis, text in zip(axes, values))
    return f"{shown} (raw {raws[0]}, {raws[1]}; {form})"


def scalar_printer(value):
    """By its place."""
    word = word_of(value)
    return None if word is None or word.is_plain else Text(word.text(int(value)))


def printer_of(value):
    """gdb asks for every value that it shows."""
    if not is_readable(value) or value.type.code == gdb.TYPE_CODE_PTR:
        return None
    name, plain = value.type.unqualified().name, value.type.strip_typedefs()
    if name == "angle_t":
        return Text(angle_text(int(value)))
    if name == "step_t":
        return Text(step_text(int(value)))
    if name in VECTORS:
        return Text(vector_text(value, VECTORS[name]))
    if name in NAMED:
        return Text(str(value.cast(plain)).removeprefix(NAMED[name]))
    if plain.code in SCALARS:
        return scalar_printer(value)
    if plain.code == gdb.TYPE_CODE_STRUCT and any(Q_NAME.search(field.name or "")
                                                  for field in plain.fields()):
        return Fields(value)
    return None


def register():
    """From here on."""
    printer_of.__name__ = "neurofoc"
    gdb.printing.register_pretty_printer(None, printer_of, replace=True)
