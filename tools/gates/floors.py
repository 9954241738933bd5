# SPDX-License-Identifier: MIT
"""gate.floors: includes go downwards only and in no circle, as calls do, and registers are touched in target bindings only.

A firmware file includes its own floor or one below, a control module no other control
module, and hal.h is seen by the HAL and the app alone. The plant knows no firmware; the rest of the simulator
sees any of it.
A folder of firmware/, hal/ or host_sim/ that is no floor is a finding: nobody has said what it may include.
Outside of a target's binding nothing is volatile at an address: no pointer made of a number, no cast to a pointer to
volatile, no volatile object that the linker places.
circles.py says what a circle is, and who may write the state of the drive.
"""

import argparse
import re
from pathlib import Path

import circles
import sources

# Floors from the ground up: each folder may include itself and those it lists.
BELOW = {
    "firmware/math": ["firmware/math/port", "firmware/math/port/generic"],
    "firmware/math/port/generic": ["firmware/math"],
    "firmware/math/port": ["firmware/math"],
    "firmware/math/port/armv7m": ["firmware/math/port"],
    "firmware/math/port/armv7em": ["firmware/math/port"],
    "firmware/control": ["firmware/math"],
    "firmware/protect": ["firmware/math", "firmware/control"],
    "firmware/config": ["firmware/math", "firmware/control", "firmware/protect"],
    "firmware/drive": ["firmware/math", "firmware/control", "firmware/protect", "firmware/config"],
    "firmware/record": ["firmware/math", "firmware/protect", "firmware/drive"],
    "firmware/app": ["firmware/math", "firmware/control", "firmware/protect", "firmware/config", "firmware/drive",
                     "firmware/record", "hal"],
    "hal": ["firmware/math", "firmware/control", "firmware/drive"],
    "hal/cortex_m": [],
    "hal/host": ["firmware/drive", "hal", "host_sim/plant"],
    "hal/mps2": ["firmware/math", "firmware/drive", "firmware/record", "firmware/app", "hal", "hal/cortex_m"],
    "hal/stm32g4": ["firmware/math", "firmware/drive", "firmware/record", "firmware/app", "hal", "hal/cortex_m"],
    "host_sim/plant": [],
    "host_sim/zoo": ["host_sim/plant"],
}
CORE = [folder for folder in BELOW if folder.startswith("firmware/")]
CONFIG = ["host_sim/config", "host_sim/config/units"]
BELOW |= {
    "host_sim/config/units": ["firmware/math", "firmware/control", "firmware/protect", "firmware/config"],
    "host_sim/config": [*CORE, "host_sim/config/units", "host_sim/zoo", "host_sim/file"],
    "host_sim/file": [],
    "host_sim/program": [*CORE, *CONFIG, "host_sim/file"],
    "host_sim/sheet": [*CORE, *CONFIG, "host_sim/file", "host_sim/program"],
    "host_sim/reference": [*CORE, *CONFIG],
    "host_sim/run": [*CORE, "hal/host", "host_sim/plant", *CONFIG],
    "host_sim/identify": [*CORE, "host_sim/plant", *CONFIG, "host_sim/file", "host_sim/run"],
    "host_sim/peers": [*CORE, *CONFIG, "host_sim/run"],
    "host_sim/output": [*CORE, *CONFIG, "host_sim/file", "host_sim/run"],
    "host_sim/certify": [*CORE, "host_sim/plant", "host_sim/zoo", *CONFIG, "host_sim/run"],
    "host_sim/replay": [*CORE, *CONFIG, "host_sim/file", "host_sim/run", "host_sim/output"],
    "host_sim/debug": [*CORE, *CONFIG, "host_sim/file", "host_sim/reference", "host_sim/run", "host_sim/output"],
    "host_sim/commands": [*CORE, *CONFIG, "host_sim/file", "host_sim/program", "host_sim/run", "host_sim/identify", "host_sim/peers",
                          "host_sim/output", "host_sim/certify", "host_sim/replay", "host_sim/debug"],
    "host_sim/live": [*CORE, "hal/host", *CONFIG, "host_sim/file", "host_sim/run", "host_sim/identify", "host_sim/output",
                      "host_sim/replay", "host_sim/debug"],
    "host_sim/web": [*CORE, *CONFIG, "host_sim/run", "host_sim/identify", "host_sim/output", "host_sim/debug",
                     "host_sim/replay", "host_sim/live"],
}
FLOORED = ("firmware", "hal", "host_sim")  # their folders are floors, each of them
PROGRAMS = {Path("host_sim/motorsim.cpp"), Path("host_sim/nfconfig.cpp")}  # above all of the simulator's floors
TARGETS = ("hal/cortex_m", "hal/mps2", "hal/stm32g4")  # bindings and start-up of real chips
GENERATED = {"drive_config.h", "hal_config.h"}  # by nfconfig, for a binding's image
# A control module that is built of others; transforms gives the types of vectors.
BUILT_OF = {
    "absolute": ["shaft_trouble"],
    "align": ["inductance", "transforms"],
    "angle_sensor": ["rotor_position"],
    "current_loop": ["pi", "transforms"],
    "current_reference": ["current_loop", "motion_loop", "transforms", "weakening"],
    "encoder": ["shaft_trouble"],
    "flying_start": ["transforms"],
    "hall": ["shaft_trouble"],
    "inductance": ["transforms"],
    "model": ["current_loop", "nn_observer"],
    "modulator": ["transforms"],
    "motion_loop": ["pi"],
    "nn_observer": ["transforms"],
    "phase_compensator": ["transforms"],
    "probe": ["current_loop", "transforms"],
    "torque_filter": ["transforms"],
    "torque_loop": ["current_reference", "motion_loop"],
    "virtual_resistance": ["transforms"],
    "weakening": ["current_loop", "transforms"],
}
FREESTANDING = {"limits.h", "stdbool.h", "stddef.h", "stdint.h"}
REGISTER = re.compile(
    r"\(\s*(?:const\s+)?volatile\b[^()]*\*[^()]*\)"        # (volatile uint32_t *)
    r"|\([^()]*\bvolatile\s*\*[^()]*\)\s*[\w(]"            # (uint32_t volatile *)x
    r"|\([\w\s]+\*[\s*]*(?:const\s*)?\)\s*\(?\s*(?:0[xX][0-9a-fA-F]+|[1-9]\d*)"  # (uint32_t *)0x4000
    r"|\bextern\b[^;(]*\bvolatile\b")
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)


