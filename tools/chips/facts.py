#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Facts of the chips that the project's binding serves, from the crate stm32-metapac: tests/chips/CHIP.json.

    tools/chips/facts.py                 compare the files of all chips with what the crate says now; exit status 1 and
                                         one line for each difference if they are not equal
    tools/chips/facts.py --write         write the files anew: after a change of src/main.rs or of the crate's version
    tools/chips/facts.py stm32g474re     this chip only

A chip is a feature of tools/chips/Cargo.toml, with a package letter as in its part number: to add one, add a line there
and call --write. Needs cargo 1.85 or later (rustup.rs, or a Debian package), and the network for 13 MB the first time.
The first chip takes about a minute, each other one some seconds. All that is built is in build/chips.

The crate (version 21.0.0, MIT or Apache 2.0, https://github.com/embassy-rs/stm32-data) is made from ST's data of the chips
by people who have nothing to do with this project. src/main.rs says what the files hold. The tests of the binding and of
the emulator read the files, so they need no cargo.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = ROOT / "tests/chips"
MANIFEST = HERE / "Cargo.toml"
LEAST_CARGO = (1, 85)
SHOWN = 20  # differences of one chip
OPEN_LEVELS = 3  # of nested objects that have a line for each member; so has a longer one
WIDTH = 200


class Unable(Exception):
    """The facts cannot be had here."""


def chips():
    """The names of all chips."""
    return sorted(manifest()["features"])


def crate():
    """Name and version."""
    return f"stm32-metapac {manifest()['dependencies']['stm32-metapac']['version'].lstrip('=')}"


def manifest():
    return tomllib.loads(MANIFEST.read_text(encoding="utf-8"))


def need_cargo():
    """Says what is missing before anything is built."""
    wanted = f"expected cargo {'.'.join(map(str, LEAST_CARGO))} or later: install it from https://rustup.rs"
    cargo = shutil.which("cargo")
    if cargo is None:
        raise Unable(f"there is no cargo; {wanted}")
    said = subprocess.run([cargo, "--version"], capture_output=True, text=True, check=False).stdout
    version = re.match(r"cargo (\d+)\.(\d+)", said)
    if not version or tuple(map(int, version.groups())) < LEAST_CARGO:
        raise Unable(f"found {said.strip() or cargo}; {wanted}")
    return cargo


def fresh(cargo, chip):
    """The facts as the crate gives them."""
    command = [cargo, "run", "--quiet", "--locked", "--manifest-path", str(MANIFEST), "--features", chip]
    target = {"CARGO_TARGET_DIR": str(ROOT / "build/chips")}
    run = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | target)
    if run.returncode:
        raise Unable(f"{chip}: cargo failed:\n{run.stderr.strip()}")
    facts = json.loads(run.stdout)
    if facts["chip"] != chip:
        raise Unable(f"cargo gave facts of {facts['chip']}; expected {chip}")
    return {"source": f"{crate()}, MIT or Apache 2.0, https://github.com/embassy-rs/stm32-data", **facts}


def in_order(name):
    """Numbers within names by value: PA2 comes before PA10."""
    return [(part.isdigit(), int(part) if part.isdigit() else 0, part) for part in re.split(r"(\d+)", name)]


def in_line(value):
    """JSON in order on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {in_line(value[key])}" for key in sorted(value, key=in_order)) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(in_line, value)) + "]"
    return json.dumps(value)


def laid_out(value, level=0):
    """JSON in order, with one line for each register, pin and interrupt."""
    is_leaf = not isinstance(value, dict) or not any(isinstance(member, (dict, list)) for member in value.values())
    line = in_line(value)
    if not isinstance(value, dict) or not value or is_leaf and level >= OPEN_LEVELS - 1 and len(line) <= WIDTH:
        return line
    members = (f"{json.dumps(key)}: {laid_out(value[key], level + 1)}" for key in sorted(value, key=in_order))
    inner = ",\n".join(" " * (level + 1) + member for member in members)
    return "{\n" + inner + "\n" + " " * level + "}"


def flat(value, path=""):
    """{path: value} of all that is no object."""
    if isinstance(value, dict):
        return {inner: leaf for key, member in value.items() for inner, leaf in flat(member, f"{path}/{key}").items()}
    if isinstance(value, list):
        return {inner: leaf for k, member in enumerate(value) for inner, leaf in flat(member, f"{path}/{k}").items()}
    return {path: value}


def differences(committed, now):
    """One line for each fact that differs."""
    before, after = flat(committed), flat(now)
    for path in sorted(before.keys() | after.keys(), key=in_order):
        old, new = before.get(path, "nothing"), after.get(path, "nothing")
        if old != new:
            yield f"{path[1:]}: the file has {old}, the crate {new}"


def file_of(chip, folder=FOLDER):
    return folder / f"{chip}.json"


def read(chip, folder=FOLDER):
    """The facts of the file."""
    try:
        return json.loads(file_of(chip, folder).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise Unable(f"{file_of(chip, folder)}: {error}; write it anew: tools/chips/facts.py --write {chip}") from None


def compared(chip, now, folder=FOLDER):
    """What is wrong with a file."""
    found = [f"{chip}: {line}" for line in differences(read(chip, folder), now)]
    if not found and file_of(chip, folder).read_text(encoding="utf-8") != laid_out(now) + "\n":
        found = [f"{chip}: the facts are equal, but the layout is another one"]
    return found


def say(text):
    print(text, file=sys.stderr, flush=True)


def each(names, said=say):
    """(chip, its facts from the crate), with progress."""
    cargo = need_cargo()
    for k, chip in enumerate(names, start=1):
        said(f"facts: {k} of {len(names)}: {chip}: is built ...")
        begin = time.monotonic()
        facts = fresh(cargo, chip)
        said(f"facts: {k} of {len(names)}: {chip}: {time.monotonic() - begin:.0f} s, {len(flat(facts))} facts")
        yield chip, facts


def main():
    parser = argparse.ArgumentParser(prog="tools/chips/facts.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("chips", nargs="*", metavar="CHIP", help=f"one or more of {', '.join(chips())}; default: all")
    parser.add_argument("--write", action="store_true", help="write the files instead of comparing them")
    args = parser.parse_args()
    unknown = sorted(set(args.chips) - set(chips()))
    if unknown:
        parser.error(f"found '{unknown[0]}'; allowed: {', '.join(chips())}")
    found = []
    try:
        for chip, facts in each(args.chips or chips()):
            if args.write:
                file_of(chip).write_text(laid_out(facts) + "\n", encoding="utf-8")
            else:
                found += compared(chip, facts)
    except Unable as reason:
        say(f"tools/chips/facts.py: {reason}")
        return 2
    for line in found[:SHOWN]:
        print(line)
    if not args.write:
        print(f"facts: {len(found)} differences between tests/chips and {crate()}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
