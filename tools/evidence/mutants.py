# SPDX-License-Identifier: MIT
"""Mutants of a C or C++ file: small faults, each put into its syntax tree's text at one place.

    operators     + with −, * with +, shifts, & with |, and each comparison with its neighbour and its opposite
    terms         one side of a sum, difference, product or condition, an assignment, a call left out
    signs         of a term, of what is assigned, handed over in a struct or returned
    constants     one more, one less; also shifts; a real one times 2 and times 0.9; those of rows (cfg.def) that a function
                  includes, too
    saturations   fx_sat…, fx_clamp, fx_min, fx_max and std's left out on one side or on both
    mix-ups       d with q, α with β, sine with cosine, upper with lower; both branches of a condition

Parsed by libclang, so that an operand is whole, whatever brackets and line breaks it has. universalmutator was looked
at: its regular expressions see one line at a time, skip each that has a comment in it and break off at the first
bracket, so that most of these faults cannot be told to it.
"""

import functools
import re
import subprocess
from dataclasses import dataclass

from clang.cindex import CursorKind as Kind
from clang.cindex import Index, TypeKind

OPERATORS = {
    "+": ("-",), "-": ("+",), "*": ("+",), "/": ("*",), "<<": (">>",), ">>": ("<<",), "&": ("|",), "|": ("&",),
    "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
    "&&": ("||",), "||": ("&&",),
}
WITH_TERMS = ("+", "-", "*", "&&", "||")
COMPOUND = {"+=": ("-=", "="), "-=": ("+=", "="), "<<=": (">>=",), ">>=": ("<<=",)}
MIX_UPS = {"d": "q", "alpha": "beta", "sin": "cos", "upper": "lower"}
MIX_UPS.update({other: name for name, other in MIX_UPS.items()})
NAMES = {"fx_min": "fx_max", "fx_max": "fx_min", "min": "std::max", "max": "std::min"}
WHOLE = ("int", "long")
DEFINITIONS = (Kind.FUNCTION_DECL, Kind.CXX_METHOD)
ROWS = re.compile(rb'^[ \t]*#include "(\w+\.def)"$', re.MULTILINE)  # in a function: its statements
ROW = re.compile(r'^\w+\([^"\n]*', re.MULTILINE)  # up to its text
NUMBER = re.compile(r"\b(?:0x[0-9A-Fa-f]+|\d+)\b")


@dataclass(frozen=True)
class Whole:
    """The definition of a C function: from `start` to `end` of the file's bytes, its name, its body."""

    spelling: str
    start: int
    name: int
    body: int
    end: int
    parameters: tuple
    returns_nothing: bool


@dataclass(frozen=True)
class Mutant:
    """`start`…`end` of the file's bytes replaced by `text`. `before`, `after`: the lines it is in, as one."""

    path: str
    line: int
    function: str
    start: int
    end: int
    text: str
    before: str
    after: str
    whole: Whole = None  # of a C function

    def applied(self, source):
        return source[:self.start] + self.text.encode() + source[self.end:]


@functools.cache
def headers_of_the_compiler():
    return subprocess.run(["gcc", "-print-file-name=include"], check=True, capture_output=True,
                          text=True).stdout.strip()


def definitions(cursor, path):
    """The functions that are defined in the file itself, and the constants of its namespaces."""
    for child in cursor.get_children():
        here = str(child.location.file) == str(path)
        if here and child.kind == Kind.NAMESPACE:
            yield from definitions(child, path)
        elif here and ((child.kind in DEFINITIONS and child.is_definition())
                       or (child.kind == Kind.VAR_DECL and cursor.kind == Kind.NAMESPACE)):
            yield child


def parsed(path, folders):
    language = ("-xc++", "-std=c++17") if path.suffix == ".cpp" else ("-xc", "-std=c11")
    unit = Index.create().parse(str(path), args=[
        *language, *(f"-I{folder}" for folder in folders), f"-isystem{headers_of_the_compiler()}"])
    errors = [str(found) for found in unit.diagnostics if found.severity >= 3]
    if errors:
        raise ValueError(f"{path}: {errors[0]}")
    return list(definitions(unit.cursor, path))


