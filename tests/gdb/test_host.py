# SPDX-License-Identifier: MIT
"""gdb on motorsim: what it shows of a tick is what the stepper shows. test_host.py GDB MOTORSIM"""

import re
import sys
import unittest

import support

sys.path.insert(0, str(support.ROOT / "tools/gdb"))
from nfgdb import table  # noqa: E402: its folder is known from here on

GDB, MOTORSIM = sys.argv[1:]
TICK = 3000  # the motor runs
STEP = f"step-isr {TICK + 2}"  # the first entry is before tick 0
TURN = 2**32
# All of a struct that is no struct, array or pointer.
LEAVES = """python
def leaves(kind, path=""):
    plain = kind.strip_typedefs()
    if plain.code == gdb.TYPE_CODE_STRUCT:
        for field in plain.fields():
            yield from leaves(field.type, path + "." + field.name if path else field.name)
    elif plain.code == gdb.TYPE_CODE_ARRAY:
        for k in range(plain.range()[1] + 1):
            yield from leaves(plain.target(), f"{path}[{k}]")
    elif plain.code != gdb.TYPE_CODE_PTR:
        yield path
end"""


class OnTheHost(support.GdbTest):
    """A run of s1."""

    MOTORSIM, CHOICE = MOTORSIM, ("s1",)
    GDB = (GDB, "--args", MOTORSIM, "run", "s1")

    def test_step_isr_and_stages_show_the_tick_that_motorsim_shows(self):
        first, there, shown, after = self.gdb(["step-isr", f"step-isr {TICK + 1}", "stages", "step-isr"])
        self.assertEqual(first.strip(), "before the first tick  INIT")
        self.assertEqual(there.strip(), f"tick {TICK}  RUN")
        self.assertEqual(after.strip(), f"tick {TICK + 1}  RUN")
        self.assert_same_stages(shown, TICK)

    def test_words_of_each_format_are_shown_in_their_units(self):
        names = ("control.current_ref.q", "bus", "rotor.observer.alpha_q27", "rotor.observer.gradient",
                 "rotor.observer.rho_q13", "rotor.position.turns_q32", "modulator.inverse_bus_q12",
                 "control.current_loop.pi_q.integral_q26", "motion.speed_loop.pi.integral_q26", "motor.model.flux_q30",
                 "motor.model.resistance_q14", "control.ratio_acting.alpha")
        for name, shown in zip(names, self.gdb([STEP, *(f"print app->drive.{name}" for name in names)])[1:]):
            with self.subTest(name):
                self.assert_shows(shown, f"drive.{name}", TICK)
        for name, shown in zip(("adc_ia", "adc_bus"), self.gdb([STEP, "print app->in.adc_ia",
                                                                "print app->in.adc_bus"])[1:]):
            self.assert_shows(shown, f"in.{name}", TICK)

    def test_vectors_speeds_angles_and_states_say_what_they_are(self):
        vector, raws, speed, raw_speed, angle, raw_angle, state, fault = self.gdb(
            [STEP, "print app->drive.control.voltage", "print/r app->drive.control.voltage",
             "print app->drive.rotor.observer.speed", "print/r app->drive.rotor.observer.speed",
             "print (angle_t)app->drive.rotor.position.turns_q32",
             "print/r (angle_t)app->drive.rotor.position.turns_q32", "print app->drive.state",
             "print app->drive.fault.id"])[1:]
        d, q = map(int, re.search(r"d = (-?\d+), q = (-?\d+)", raws).groups())
        self.assertIn(f"= d {d / 2**15 * 450:.6g} V, q {q / 2**15 * 450:.6g} V (raw {d}, {q}; Q15 of U_b = 450 V)",
                      vector)
        step = int(raw_speed.split("=")[1])
        rpm = step / TURN * 10000 / 2 * 60
        self.assertIn(f"= {rpm:.6g} rpm, {step / TURN * 10000 * 6.283185307179586:.6g} rad/s el (raw {step})",
                      speed)
        turn = int(raw_angle.split("=")[1])
        degrees = (turn if turn < TURN // 2 else turn - TURN) / TURN * 360
        self.assertIn(f"= {degrees:.6g} deg el (raw {turn})", angle)
        self.assertEqual(state.split("=")[1].strip(), "RUN")
        self.assertEqual(fault.split("=")[1].strip(), "NONE")

    def test_a_word_without_a_place_in_the_table_is_shown_by_its_name_or_type(self):
        guard, sine = self.gdb([STEP, "print app->drive.start.flying_start", "print (sincos_t){16384, -8192}"])[1:]
        self.assertIn("speed = 0 rpm, 0 rad/s el (raw 0)", guard)
        self.assertIn("sin 0.5, cos -0.25 (raw 16384, -8192; as Q15)", sine)

    def test_within_a_tick_stages_say_so(self):
        stopped, shown = self.gdb([STEP, "break drive_step", "continue", "stages"])[2:]
        self.assertIn("drive_step", stopped)
        self.assertRegex(shown, rf"^tick {TICK}  RUN, and within the next: ")

    def test_the_table_has_every_word_of_the_firmware(self):
        loaded = table.load(["s1"], MOTORSIM)
        known = {(word.home, word.member) for word in loaded.words.values()}
        homes = {"drive": "drive_t", "in": "drive_in_t", "out": "drive_out_t", "cfg": "drive_cfg_t"}
        for (home, name), listed in zip(homes.items(), self.gdb(
                [f"python for name in leaves(gdb.lookup_type('{name}')): print(name)" for name in homes.values()],
                [LEAVES])):
            members = {(home, member) for member in listed.split()}
            self.assertGreater(len(members), 3)
            self.assertEqual(sorted(members - known), [], name)

    def test_another_stop_on_the_way_is_told(self):
        stopped = self.gdb(["break drive_init", "step-isr"])[1]
        self.assertIn("drive_init", stopped)

    def test_scales_chosen_before_the_start_are_checked_at_the_first_tick(self):
        chosen, refused, own = self.gdb(["scales s2_motor_b", "step-isr", "print app->drive.bus"])
        self.assertIn("s2_motor_b: I_b", chosen)
        self.assertRegex(refused, "^scales: the drive's configuration has crc")
        self.assertIn("U_b = 450 V", own)

    def test_bad_commands_get_one_line(self):
        wrong = self.gdb(["stages", "step-isr 0", "step-isr x", "scales", "scales nope", STEP, "stages now",
                          "scales s2_motor_b", "stages"])
        self.assertEqual(wrong[0].strip(), "there is no drive yet: `step-isr` runs to its first tick")
        self.assertIn("from 1 to 1000000000, found '0'", wrong[1])
        self.assertIn("found 'x'", wrong[2])
        self.assertIn("scenario is required", wrong[3])
        self.assertIn('scenario = "nope": not found', wrong[4])
        self.assertIn("'now' is one word too many", wrong[6])
        self.assertRegex(wrong[7], r"scales: the drive's configuration has crc 0x[0-9a-f]{8}, that of s2_motor_b 0x")
        for answer in wrong[:5] + wrong[6:8]:
            self.assertEqual(answer.strip().count("\n"), 0, answer)


class OfTheVoltageDrive(support.GdbTest):
    """A run of s4 that goes without current regulators after a tenth of a second."""

    MOTORSIM = MOTORSIM
    CHOICE = ("s4", "--set", "scenario.initial_speed_rpm=1200", "--set", "voltage_loop.settle_s=0.01")
    GDB = (GDB, "--args", MOTORSIM, "run", *CHOICE)

    def test_stages_are_those_of_the_voltage_drive(self):
        tick = 3000
        shown = self.gdb([f"step-isr {tick + 2}", "stages"])[1]
        self.assert_same_stages(shown, tick)
        self.assertIn("drive.voltage_drive.compensator.angle", shown)
        self.assertIn("in.angle", shown)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
