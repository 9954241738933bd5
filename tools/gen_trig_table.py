#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Write firmware/math/trig_table.c: the sine and arctangent tables behind trig.c.

    tools/gen_trig_table.py > firmware/math/trig_table.c

The committed file is checked against this script's output by a test.
"""
import math

SIN_ENTRIES_PER_TURN = 1024
FRACTION_BITS = 13
SLOPE_BITS = 12
ATAN_INTERVALS = 256


def sine_table():
    count = SIN_ENTRIES_PER_TURN + SIN_ENTRIES_PER_TURN // 4
    exact = [32767 * math.sin(2 * math.pi * k / SIN_ENTRIES_PER_TURN) for k in range(count + 1)]
    return [packed(left, right) for left, right in zip(exact, exact[1:])]


def packed(left, right):
    """The entry of firmware/math/trig_table.h: value and slope in one word."""
    modulus = 1 << SLOPE_BITS
    slope = round((right - left) * 2 ** 16 / 2 ** FRACTION_BITS)
    value = 2 ** 16 * (left + 0.5)
    return slope + modulus * round((value - slope) / modulus)


def atan_table():
    scale = 65536 / (math.pi / 4)
    return [min(65535, round(scale * math.atan(k / ATAN_INTERVALS))) for k in range(ATAN_INTERVALS + 1)]


def rsqrt_table():
    return [round(2 ** 15 / math.sqrt((k + 0.5) / 256)) for k in range(64, 256)]


def c_array(declaration, values, suffix=""):
    lines = []
    for start in range(0, len(values), 10):
        lines.append("    " + " ".join(f"{v}{suffix}," for v in values[start:start + 10]))
    return f"const {declaration}[{len(values)}] = {{\n" + "\n".join(lines) + "\n};\n"


def main():
    print("/* SPDX-License-Identifier: MIT */\n"
          "/* Written by tools/gen_trig_table.py; do not edit. */\n"
          "/* clang-format off */\n"
          '#include "trig_table.h"\n')
    print(c_array("int32_t trig_sin_table", sine_table()))
    print(c_array("uint16_t trig_atan_table", atan_table(), "U"))
    print(c_array("uint16_t trig_rsqrt_table", rsqrt_table(), "U"), end="")


if __name__ == "__main__":
    main()
