# SPDX-License-Identifier: MIT
"""The macros of a C header, with their values as the compiler sees them."""

import re
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

MARKER = re.compile(r'# \d+ "([^"]*)"')
DEFINE = re.compile(r"#define (\w+)(\(?)(.*)")
COMPOSED = re.compile(r"[\s(]*[A-Za-z_]\w*(?:[\s()|]+[A-Za-z_]\w*)*[\s)]*")


@dataclass
class Macro:
    name: str
    body: str
    has_arguments: bool
    value: int = None  # None: it is no number

    def parts(self):
        """The macros of which it is made, if it is nothing but their sum."""
        return re.findall(r"\w+", self.body) if COMPOSED.fullmatch(self.body) else []


def defined(compiler, header):
    """The macros that this very file defines, in its order."""
    run = subprocess.run([compiler, "-E", "-dD", header], capture_output=True, text=True, check=True)
    found, inside = {}, False
    for line in run.stdout.splitlines():
        if marker := MARKER.match(line):
            inside = marker[1] == str(header)
        elif inside and (define := DEFINE.match(line)):
            name, bracket, rest = define.groups()
            # A body that begins with a bracket is separated by a space.
            found[name] = Macro(name, rest.strip() if not bracket else bracket + rest, bool(bracket))
    return found


def run_program(compiler, text, *options):
    """What a C program prints."""
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "print.c", Path(folder) / "print"
        source.write_text(text, encoding="utf-8")
        built = subprocess.run([compiler, "-w", *options, source, "-o", program], capture_output=True, text=True, check=False)
        if built.returncode:
            raise ValueError(built.stderr.strip())
        return subprocess.run([program], capture_output=True, text=True, check=True).stdout


def read(compiler, header):
    """{name: Macro} of a header, without the guard against being included twice."""
    header = Path(header).resolve()
    macros = {name: macro for name, macro in defined(compiler, header).items() if macro.body or macro.has_arguments}
    numbers = [name for name, macro in macros.items() if not macro.has_arguments]
    lines = "".join(f'    printf("{name} %llu\\n", (unsigned long long)({name}));\n' for name in numbers)
    said = run_program(compiler, f'#include <stdio.h>\n#include "{header}"\nint main(void)\n{{\n{lines}    return 0;\n}}\n')
    for line in said.splitlines():
        name, value = line.split()
        macros[name].value = int(value)
    return macros
