# SPDX-License-Identifier: MIT
"""Each rule of the tuning `any` holds motors of the zoo that are lost, or swing, without it."""

import json
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
JOBS = 2
# The rule, the motor, and the value in place of the rule's: the number that motor A has, or what the torque alone
# would allow the speed loop, or what all the other rules would.
RULES = (
    ("speed bandwidth by the lag", "zoo:servo:33@11", ("speed_loop.bandwidth_hz=202",)),
    ("speed bandwidth by the dead time", "zoo:servo:3@2:user", ("speed_loop.bandwidth_hz=29",)),
    ("speed bandwidth by the dead time at low speed", "zoo:compressor:364@1:user",
     ("speed_loop.low_speed_bandwidth_hz=0",)),
    ("speed bandwidth by the reactance", "zoo:hub:63@11:user", ("speed_loop.bandwidth_hz=20",)),
    ("but a loop that answers to the load", "zoo:industrial:17@7", ("speed_loop.bandwidth_hz=7.9",)),
    ("observer by the speed loop", "zoo:industrial:29@11", ("observer.kappa=0.025", "observer.kappa_p=0.45")),
    ("gradient of the angle", "zoo:servo:105@21:user", ("observer.frame_share=0",)),
    ("current loop by the PWM", "zoo:compressor:64@2:user", ("current_loop.bandwidth_hz=500",)),
    ("least current by the dead time", "zoo:outrunner:97@11", ("current_loop.floor_pct=18",)),
    ("legs that commutate softly", "zoo:servo:243@21:user", ("model.output_capacitance_f=0",)),
    ("alignment above the hold", "zoo:16@11:user", ("startup.align_current_pct=0",)),
)

# What holds these motors is no setting: each was lost, or ended in a fault, before.
HELD = (
    ("less current for a salient rotor", "zoo:compressor:220@21:user"),
    ("less current where R·I hides the EMF", "zoo:gimbal:114@3:user"),
    ("torque axis first while braking", "zoo:servo:105@21:user"),
    ("no voltage twice behind the alignment", "zoo:industrial:131@21:user"),
)


def is_held(motor, settings=()):
    """Locked, and no limit cycle."""
    words = [word for setting in settings for word in ("--set", setting)]
    done = subprocess.run([MOTORSIM, "run", motor, "--json", "-", *words], capture_output=True, text=True, check=False)
    return json.loads(done.stdout)["accepted"]


class Rules(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with ThreadPoolExecutor(JOBS) as pool:
            cls.by_rule = list(pool.map(lambda row: is_held(row[1]), RULES))
            cls.without = list(pool.map(lambda row: is_held(row[1], row[2]), RULES))

    def test_a_motor_is_held_with_each_rule(self):
        for (rule, *_), held in zip(RULES, self.by_rule, strict=True):
            with self.subTest(rule=rule):
                self.assertTrue(held)

    def test_a_motor_is_held_without_a_setting_for_it(self):
        for what, motor in HELD:
            with self.subTest(what=what):
                self.assertTrue(is_held(motor))

    def test_and_is_not_without_it(self):
        for (rule, *_), held in zip(RULES, self.without, strict=True):
            with self.subTest(rule=rule):
                self.assertFalse(held)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
