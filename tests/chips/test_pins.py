# SPDX-License-Identifier: MIT
"""chips.pins: what nfconfig knows of the pins of each chip, against facts that come from ST's data.

test_pins.py NFCONFIG [TEST...]. A board file is checked, and its registers are made, by this knowledge.
"""

import re
import subprocess
import sys
import unittest

import chip

NFCONFIG = sys.argv[1]
# What the binding uses; of these nothing may be missing in nfconfig.
USED = re.compile(r"TIM1_(CH[123]N?|BKIN)|TIM[234]_CH[1-4]|SPI[123]_(SCK|MISO|MOSI)|ADC[12]_IN\d+|OPAMP[123]_(VINP\d|VINM0|VOUT)|COMP[1-4]_INP\d|USART[123]_(TX|RX)|"
                  r"RCC_OSC_(IN|OUT)")
NAME = re.compile(r"(\w+)(?: \((\d+)\))?")


def listed(name):
    """{pin: {signal: its alternate function, or None}}"""
    text = subprocess.run([NFCONFIG, "pins", name], capture_output=True, text=True, check=True).stdout
    pins = {}
    for line in text.splitlines():
        pin, _, rest = line.partition(" ")
        names = [NAME.fullmatch(one.strip()).groups() for one in rest.split(",") if one.strip()]
        pins[pin] = {signal: int(function) if function else None for signal, function in names}
    return pins


def differences(pins, one):
    """Lines for what nfconfig and the facts of a chip have unlike; both ways."""
    for pin in sorted(pins.keys() ^ one.pins.keys()):
        yield f"{one.name} has {pin} in one of both only"
    for pin in sorted(pins.keys() & one.pins.keys()):
        used = {signal: function for signal, function in one.pins[pin].items() if USED.fullmatch(signal)}
        for signal in sorted(pins[pin].keys() | used.keys()):
            here, there = pins[pin].get(signal, "missing"), used.get(signal, "missing")
            if here != there:
                yield f"{one.name}, {pin}, {signal}: nfconfig has {here}, the facts {there}"


class Pins(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.chips = chip.read()

    def test_each_has_its_functions_and_no_others_on_each_chip(self):
        wrong, count = [], 0
        for one in self.chips:
            pins = listed(one.name)
            count += sum(map(len, pins.values()))
            wrong += differences(pins, one)
        print(f"{count} functions of pins, {len(self.chips)} chips: {len(wrong)} differences")
        self.assertEqual(wrong, [])

    def test_a_wrong_function_a_missing_one_and_a_pin_too_many_are_found(self):
        one = self.chips[0]
        for change, says in ((lambda pins: pins["PA8"].update(TIM1_CH1=5), "PA8, TIM1_CH1: nfconfig has 5, the facts 6"),
                             (lambda pins: pins["PA0"].pop("ADC2_IN1"), "PA0, ADC2_IN1: nfconfig has missing"),
                             (lambda pins: pins.update(PG9={}), "PG9 in one of both only")):
            pins = listed(one.name)
            change(pins)
            (line,) = differences(pins, one)
            self.assertIn(says, line)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
