# SPDX-License-Identifier: MIT
"""Circles of modules, and who writes the state of the drive. A part of gate.floors.

A module is the files of one folder with one stem. It depends on each module that it includes and on each that defines a
function that it calls, inline in a header or not. A circle of modules is a finding. So is a recursion, a circle of functions
of one module.

In the simulator the includes alone are looked at, and in the bench of the browser the imports, of types too.

A call through a pointer counts as a call of each function of this type whose address is taken anywhere in the firmware: a
pointer that is handed down may call back up, and no include shows it.

One function writes drive_t.state; to take its address is to write it. Those that write all of a drive_t are listed. Each
group of the state (state.h) is written by the functions of one module; others hand the whole group to one of these.

libclang parses each source and each header by itself, as for an Armv7E-M, and once with the headers of each port.
"""

import functools
import os
import re
import subprocess
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from pathlib import Path

from clang.cindex import CursorKind as Kind
from clang.cindex import Diagnostic, Index, LinkageKind

import sources

PORTS = Path("firmware/math/port")
CORE = ("-target", "thumbv7em-none-eabi", "-ffreestanding")  # has what the ports use
DRIVE, STATE = "drive_t", "state"
LIFE_FILE, RECORDER_FILE = Path("firmware/drive/life.c"), Path("firmware/record/recorder.c")
RESCUE_FILE = Path("firmware/record/recorder_rescue.c")
WRITERS = {  # the recorder writes copies that no interrupt steps
    f"{DRIVE}.{STATE}": [(LIFE_FILE, "set_state")],
    DRIVE: [(LIFE_FILE, "initialise"), (RECORDER_FILE, "offer"), (RECORDER_FILE, "recorder_keep_state"),
            (RESCUE_FILE, "freeze_here")],
}
GROUPS = {  # type of a group → stem of the module that writes it
    "control_t": "frame", "current_vector_t": "vector", "motion_t": "run", "motor_t": "motor", "rotor_t": "estimate",
    "sensors_t": "calibration", "start_t": "open_loop", "state_guard_t": "state_guard", "voltage_drive_t": "voltage_drive",
    "watch_t": "monitor",
}
WITHIN = (Kind.MEMBER_REF_EXPR, Kind.ARRAY_SUBSCRIPT_EXPR, Kind.PAREN_EXPR)  # what leads to a part of a value
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.MULTILINE)
FIRMWARE = ("firmware/*.c", "firmware/*.h", "firmware/*.def")
SIMULATOR = ("host_sim/*.c", "host_sim/*.cpp", "host_sim/*.h")
BENCH = ("tools/web/src/*.ts", "tools/web/src/*.tsx")
IMPORT = re.compile(r'^(?:import|export)\b[^;"]*"(\.[^"]+)"', re.MULTILINE)


def module(path):
    return path.parent, path.stem


def leads_on(around, part):
    """Whether `around` is a part of the same value: of what an index is for, not of the index."""
    return around.kind in WITHIN and next(around.get_children()) == part


def is_const_pointer(cursor):
    return cursor.type.get_canonical().get_pointee().is_const_qualified()


def is_written(chain):
    """Whether a part of a value is written: assigned, or its address goes to a pointer that may write.

    chain: the part and the expressions around it, the outermost first.
    """
    inner = len(chain) - 1
    while leads_on(chain[inner - 1], chain[inner]) or (
            chain[inner - 2].kind == Kind.ARRAY_SUBSCRIPT_EXPR and leads_on(chain[inner - 2], chain[inner - 1])):
        inner -= 1  # where an array decays, by two
    around, part = chain[inner - 1], chain[inner]
    if around.kind == Kind.UNARY_OPERATOR:
        tokens = [token.spelling for token in around.get_tokens()]
        if tokens[0] == "&":
            return not (is_const_pointer(around) or is_const_pointer(chain[inner - 2]))
        return "++" in (tokens[0], tokens[-1]) or "--" in (tokens[0], tokens[-1])
    return around.kind in (Kind.BINARY_OPERATOR, Kind.COMPOUND_ASSIGNMENT_OPERATOR) and next(around.get_children()) == part