def finding(path, kind, name, homes):
    """Why `path` may not include `name`, or None. `homes`: header name -> the folders with one."""
    folder = path.parent.as_posix()
    if kind == "<":
        if folder.startswith("firmware/") and name not in FREESTANDING:
            return f"<{name}> is not for firmware"
        return None
    if name in GENERATED and folder.startswith("hal/"):
        return None
    found = homes.get(Path(name).name, set())
    if found.isdisjoint({folder, *BELOW[folder]}):
        return f'"{name}" ({", ".join(sorted(found)) or "no floor"}) is not on a floor below {folder}'
    included = Path(name).stem
    if folder == "firmware/control" and folder in found and included != path.stem:
        if included not in BUILT_OF.get(path.stem, []):
            return f'control module {path.stem} is not built of "{name}"'
    return None


def no_floor(paths):
    """Folders that nobody has given a floor."""
    for folder in sorted({p.parent.as_posix() for p in paths} - BELOW.keys()):
        yield f"{folder}: is no floor, so nothing says what it may include"


def registers(root, paths):
    """Places outside of the targets' bindings at which something like a register is touched."""
    for path in paths:
        if path.parent.as_posix() in TARGETS:
            continue
        text = sources.strip((root / path).read_text(encoding="utf-8"))
        for match in REGISTER.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            yield f"{path}:{line}: {' '.join(match.group().split())} reads as a register, outside of a target's binding"


def findings(root):
    floored = [p for p in sources.files(root, "*.c", "*.cpp", "*.h")
               if any(p.is_relative_to(top) for top in FLOORED) and p not in PROGRAMS]
    yield from no_floor(floored)
    yield from registers(root, floored)
    paths = [p for p in floored if p.parent.as_posix() in BELOW]
    everywhere = sources.files(root, "firmware/*.h", "hal/*.h", "host_sim/*.h", "firmware/*.def")
    homes = {}
    for path in everywhere:
        homes.setdefault(path.name, set()).add(path.parent.as_posix())
    for path in paths:
        text = (root / path).read_text(encoding="utf-8")
        for match in INCLUDE.finditer(text):
            why = finding(path, *match.groups(), homes)
            if why:
                line = text.count("\n", 0, match.start()) + 1
                yield f"{path}:{line}: {why}"
    yield from circles.findings(root)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
args = parser.parse_args()
sources.finish("floors", list(findings(args.root)),
               "Include downwards only; the floors are listed in tools/gates/floors.py. Registers are hal/'s.")