def whole_of(cursor):
    body = next(child for child in cursor.get_children() if child.kind == Kind.COMPOUND_STMT)
    return Whole(cursor.spelling, cursor.extent.start.offset, cursor.location.offset, body.extent.start.offset,
                 cursor.extent.end.offset, tuple(argument.spelling for argument in cursor.get_arguments()),
                 cursor.result_type.kind == TypeKind.VOID)


class Function:
    """Collects the edits of one function: (start, end, text) each."""

    def __init__(self, source, cursor):
        self.source = source
        self.path = str(cursor.location.file)
        self.edits = set()
        self.visit(cursor, None)

    def text(self, cursor):
        return self.source[cursor.extent.start.offset:cursor.extent.end.offset].decode()

    def between(self, left, right):
        """The operator, with the place where it stands."""
        start, end = left.extent.end.offset, right.extent.start.offset
        gap = self.source[start:end].decode()
        return gap.strip(), start + len(gap) - len(gap.lstrip())

    def replace(self, cursor, *texts):
        for text in texts:
            self.edits.add((cursor.extent.start.offset, cursor.extent.end.offset, text))

    def negate(self, cursor):
        """The sign of a whole value; of a sum and a constant there are other mutants of the kind."""
        spelling = cursor.type.get_canonical().spelling
        if spelling.removeprefix("const ") in (*WHOLE, "double") and not self.literal(cursor):
            self.replace(cursor, f"-({self.text(cursor)})")

    def literal(self, cursor):
        inner = [cursor]
        while inner and inner[0].kind in (Kind.UNEXPOSED_EXPR, Kind.PAREN_EXPR, Kind.UNARY_OPERATOR):
            inner = list(inner[0].get_children())
        return bool(inner) and inner[0].kind in (Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL)

    def visit(self, cursor, parent):
        if str(cursor.location.file) != self.path:  # of an included row
            return
        handler = getattr(self, cursor.kind.name.lower(), None)
        if handler:
            handler(cursor, list(cursor.get_children()), parent)
        # What C++ wraps around a call to end its temporaries is no expression of its own.
        wrapped = cursor.kind == Kind.UNEXPOSED_EXPR and parent is not None and parent.kind == Kind.COMPOUND_STMT
        for child in cursor.get_children():
            self.visit(child, parent if wrapped else cursor)

    def swap_operator(self, left, right, others):
        found, place = self.between(left, right)
        for other in others.get(found, ()):
            self.edits.add((place, place + len(found), other))
        return found

    def binary_operator(self, cursor, children, parent):
        left, right = children
        found = self.swap_operator(left, right, OPERATORS)
        if found in WITH_TERMS:
            self.replace(cursor, self.text(left), f"-({self.text(right)})" if found == "-" else self.text(right))
        elif found == "=":
            self.negate(right)
            self.drop(cursor, parent)

    def compound_assignment_operator(self, cursor, children, parent):
        self.swap_operator(*children, COMPOUND)
        self.drop(cursor, parent)

    def drop(self, cursor, parent):
        """A statement that stands for itself."""
        if parent.kind == Kind.COMPOUND_STMT:
            self.replace(cursor, "")

    def unary_operator(self, cursor, children, _):
        operand = self.text(children[0])
        operator = self.text(cursor).removesuffix(operand)
        if operator in ("-", "!"):
            self.replace(cursor, operand)
        elif self.text(cursor).endswith(("++", "--")):
            self.replace(cursor, self.text(cursor)[:-2] + ("--" if self.text(cursor).endswith("++") else "++"))

    def integer_literal(self, cursor, _, __):
        text = self.text(cursor)
        if text:
            one = "1U" if "unsigned" in cursor.type.spelling else "1"
            self.replace(cursor, f"({text} + {one})", f"({text} - {one})")

    def floating_literal(self, cursor, _, __):
        text = self.text(cursor)
        if text and float(text) != 0:
            self.replace(cursor, f"(2 * {text})", f"(0.9 * {text})")

    def call_expr(self, cursor, children, parent):
        name, arguments = cursor.spelling, [self.text(argument) for argument in cursor.get_arguments()]
        if name.startswith(("fx_sat", "fx_usat")):
            self.replace(cursor, f"({arguments[0]})")
        elif name in ("fx_clamp", "clamp"):
            prefix = "fx_" if name == "fx_clamp" else "std::"
            self.replace(cursor, f"({arguments[0]})", f"{prefix}max({arguments[0]}, {arguments[1]})",
                         f"{prefix}min({arguments[0]}, {arguments[2]})")
        elif name in NAMES and arguments:
            self.replace(cursor, *(f"({argument})" for argument in arguments),
                         f"{NAMES[name]}({', '.join(arguments)})")
        elif name == "fx_towards":
            self.replace(cursor, arguments[1])
        elif name == "fx_asr":
            self.replace(cursor, *(f"fx_asr({arguments[0]}, ({arguments[1]}) {step} 1U)" for step in "+-"))
        elif name == "fx_mla_32x16":
            self.replace(cursor, arguments[0], f"fx_mul_32x16({arguments[1]}, {arguments[2]})")
        self.drop(cursor, parent)

    def member_ref_expr(self, cursor, _, __):
        other = MIX_UPS.get(cursor.spelling)
        text = self.text(cursor)
        if other and text.endswith(cursor.spelling):
            self.replace(cursor, text.removesuffix(cursor.spelling) + other)

    def conditional_operator(self, cursor, children, _):
        condition, *branches = map(self.text, children)
        self.replace(cursor, f"({condition}) ? ({branches[1]}) : ({branches[0]})")

    def if_stmt(self, _, children, __):
        self.replace(children[0], f"!({self.text(children[0])})")

    def return_stmt(self, _, children, __):
        if children:
            self.negate(children[0])

    def var_decl(self, _, children, __):
        if children and children[-1].kind.is_expression():
            self.negate(children[-1])

    def init_list_expr(self, _, children, __):
        for child in children:
            designated = child.kind == Kind.UNEXPOSED_EXPR and list(child.get_children())
            value = list(child.get_children())[-1] if designated and self.text(child).startswith(".") else child
            self.negate(value)