def group_writes(cursor, chain):
    """(type of the group, line) of each write within this function."""
    chain = [*chain, cursor]
    target = cursor.referenced if cursor.kind == Kind.MEMBER_REF_EXPR else None
    group = target and target.semantic_parent.type.spelling
    if group in GROUPS and is_written(chain):
        yield group, cursor.location.line
    whole = cursor.type.spelling if cursor.kind == Kind.BINARY_OPERATOR else ""  # only an assignment has such a type
    if whole in GROUPS:
        yield whole, cursor.location.line
    for child in cursor.get_children():
        yield from group_writes(child, chain)


def dependences(root, patterns, form, word, named):
    """(module, module that it includes or imports) → where the first time. named: whether a path is the one of a name."""
    paths = sources.files(root, *patterns)
    found = {}
    for path in paths:
        text = (root / path).read_text(encoding="utf-8")
        for match in form.finditer(text):
            where = f"{path}:{text.count(chr(10), 0, match.start()) + 1} {word} {Path(match[1]).name}"
            for other in (p for p in paths if named(path, match[1], p) and module(p) != module(path)):
                found.setdefault((module(path), module(other)), where)
    return found


def includes(root, patterns):
    return dependences(root, patterns, INCLUDE, "includes", lambda _, name, other: other.name == Path(name).name)


def imports(root):
    return dependences(root, BENCH, IMPORT, "imports",
                       lambda path, name, other: os.path.normpath(path.parent / name) == str(other))


class Code:
    """What the functions do. A function is a path and a name, a place a path and a line."""

    def __init__(self, root):
        self.root = root
        self.calls = {}  # (caller, callee) → first place
        self.writes = {}  # (what of the drive, function) → first place
        self.foreign = {}  # place → group that another module writes
        self.errors = {}  # place → what the parser says
        self.external = {}  # name → function
        self.undefined = []  # calls of what another file defines: caller, name, place
        self.through_pointers = []  # caller, type, place
        self.taken = set()  # type and name of each function whose address is taken, and the function when it is known
        self.path = functools.cache(self.path)
        paths = sources.files(root, "firmware/*.[ch]", "firmware/*.def", "hal/hal.h")
        folders = {p.parent for p in paths}
        ports = sorted(folder for folder in folders if folder.parent == PORTS)
        include = subprocess.run(["gcc", "-print-file-name=include"], check=True, capture_output=True, text=True).stdout
        for port in ports or [PORTS]:
            options = ["-xc", "-std=c11", *CORE, "-isystem", include.strip(),
                       *(f"-I{root / folder}" for folder in (port, *sorted(folders.difference(ports))))]
            for path in paths:
                if path.suffix != ".def":
                    self.parse(path, options)
        self.resolve()

    def path(self, name):
        """Relative to the root; None outside of the firmware."""
        path = Path(name).resolve()
        return path.relative_to(self.root) if path.is_relative_to(self.root / "firmware") else None

    def place(self, location):
        return (location.file and self.path(location.file.name)), location.line

    def function(self, cursor):
        return self.place(cursor.location)[0], cursor.spelling

    def parse(self, path, options):
        unit = Index.create().parse(str(self.root / path), args=options)
        for found in unit.diagnostics:
            if found.severity >= Diagnostic.Error:
                place = self.place(found.location)
                self.errors.setdefault(place if place[0] else (path, 1), found.spelling)
        for cursor in unit.cursor.get_children():
            function = self.function(cursor)
            if function[0] == path:
                if cursor.kind == Kind.FUNCTION_DECL and cursor.linkage == LinkageKind.EXTERNAL and cursor.is_definition():
                    self.external[cursor.spelling] = function
                self.visit(cursor, None, function)
                for group, line in group_writes(cursor, []):
                    if module(path) != (LIFE_FILE.parent, GROUPS[group]):
                        self.foreign[path, line] = group

    def visit(self, cursor, parent, function):
        """parent: without brackets."""
        children = list(cursor.get_children())
        target = cursor.referenced if cursor.kind in (Kind.CALL_EXPR, Kind.DECL_REF_EXPR, Kind.MEMBER_REF_EXPR) else None
        names_function = target is not None and target.kind == Kind.FUNCTION_DECL
        if cursor.kind == Kind.CALL_EXPR and names_function:
            self.call(function, target, self.place(cursor.location))
            children = children[1:]  # without the name
        elif cursor.kind == Kind.CALL_EXPR:
            pointer = children[0].type.get_canonical()
            self.through_pointers.append((function, pointer.get_pointee().spelling, self.place(cursor.location)))
        elif names_function:
            definition = target.get_definition()
            self.taken.add((target.type.get_canonical().spelling, target.spelling, definition and self.function(definition)))
        elif target is not None and cursor.spelling == STATE and target.semantic_parent.type.spelling == DRIVE:
            if parent.kind != Kind.UNEXPOSED_EXPR:  # by which it would be read
                self.writes.setdefault((f"{DRIVE}.{STATE}", function), self.place(cursor.location))
        elif cursor.kind == Kind.BINARY_OPERATOR and cursor.type.get_canonical().spelling == DRIVE:
            self.writes.setdefault((DRIVE, function), self.place(cursor.location))
        for child in children:
            self.visit(child, parent if cursor.kind == Kind.PAREN_EXPR else cursor, function)

    def call(self, caller, target, place):
        definition = target.get_definition()
        if definition is None:
            self.undefined.append((caller, target.spelling, place))
        else:
            self.add(caller, self.function(definition), place)

    def add(self, caller, callee, place):
        if callee[0] is not None:
            self.calls[caller, callee] = min(place, self.calls.get((caller, callee), place))

    def resolve(self):
        """Calls whose callee is known when all is parsed. A function that no file defines is none of the firmware."""
        nowhere = None, ""
        for caller, name, place in self.undefined:
            self.add(caller, self.external.get(name, nowhere), place)
        for caller, of_type, place in self.through_pointers:
            for taken_type, name, function in self.taken:
                if taken_type == of_type:
                    self.add(caller, function or self.external.get(name, nowhere), place)


