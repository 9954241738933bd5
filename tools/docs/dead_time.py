# SPDX-License-Identifier: MIT
"""The table of docs/design.md that says what dead-time compensation does on the switched plant.

dead_time.py MOTORSIM           says whether the page shows what is measured; exit status 1 if not
dead_time.py MOTORSIM --write   writes anew what has moved

A row that the page shows within a fifth of what is measured stays as it is. Without compensation most points sway at an
amplitude of their own, which any change moves: of those the table says no more than that the rotor is not held.
"""
import argparse
import sys
from pathlib import Path

import generated

sys.path.append(str(generated.ROOT / "tools"))

PAGE, NAME, SET = "docs/design.md", "dead time", "deadtime"
MARGIN = 0.2
HEADS = ["rpm, N·m", "THD, %", "ripple of i_q, A", "ripple of speed, rpm", "angle, °", "without compensation"]


def cells(result):
    return [f"{value:#.3g}".rstrip(".")
            for value in (result.thd_pct, result.iq_ripple_a, result.speed_ripple_rpm, result.angle_max_deg)]


def without(result):
    return "{} %, {} A, {} rpm, {}°".format(*cells(result)) if result.held else "not held"


def made(results):
    """The table of (with, without) pairs; a row that the page shows within the margin as it is shown."""
    rows = ([f"{given_back.point.speed_rpm}, {given_back.point.load_nm}", *cells(given_back), without(lost)]
            for given_back, lost in results if given_back.point.imperfections == SET)
    return generated.kept(PAGE, {NAME: generated.table(HEADS, rows)}, MARGIN)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("motorsim", type=Path, metavar="MOTORSIM", help="the simulator")
    parser.add_argument("--write", action="store_true", help="write the rows that have moved anew")
    args = parser.parse_args()
    from deadtime import measure  # takes a second to load
    generated.finish(PAGE, made(measure.measure(args.motorsim.resolve(), [SET]).results), "the simulator", args.write)


if __name__ == "__main__":
    main()
