# SPDX-License-Identifier: MIT
"""target.loop.identify: the image measures the motor that is connected to it, and names what is wrong where it cannot.

test_identify.py IMAGE BOARD CLOCK BIL_MOTOR MOTORSIM NFCONFIG [TEST...]: `identify` is typed at the console of images in
the emulator: IMAGE, whose motor is an example, and images of a user's motor file. The machine is that of BIL_MOTOR with
motor A, MOTORSIM evaluates the records. An emulated second of the board takes a core 2.2 to 3 s. A whole identification is
18 s of the board, a refusal 0.05 to 6 s.
"""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import machine
from copies import in_a_copy
from machine import LONGEST_TICKS, MIDDLE
from own_image import SHIPPED, build_image, replaced

IMAGE, BOARD, CLOCK, BIL_MOTOR, MOTORSIM, NFCONFIG = (Path(argument).resolve() for argument in sys.argv[1:7])

SCENARIO = "s1_robust"  # motor A
FULL_SCALE_A = 20
OPENS_TICKS = 40         # a command is taken once in a slow period
LEAST_A = 192 / 32768 * 2 * FULL_SCALE_A  # continuous current that shows: CURRENT_LEAST of identify.c
STANDS = "the rotor does not turn with the current: is it blocked, braked, or loaded?"
NAME_PLATE = """[motor]
name = "motor A, its name plate"
pole_pairs = 2
max_speed_rpm = 2000
max_current_a = 10
continuous_current_a = 8.4
"""


class Images:
    """In a folder of their own: images for a motor file of the user's, which is motor A's with some lines changed."""

    def __init__(self):
        made = tempfile.TemporaryDirectory()
        unittest.addModuleCleanup(made.cleanup)
        self.folder = Path(made.name)

    def image(self, *pairs):
        motor = self.folder / "motor.toml"
        motor.write_text(replaced(SHIPPED / "motors/motor_a.toml", *pairs), encoding="utf-8")
        return build_image(self.folder, NFCONFIG, motor, BOARD)


def setUpModule():
    global OWN_IMAGE
    OWN_IMAGE = Images().image()


class Bench(machine.Bench):
    """And what the console has said of the identification."""

    def __init__(self, image=None, settings=(), instant=True):
        super().__init__(image or OWN_IMAGE, BOARD, CLOCK, [BIL_MOTOR, SCENARIO, f"board={BOARD}", *settings], instant)

    def identify(self):
        self.board.type("identify")

    def end(self):
        """What it says in its last line, with open gates."""
        self.go_to("identify (done|refused)")
        self.tick(OPENS_TICKS)
        return re.search(r"identify (done|refused[^\r]*)", self.said)[1]


class Case(unittest.TestCase):
    def bench(self, **arguments):
        made = Bench(**arguments)
        self.addCleanup(made.close)
        return made

    def assert_safe(self, bench):
        self.assertFalse(bench.gates_on())
        self.assertEqual(bench.trips, 0)
        self.assertNotIn("FAULT", bench.said)

    def assert_refused(self, why, bench):
        bench.identify()
        self.assertEqual(bench.end(), f"refused: {why}")
        self.assert_safe(bench)


class Example(Case):
    def test_the_image_of_an_example_motor_measures_nothing(self):
        bench = self.bench(image=IMAGE)
        bench.identify()
        bench.go_to("example motor")
        self.assert_safe(bench)


# What is wrong → how: attributes of the bench, settings of the machine.
WRONG = {
    **{f"phase {name} is open": ({"broken": 1 << phase}, ()) for phase, name in enumerate("abc")},
    "no current flows: is the motor connected?": ({"broken": 7}, ()),
    **{f"the wires or the current sensors of phases {names} are exchanged": ({"sees": sees}, ())
       for names, sees in (("b and c", (0, 2)), ("a and c", (2, 1)), ("a and b", (1, 0)))},
    "a current sensor is reversed, or the wires or the sensors of all three phases are exchanged": ({"sees": (1, 2)}, ()),
    # a tenth of the continuous current
    "the noise of the current sensors is too large for the continuous current": (
        {"noise": 0.1 * 8.4 / FULL_SCALE_A * MIDDLE}, ()),
    "less than 3/4 of the resistance of the other phases, is the winding shorted: phase b": (
        {}, ["plant.shorted_turns_pct=[0,35,0]"]),
    "more than 5/4 of the resistance of the other phases, is a contact bad: phase c": ({}, ["plant.contact_ohm=[0,0,0.9]"]),
    # twice the torque of the continuous current
    STANDS: ({}, ["plant.coulomb_friction_nm=20"]),
}


