"""gate.floors: includes go downwards only.

A firmware file includes its own floor or one below, a control module no other control
module, and hal.h is seen by the HAL and the app alone. The plant knows no firmware.
"""

import argparse
import re
from pathlib import Path

import sources

# Floors from the ground up: each folder may include itself and those it lists.
BELOW = {
    "firmware/math": ["firmware/math/port", "firmware/math/port/generic"],
    "firmware/math/port/generic": ["firmware/math"],
    "firmware/math/port": ["firmware/math"],
    "firmware/math/port/armv7m": ["firmware/math/port"],
    "firmware/math/port/armv7em": ["firmware/math/port"],
    "firmware/control": ["firmware/math"],
    "firmware/drive": ["firmware/math", "firmware/control"],
    "firmware/app": ["firmware/math", "firmware/control", "firmware/drive", "hal"],
    "hal": ["firmware/math", "firmware/control", "firmware/drive"],
    "host_sim/plant": [],
}
# A control module that is built of others; transforms gives the types of vectors.
BUILT_OF = {
    "current_loop": ["pi", "transforms"],
    "modulator": ["transforms"],
    "motion_loop": ["pi"],
    "nn_observer": ["transforms"],
    "phase_compensator": ["transforms"],
}
FREESTANDING = {"limits.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)


def finding(path, kind, name, homes):
    """Why `path` may not include `name`, or None. `homes`: header name -> its folder."""
    folder = path.parent.as_posix()
    if kind == "<":
        if folder.startswith("firmware/") and name not in FREESTANDING:
            return f"<{name}> is not for firmware"
        return None
    home = homes.get(Path(name).name)
    if home is None or (home != folder and home not in BELOW[folder]):
        return f'"{name}" ({home or "no floor"}) is not on a floor below {folder}'
    included = Path(name).stem
    if home == folder == "firmware/control" and included != path.stem:
        if included not in BUILT_OF.get(path.stem, []):
            return f'control module {path.stem} is not built of "{name}"'
    return None


def findings(root):
    paths = [p for p in sources.files(root, "*.c", "*.h") if p.parent.as_posix() in BELOW]
    everywhere = sources.files(root, "firmware/*.h", "hal/*.h", "host_sim/*.h")
    homes = {p.name: p.parent.as_posix() for p in everywhere}
    for path in paths:
        text = (root / path).read_text(encoding="utf-8")
        for match in INCLUDE.finditer(text):
            why = finding(path, *match.groups(), homes)
            if why:
                line = text.count("\n", 0, match.start()) + 1
                yield f"{path}:{line}: {why}"


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--root", type=Path, default=sources.ROOT)
args = parser.parse_args()
sources.finish("floors", list(findings(args.root)),
               "Include downwards only; the floors are listed in tools/gates/floors.py.")