def circles(edges):
    """Circles of a graph, (from, to) → what to say of it, as what to say of each. No two have an edge in common."""
    edges = dict(sorted(edges.items()))
    while True:
        graph = {}
        for start, end in edges:
            graph.setdefault(start, []).append(end)
        try:
            TopologicalSorter(graph).prepare()
            return
        except CycleError as found:
            nodes = found.args[1][:0:-1]  # each node before the one that depends on it, and the first again at the end
            first = nodes.index(min(nodes))
            nodes = [*nodes[first:], *nodes[:first], nodes[first]]
            yield " -> ".join(edges.pop(edge) for edge in pairwise(nodes))


def foreign_writes(root, writes):
    for (what, function), (path, line) in sorted(writes.items()):
        if function not in WRITERS[what]:
            yield f"{path}:{line}: {function[1]} writes {what}, which is for {names(WRITERS[what])} alone"
    for what, functions in WRITERS.items():
        # A name that is gone: the rule would hold for nothing.
        gone = [function for function in functions if (root / function[0]).is_file() and (what, function) not in writes]
        if gone:
            yield f"tools/gates/circles.py: {names(gone)} does not write {what}"


def names(functions):
    return ", ".join(f"{name} of {path}" for path, name in functions)


def findings(root):
    code = Code(root.resolve())
    between, within = {}, {}
    for (caller, callee), (path, line) in sorted(code.calls.items(), key=lambda call: call[1]):
        edge = module(caller[0]), module(callee[0])
        where = f"{path}:{line} calls {callee[1]}"
        if edge[0] == edge[1]:
            within[caller, callee] = where
        else:
            between.setdefault(edge, where)
    yield from (f"{path}:{line}: {text}" for (path, line), text in code.errors.items())
    for edges in (includes(root, FIRMWARE) | between, includes(root, SIMULATOR), imports(root)):
        yield from (f"{circle}: modules in a circle" for circle in circles(edges))
    yield from (f"{circle}: a recursion" for circle in circles(within))
    yield from foreign_writes(root, code.writes)
    for (path, line), group in sorted(code.foreign.items()):
        yield f"{path}:{line}: writes a {group}, which is for {GROUPS[group]}.c alone"
