# SPDX-License-Identifier: MIT
"""A saliency that the motor file does not know: the alignment measures L_d and L_q apart, and the drive is as good as if it knew."""

import json
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
JOBS = 2
INDUCTANCE = 0.0116  # of motor A
SCENARIOS = ("s1_robust", "s2_robust", "s3_robust")
SETS = ("ideal", "all")
TUNINGS = ("robust_motor_a", "any")
SALIENCIES = (0.7, 1.3, 1.5, 2.0)
# What a drive of the true file has may grow by so much, and by the scatter of a largest value of runs whose switching instants
# differ: one seed of `all` has 17 to 23 rpm of 1800 in s1_robust, another phase of the bus's ripple 15 to 21 in s2_robust.
GROWTH, SCATTER = 1.3, 0.4
FIGURES = ("speed_error_max_pct", "angle_error_max_deg")
# Without the measurement these end otherwise: a limit cycle, a lost rotor, a fault.
LOST = (("s3_robust", 1.6), ("s1_robust", 2.0), ("s3_robust", 2.0), ("s3_robust", 0.7))

CLASSES = ("gimbal", "outrunner", "hub", "servo", "compressor", "industrial")
EACH = 6
# R, L and L_q/L_d off the file as users' are, noise and gains of the sensors.
OFF_FILE = ("plant.resistance_scale=1.4", "plant.inductance_scale=0.85", "plant.adc_noise_lsb=1",
            "plant.adc_gain_error_pct=[1, -1]")
# Each gain makes 1 %. Four samples of the pulse make 1 % of noise, two of the step 0.5 %; twice that is rare. A rotor that
# swings through the whole alignment is not measured where it rests: zoo:gimbal:3 does, as its R is too large to damp.
NEAR, SHARE = 0.03, 0.9


def run(scenario, *words):
    done = subprocess.run([MOTORSIM, "run", scenario, "--json", "-", *words], capture_output=True, text=True, check=False)
    return json.loads(done.stdout)


def settings(*pairs):
    return [word for pair in pairs for word in ("--set", pair)]


def run_motor_a(tuning, scenario, imperfection, saliency, *more):
    return run(scenario, "--with", imperfection,
               *settings(f"tuning={tuning}", f"plant.saliency_scale={saliency}", *more))


def known(tuning, scenario, imperfection, saliency):
    return run(scenario, "--with", imperfection,
               *settings(f"tuning={tuning}", f"motor.inductance_q_h={INDUCTANCE * saliency}"))


def measured(motor):
    """L_d and L_q, estimated over actual, after a start."""
    name, saliency = motor
    still = ("scenario.duration_s=0.01", "scenario.command=[]", "scenario.load=[]")
    found = run("any", "--motor", name, *settings(*still, *OFF_FILE, f"plant.saliency_scale={saliency}"))["parameters"]
    return [found[key]["estimated"] / found[key]["actual"] for key in ("inductance_d_h", "inductance_q_h")]


class MotorA(unittest.TestCase):
    def test_figures_stay_near_those_of_a_file_that_knows_it(self):
        runs = [(tuning, scenario, imperfection, saliency) for tuning in TUNINGS for scenario in SCENARIOS
                for imperfection in SETS for saliency in SALIENCIES]
        with ThreadPoolExecutor(JOBS) as pool:
            found = pool.map(lambda each: run_motor_a(*each), runs)
            exact = pool.map(lambda each: known(*each), runs)
            for each, here, there in zip(runs, found, exact, strict=True):
                with self.subTest(run=each):
                    self.assertTrue(here["locked"] and not here["limit_cycle"])
                    for figure in FIGURES:
                        self.assertLessEqual(here[figure], GROWTH * there[figure] + SCATTER, figure)

    def test_without_the_measurement_they_do_not(self):
        for scenario, saliency in LOST:
            with self.subTest(scenario=scenario, saliency=saliency):
                found = run_motor_a("robust_motor_a", scenario, "ideal", saliency, "adaptation.saliency_pct=0")
                self.assertFalse(found["locked"])


class Zoo(unittest.TestCase):
    def test_both_inductances_are_measured_whatever_the_motor(self):
        motors = [(f"zoo:{name}:{number}", (0.8, 1.2)[number % 2]) for name in CLASSES for number in range(EACH)]
        with ThreadPoolExecutor(JOBS) as pool:
            found = dict(zip(motors, pool.map(measured, motors), strict=True))
        near = [motor for motor, ratios in found.items() if all(abs(ratio - 1) < NEAR for ratio in ratios)]
        self.assertGreaterEqual(len(near), SHARE * len(motors), found)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
