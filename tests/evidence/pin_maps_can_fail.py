# SPDX-License-Identifier: MIT
"""evidence.pin_maps_can_fail: an nfconfig that accepts or refuses wrongly is found, and so is an image that is wired otherwise.

pin_maps_can_fail.py NFCONFIG IMAGE CLOCK: IMAGE is that of the B-G431B-ESC1.
"""

import random
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/bil"))

import pin_draw  # noqa: E402
import pin_maps  # noqa: E402
import pin_rules  # noqa: E402

NFCONFIG, IMAGE, CLOCK = (Path(argument).resolve() for argument in sys.argv[1:4])
NUMBER = 40


def sold():
    """The board that IMAGE is for."""
    draw = pin_draw.Draw(random.Random(1))
    tables = pin_draw.tomllib.loads((pin_draw.BOARDS / "b_g431b_esc1.toml").read_text(encoding="utf-8"))
    draw.base, draw.stage, draw.hal = pin_draw.AMPLIFIED, tables["board"], tables["hal"]
    return draw


class PinMapsCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def trial(self, changed=None):
        """Of some maps that are not built. `changed`: what stands for nfconfig."""
        trial = pin_maps.Trial(NFCONFIG, lambda one: None)
        with mock.patch.object(pin_maps, "made_by", changed or pin_maps.made_by):
            for one in pin_maps.drawn(NUMBER, 1, self.folder):
                trial.try_one(one)
        return trial

    def test_nfconfig_as_it_is_is_no_finding(self):
        trial = self.trial()
        self.assertEqual(trial.findings(), [])
        self.assertTrue(trial.accepted and trial.refused)

    def test_one_that_accepts_all_or_refuses_all_disagrees(self):
        wrong = len(self.trial(lambda *_: ("", "")).disagreements)
        right = len(self.trial(lambda *_: (None, "nfconfig: x")).disagreements)
        self.assertTrue(wrong and right)
        self.assertEqual(wrong + right, NUMBER)

    def refusals_with(self, old, new):
        def changed(*arguments):
            text, refusal = made_by(*arguments)
            return text, refusal.replace(old, new)

        made_by = pin_maps.made_by
        return self.trial(changed).bad_refusals

    def test_a_refusal_without_its_key_its_line_or_what_is_allowed_is_found(self):
        for old, new in ((": hal.", ": hal.x"), (".toml:", ".toml:1"), ("; allowed: ", ": "), (" = P", " = PX")):
            with self.subTest(old):
                self.assertTrue(self.refusals_with(old, new))

    def failure(self, **changes):
        """Of the sold board's image with another wiring around it."""
        draw = sold()
        draw.hal |= changes
        one = pin_maps.Map(draw, self.folder / "map.toml")
        self.assertEqual(one.problems, [])
        try:
            pin_maps.emulate(IMAGE, one, CLOCK)
        except pin_maps.Failed:
            return True
        return False

    def test_an_image_that_is_wired_otherwise_fails_in_the_emulator(self):
        self.assertFalse(self.failure())
        for changes in ({"bus_pin": "PA4"}, {"led_pin": "PC4"}, {"high_pins": ["PB5"]},
                        {"serial_pins": ["PB10", "PB11"]}, {"gate_low_polarity": "active_low"}, {"break_polarity": "active_low", "current_position": "in_line"},
                        {"gate_low_pins": ["PB13", "PA12", "PB15"]}):
            with self.subTest(changes):
                self.assertTrue(self.failure(**changes))

    def test_the_rules_refuse_each_way_to_be_wrong(self):
        self.assertEqual(pin_rules.Rules(sold().stage, sold().hal).problems(), [])
        for key, value in (("chip", "stm32g431"), ("crystal_hz", 9e6), ("bus_pin", "PB3"), ("bus_pin", "PA1"), ("bus_pin", "PB5"),
                           ("bus_pin", "pa0"), ("gate_high_pins", ["PA8", "PA9"]), ("gate_high_pins", ["PA8", "PA9", "PB5"]),
                           ("gate_low_pins", ["PA12", "PC13", "PB15"]), ("gate_enable_pins", ["PC13", "PA12", "PB15"]),
                           ("shunt_pins", ["PA1", "PA7"]), ("shunt_pins", ["PA7", "PA1", "PB0"]), ("break_pin", "PB12"),
                           ("break_pin", "PB5"), ("serial_pins", ["PB4", "PB3"]), ("led_pin", "PF0"), ("led_pin", "PA13")):
            with self.subTest(f"{key} = {value}"):
                self.assertTrue(pin_rules.Rules(sold().stage, sold().hal | {key: value}).problems())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
