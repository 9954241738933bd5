# SPDX-License-Identifier: MIT
"""What source files say: functions and comments of C and C++, tests of Unity and of Python. By libclang and by ast.

C and C++ are parsed without what they include. So they need no build, take a few milliseconds each, and both sides of an
#ifdef are seen. Clang goes on after a name that it does not know. Three kinds of function are not found:

- `static FAST int32_t f(int32_t a) {}`: the head has a macro of another file in it;
- `void Class::method() {}`: the class stands in another header than the method's own;
- `int f(std::function<void(int)> each) {}`: without the names of another header it reads as a variable.
"""

import ast
import functools
from dataclasses import dataclass
from pathlib import Path

from clang.cindex import CursorKind as Kind
from clang.cindex import Index, TokenKind
from clang.cindex import TranslationUnit as Options

ALONE = 0x400 | 0x200  # CXTranslationUnit_SingleFileParse, CXTranslationUnit_KeepGoing: clang.cindex has no names for them
FUNCTIONS = {Kind.FUNCTION_DECL, Kind.FUNCTION_TEMPLATE, Kind.CXX_METHOD, Kind.CONSTRUCTOR}
SCOPES = {Kind.NAMESPACE, Kind.LINKAGE_SPEC, Kind.STRUCT_DECL, Kind.CLASS_DECL, Kind.CLASS_TEMPLATE}


@dataclass(frozen=True)
class Place:
    path: Path
    line: int

    def __str__(self):
        return f"{self.path}:{self.line}"


def functions(scope):
    """Those that are defined in it or in a scope that it holds."""
    for cursor in scope.get_children():
        if cursor.kind in FUNCTIONS and cursor.is_definition():
            yield cursor
        elif cursor.kind in SCOPES:
            yield from functions(cursor)


def unit(path):
    """A header and its source are one."""
    return path.with_suffix("")


@functools.cache
def parsed(language, files, about):
    """Defined functions (name, place) and comments (text, place) of the files (path, text) of a unit.

    They are parsed as one text: a source knows the classes of its header. Comments cost as much as the rest: only a text that
    the expression `about` finds something in is asked for them.
    """
    places = [Place(path, line) for path, text in files for line in range(1, text.count("\n") + 2)]
    text = "\n".join(text for _, text in files)
    whole = Index.create().parse("unit", ["-x", language, "-undef"], [("unit", text)], ALONE)
    tokens = whole.get_tokens(extent=whole.cursor.extent) if about.search(text) else ()
    return ([(cursor.spelling, places[cursor.location.line - 1]) for cursor in functions(whole.cursor)],
            [(token.spelling, places[token.location.line - 1]) for token in tokens if token.kind == TokenKind.COMMENT])


def units(root, folders, about):
    """What is parsed of each unit of the folders (folder → language)."""
    for folder, language in folders.items():
        files = {}
        for suffix in (".h", ".c", ".cpp"):
            for path in sorted((root / folder).rglob(f"*{suffix}")):
                files.setdefault(unit(path), []).append((path.relative_to(root), path.read_text(encoding="utf-8")))
        for of_unit in files.values():
            yield parsed(language, tuple(of_unit), about)


def unity_tests(path):
    """What TEST names in it."""
    options = ALONE | Options.PARSE_DETAILED_PROCESSING_RECORD | Options.PARSE_SKIP_FUNCTION_BODIES
    for cursor in Index.create().parse(path, ["-DTEST(test)=static void test(void)", "-undef"], options=options).cursor.get_children():
        if cursor.kind == Kind.MACRO_INSTANTIATION and cursor.spelling == "TEST":
            yield list(cursor.get_tokens())[2].spelling


def python_tests(path):
    for group in ast.parse(path.read_bytes()).body:
        if isinstance(group, ast.ClassDef):
            yield from (function.name for function in group.body
                        if isinstance(function, ast.FunctionDef) and function.name.startswith("test_"))


@functools.cache
def test_functions(path):
    return set(python_tests(path) if path.suffix == ".py" else unity_tests(path))