class Wrong(Case):
    def test_a_fault_of_the_wiring_the_windings_or_the_rotor_is_named(self):
        for why, (connected, settings) in WRONG.items():
            with self.subTest(why):
                bench = self.bench(settings=settings)
                vars(bench).update(connected)
                self.assert_refused(why, bench)

    def test_a_load_that_turns_the_rotor_is_named(self):
        bench = self.bench()
        bench.identify()
        bench.go_to("pulses on each phase")
        bench.load_nm = 1.5 * 7.8
        for _ in range(LONGEST_TICKS):
            bench.tick()
            if not bench.gates_on():
                break
        bench.load_nm = 0.0
        self.assertEqual(bench.end(), "refused: more current flows than was asked for: does a load turn the rotor, or do the "
                                      "current sensors follow late?")
        self.assert_safe(bench)


class NamePlate(Case):
    """Motor files that do not say what motor A is."""

    @classmethod
    def setUpClass(cls):
        cls.image = Images().image

    def test_the_current_that_it_takes_is_said(self):
        small = self.image(("continuous_current_a = 8.4", f"continuous_current_a = {0.98 * LEAST_A:.4f}"))
        self.assert_refused("the continuous current of the name plate is too small for this board's sensors, "
                            "it takes at least 0.235 A", self.bench(image=small))

    def test_a_bus_too_low_for_the_speed_is_named(self):
        """A name plate of nine times the speed, for which the flux is taken to be small."""
        fast = self.image(("max_speed_rpm = 2000", "max_speed_rpm = 18000"), ("flux_linkage_wb = 0.387", "flux_linkage_wb = 0.04"),
                          ("rated_torque_nm = 7.8", "rated_torque_nm = 0.8"))
        self.assert_refused("the bus voltage is too low to turn the motor at 1/8 of its highest speed",
                            self.bench(image=fast))


class Measures(Case):
    """One whole identification, at the console's own baud rate; where the rotor begins to turn, copies of it fail."""

    @classmethod
    def setUpClass(cls):
        cls.run_ = Bench(instant=False)
        cls.addClassCleanup(cls.run_.close)
        cls.run_.identify()
        cls.run_.go_to("the shaft turns, up to")
        cls.run_.keep()
        cls.blocked = in_a_copy(lambda: cls.end_with(blocked=1))
        cls.run_.back()
        cls.ending = cls.run_.end()

    @classmethod
    def end_with(cls, **what):
        bench = cls.run_
        bench.board.chip.usart.instant = True
        bench.back()
        for name, value in what.items():
            setattr(bench, name, value)
        return f"{bench.end()} {bench.gates_on()} {bench.trips}"

    def test_a_blocked_rotor_is_named(self):
        self.assertEqual(self.blocked, f"refused: {STANDS} False 0")

    def test_it_comes_to_its_end_with_open_gates_and_without_a_fault(self):
        self.assertEqual(self.ending, "done")
        self.assert_safe(self.run_)

    def test_it_is_not_faster_than_was_said(self):
        said = int(re.search(r"up to (\d+) rpm", self.run_.said)[1])
        self.assertLessEqual(self.run_.most_rpm, said)

    def test_its_records_give_the_motor(self):
        truth = {"resistance_ohm": (2.125, 0.02), "inductance_d_h": (0.0116, 0.03), "inductance_q_h": (0.0116, 0.03),
                 "flux_linkage_wb": (0.387, 0.015), "inertia_kg_m2": (0.003, 0.05)}
        with tempfile.TemporaryDirectory() as folder:
            log, plate, out = (Path(folder) / name for name in ("console.log", "plate.toml", "found.json"))
            log.write_text(self.run_.said, newline="")
            plate.write_text(NAME_PLATE, encoding="utf-8")
            run = subprocess.run([MOTORSIM, "identify", "--records", log, "--motor", plate, "--board", BOARD, "--json", out],
                                 capture_output=True, text=True, check=False)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            found = json.loads(out.read_text())
        for key, (value, share) in truth.items():
            with self.subTest(key):
                self.assertLessEqual(abs(found[key]["value"] - value), found[key]["bar"], found[key])
                self.assertLessEqual(abs(found[key]["value"] / value - 1), share)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[7:]])