def lines(source, start, end, replacement):
    """The lines of the edit without indentation and breaks, before and after it."""
    first, last = source.rfind(b"\n", 0, start) + 1, source.index(b"\n", end)

    def joined(text):
        return " ".join(text.decode().split())

    return joined(source[first:last]), joined(source[first:start] + replacement.encode() + source[end:last])


def of_rows(source, path, whole, folders):
    """A constant of a row that the function includes is one more or one less: its rows then stand in place of the #include."""
    for include in ROWS.finditer(source, whole.body, whole.end):
        name = include[1].decode()
        rows = next(folder / name for folder in folders if (folder / name).is_file()).read_text(encoding="utf-8")
        line = source.count(b"\n", 0, include.start()) + 1
        for row in ROW.finditer(rows):
            for number in NUMBER.finditer(row[0]):
                for step in "+-":
                    changed = f"{row[0][:number.start()]}({number[0]} {step} 1){row[0][number.end():]}"
                    yield Mutant(str(path), line, whole.spelling, include.start(), include.end(),
                                 rows[:row.start()] + changed + rows[row.end():], row[0].strip(), changed.strip(), whole)


def mutants(root, path, folders):
    """All mutants of a file of the project, in the order of the file."""
    source = (root / path).read_bytes()
    found = []
    for cursor in parsed(root / path, [root / folder for folder in folders]):
        whole = None if str(path).endswith(".cpp") else whole_of(cursor)
        for start, end, text in sorted(Function(source, cursor).edits):
            if source[start:end].decode() == text:
                continue
            before, after = lines(source, start, end, text)
            found.append(Mutant(str(path), source.count(b"\n", 0, start) + 1, cursor.spelling, start, end, text,
                                before, after, whole))
        found += of_rows(source, path, whole, [root / folder for folder in folders]) if whole else ()
    return found
