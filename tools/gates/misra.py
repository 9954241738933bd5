# SPDX-License-Identifier: MIT
"""gate.misra: cppcheck with its MISRA C:2012 addon over the firmware and target HALs."""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import misra_register
import sources

SHARED = "cortex_m"  # part of every image
PORTS = Path("firmware/math/port")
BUILTINS = Path(__file__).with_name("compiler_builtins.h")
GENERATED = BUILTINS.with_name("generated")
PC = "host"          # the host's HAL is not part of any product
PORT_OF = {"stm32g4": "armv7em"}  # of a chip with one core
PORT_OF_OTHERS = "generic"
MATH = Path("firmware/math")  # what a port is to the rest: functions of the same declarations

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("--out", type=Path, help="write findings and files there, as JSON for tools/evidence/misra.py")
parser.add_argument("--headers", type=Path, action="append", default=[], help="folder of headers that the build makes of a board")
args = parser.parse_args()
if args.out:
    args.out.unlink(missing_ok=True)
tools = Path(sys.executable).parent


def binding_of(path):
    """The hardware binding that the file belongs to; None for what all images share."""
    _, *below = path.parts if path.is_relative_to("hal") else ("", "")
    return below[0] if len(below) > 1 and below[0] != SHARED else None


def check(files, port):
    """Findings in one program: rules on identifiers hold across its files."""
    folders = sorted({p.parent for p in files if p.suffix == ".h" and p.parent.parent != PORTS} | {port})
    run = subprocess.run(
        [tools / "cppcheck", "--quiet", "--std=c11", "--language=c", "--platform=arm32-wchar_t4",
         "--check-level=exhaustive", "--enable=warning,style,performance,portability,information",
         "--addon=misra", "--inline-suppr", "--template={file}:{line}: {message} [{id}]",
         "--suppress=missingIncludeSystem", "--suppress=checkersReport",
         # Rule 10.1 says it too, and has a register for the places where it is meant.
         "--suppress=shiftNegativeLHS",
         f"--include={BUILTINS}",
         *(f"--suppress=misra-c2012-{rule}" for rule in misra_register.disapplied(args.root)),
         *(f"-I{folder}" for folder in (*folders, GENERATED, *args.headers)), *(str(p) for p in files if p.suffix == ".c")],
        cwd=args.root, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        # cppcheck starts its addon with the first python3 of PATH.
        env={**os.environ, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"})
    # The addon's message without the (licensed) rule texts says nothing. A suppression for all
    # files ("nofile") may go unused; one at a line may not.
    bad = [line.replace("misra violation (use --rule-texts=<file> to get proper output)", "MISRA")
           for line in run.stdout.splitlines() if line.strip() and not line.startswith("nofile:")]
    return bad or ([f"cppcheck ended with {run.returncode}"] if run.returncode else [])


def programs():
    """(files, port): the image of each chip as a whole; of a binding that is no product, and of each port that none of them
    has, what is in reach of it alone."""
    bindings = sorted({binding_of(p) for p in every_file if p.suffix == ".c"} - {None}) or [None]
    whole_ones = set(PORT_OF) & set(bindings) or set(bindings)
    ports = {p.parent.name: p.parent for p in every_file if p.suffix == ".h" and p.parent.parent == PORTS}
    left = dict(ports)
    for binding in bindings:
        name = PORT_OF.get(binding, PORT_OF_OTHERS)
        left.pop(name, None)
        whole = [p for p in every_file if binding_of(p) in (None, binding)]
        of_it = whole if binding in whole_ones else [
            p for p in whole if binding_of(p) or p.suffix == ".h" or p.is_relative_to(MATH)]
        yield of_it, ports.get(name, Path("firmware"))
    for port in left.values():
        yield [p for p in every_file if p.is_relative_to(MATH)], port


every_file = [p for p in sources.files(args.root, "firmware/*.[ch]", "hal/*.[ch]") if binding_of(p) != PC]
findings = dict.fromkeys(line for program in programs() for line in check(*program))
if args.out:
    args.out.parent.mkdir(parents=True, exist_ok=True)
    args.out.write_text(json.dumps({"findings": list(findings), "files": [p.as_posix() for p in every_file]}, indent=1),
                        encoding="utf-8")
sources.finish("misra", list(findings), "Change the code, or tag and register a deviation: "
               f"{misra_register.REGISTER} says how.")
