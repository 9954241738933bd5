"""gate.misra: cppcheck with its MISRA C:2012 addon over the firmware and target HALs."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import misra_register
import sources

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
args = parser.parse_args()

# The host's HAL runs on a PC and is not part of any product.
paths = [p for p in sources.files(args.root, "firmware/*.c", "hal/*.c")
         if not p.is_relative_to("hal/host")]
folders = sorted({p.parent for p in sources.files(args.root, "firmware/*.h", "hal/*.h")
                  if not p.is_relative_to("hal/host")})
tools = Path(sys.executable).parent
run = subprocess.run(
    [tools / "cppcheck", "--quiet", "--std=c11", "--language=c", "--platform=arm32-wchar_t4",
     "--check-level=exhaustive", "--enable=warning,style,performance,portability,information",
     "--addon=misra", "--inline-suppr", "--template={file}:{line}: {message} [{id}]",
     "--suppress=missingIncludeSystem", "--suppress=checkersReport",
     # Rule 10.1 says it too, and has a register for the places where it is meant.
     "--suppress=shiftNegativeLHS",
     *(f"--suppress=misra-c2012-{rule}" for rule in misra_register.disapplied(args.root)),
     *(f"-I{folder}" for folder in folders), *map(str, paths)],
    cwd=args.root, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    # cppcheck starts its addon with the first python3 of PATH.
    env={**os.environ, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"})
# The addon's message without the (licensed) rule texts says nothing. A suppression for all
# files ("nofile") may go unused; one at a line may not.
bad = [line.replace("misra violation (use --rule-texts=<file> to get proper output)", "MISRA")
       for line in run.stdout.splitlines() if line.strip() and not line.startswith("nofile:")]
if run.returncode and not bad:
    bad = [f"cppcheck ended with {run.returncode}"]
sources.finish("misra", bad, "Change the code, or tag and register a deviation: "
               f"{misra_register.REGISTER} says how.")
