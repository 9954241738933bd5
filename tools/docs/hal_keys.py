# SPDX-License-Identifier: MIT
"""The table of docs/configuration.md with the keys of [hal], out of `nfconfig keys hal`.

hal_keys.py NFCONFIG            says whether the page has what nfconfig prints; exit status 1 if not
hal_keys.py NFCONFIG --write    writes the table anew
"""
import argparse
import subprocess

import generated

PAGE = "docs/configuration.md"
PINS = 'a list of pins, such as ["PA8", "PA9", "PA10"]'  # wider than its column
KEY, ALLOWED, DEFAULT = 36, 36, 14  # characters of a column and the space after it


def cells(line):
    """Key, allowed values, default and meaning of a line of nfconfig."""
    key, rest = line[:KEY].strip().removeprefix("hal."), line[KEY:]
    width = len(PINS) + 1 if rest.startswith(PINS) else ALLOWED
    allowed, rest = rest[:width].strip(), rest[width:]
    return [f"`{key}`", "a list of pins" if allowed == PINS else allowed, f"`{rest[:DEFAULT].strip()}`", rest[DEFAULT:].strip()]


def table(printed):
    return generated.table(["key", "allowed", "default", "meaning"],
                           (cells(line) for line in printed.splitlines() if line.startswith("hal.")))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("nfconfig", help="the program")
    parser.add_argument("--write", action="store_true", help="write the table anew")
    args = parser.parse_args()
    printed = subprocess.run([args.nfconfig, "keys", "hal"], capture_output=True, text=True, check=True).stdout
    generated.finish(PAGE, {"hal": table(printed)}, "nfconfig", args.write)


if __name__ == "__main__":
    main()
