# SPDX-License-Identifier: MIT
"""target.loop.sensed: a sensor of the shaft drives the motor of the image.

test_sensed.py BIL_PLANT MOTORSIM NFCONFIG CLOCK GDB FOLDER [TEST...]: images of FOLDER on their boards, each with a stored configuration
that has the sensor. The simulator's drive has the same inputs and has to demand the same in each tick, so its figures are those of
the image. An emulated second takes a core some 3 s: the cheapest tests are in each test run, all of them in the evidence.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
import unittest
from functools import lru_cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import many_runs
import scenario
from board import Board
from image_mailbox import Mailbox
from own_image import SHIPPED, build_image, replaced
from stored import stored
from wiring import Wiring

HERE = Path(__file__).resolve().parent
BIL_PLANT, MOTORSIM, NFCONFIG, CLOCK, GDB, FOLDER = (Path(argument).resolve() for argument in sys.argv[1:7])
ESC1, G474 = (SHIPPED / f"boards/{name}.toml" for name in ("b_g431b_esc1", "g474_in_line"))
BENCH_V, BENCH_A = 310, 20    # bus and full scale of motor B's board
RATED_A = 4.2                 # of motor B, amplitude
ID_A = 0.02                   # two counts of the converter, as S4 allows it
MIDDLE_DEG = 30               # of a Hall sector
ENCODER_LINES = 2048  # with 1024 a count is a quarter of the way of a tick, and the speed error 1.4 times that of the ideal angle
FIGURES = ("speed_error_max_pct", "speed_error_rms_rpm", "id_settled_a", "angle_error_max_deg", "command_error_settled_pct")
BOTH = {"drive.angle_source": "both", "startup.current_pct": 50}
ANGLES_DEG = (40, 0, 75, 195, 310) if many_runs.are_asked() else (40,)  # at 0 there is a Hall edge


def scaled(motor, volts, amperes):
    """The lines of a motor file on another scale: its time constants stay."""
    scales = {"resistance_ohm": volts / amperes, "inductance_d_h": volts / amperes, "inductance_q_h": volts / amperes,
              "flux_linkage_wb": volts, "rated_torque_nm": volts * amperes, "max_current_a": amperes, "inertia_kg_m2": volts * amperes}
    values = {key: value * scales.get(key, 1) if key != "name" else f'"{value}, scaled"' for key, value in motor.items()}
    return "".join(f"{line}\n" for line in ("[motor]", *(f"{key} = {value}" for key, value in values.items())))


class Case(unittest.TestCase):
    """Each sensor on a board that has it."""

    @classmethod
    def setUpClass(cls):
        made = tempfile.TemporaryDirectory()
        cls.addClassCleanup(made.cleanup)
        cls.folder = Path(made.name)

    @classmethod
    @lru_cache
    def board_of(cls, kind):
        """(image, board file). No shipped image has its pins for an incremental encoder."""
        if kind == "hall":
            return FOLDER / "neurofoc_esc1.elf", ESC1
        if kind == "absolute":
            return FOLDER / "neurofoc_g474.elf", G474
        file = cls.folder / "encoder.toml"
        lines = [line for line in ESC1.read_text(encoding="utf-8").splitlines() if line.startswith("hall_pins")]
        file.write_text(replaced(ESC1, (lines[0] + "\n", "")), encoding="utf-8")
        return build_image(cls.folder, NFCONFIG, "outrunner_24v", file), file

    @classmethod
    @lru_cache
    def motor_of(cls, kind):
        """(file of motor B on the scale of that board, scale of its currents)."""
        stage = tomllib.loads(cls.board_of(kind)[1].read_text(encoding="utf-8"))["board"]
        amperes = stage["current_full_scale_a"] / BENCH_A
        motor = tomllib.loads((SHIPPED / "motors/motor_b.toml").read_text(encoding="utf-8"))["motor"]
        file = cls.folder / f"motor_{kind}.toml"
        file.write_text(scaled(motor, stage["bus_nominal_v"] / BENCH_V, amperes), encoding="utf-8")
        return file, amperes

    def run_image(self, kind, scenario_file, motor, tuning, settings, **drawn):
        """The figures of the run; an image that differs from the simulator ends it."""
        image, file = self.board_of(kind)
        config = settings | {"sensor.kind": kind} | ({"sensor.lines": ENCODER_LINES} if kind.startswith("encoder") else {})
        board = Board(image, file, CLOCK, kept=scenario.COLD,
                      flashed=stored(NFCONFIG, Wiring(tomllib.loads(file.read_text(encoding="utf-8"))["hal"]).facts, motor, file, tuning, config))
        drawn = {"scenario.initial_angle_el_deg": MIDDLE_DEG} | drawn
        sets = [f"{key}={value}" for key, value in (config | {"motor": motor, "board": file, "tuning": tuning} | drawn).items()]
        results = self.folder / "figures.json"
        results.unlink(missing_ok=True)
        with subprocess.Popen([BIL_PLANT, scenario_file, "adc", "--json", results, *sets],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as plant:
            scenario.loop(plant, board, False, Mailbox(board, image, GDB))
            said = plant.stderr.read().decode()
        self.assertTrue(results.exists(), said)
        figures = json.loads(results.read_text(encoding="utf-8"))
        self.assertEqual(figures["faults"], [], said)
        print(kind, scenario_file.stem, *(f"{name} {figures[name]:.3g}" for name in FIGURES), flush=True)
        return figures

    def s4(self, kind, above_pct, **drawn):
        """The figures, and those of i_d as of motor B."""
        motor, amperes = self.motor_of(kind)
        figures = self.run_image(kind, HERE / "s4_scaled.toml", motor, "voltage_phase",
                                 BOTH | {"drive.observer_above_pct": above_pct}, **drawn)
        return figures, figures["id_settled_a"] / amperes

    @lru_cache
    def ideal(self, kind):
        """What the ideal angle gives on that board."""
        _, file = self.board_of(kind)
        run = subprocess.run([MOTORSIM, "run", HERE / "s4_scaled.toml", "--with", "adc", "--json", "-", "--set", f"motor={self.motor_of(kind)[0]}", "--set",
                              f"board={file}"], capture_output=True, text=True, check=True)
        return json.loads(run.stdout)


class Sensed(Case):
    """Each test takes some 10 s of a core or more."""

    def assert_as_ideal(self, kind, above_pct):
        """Within 1.2 of the ideal angle's figures; of i_d, of what S4 allows."""
        (figures, id_a), ideal = self.s4(kind, above_pct), self.ideal(kind)
        for name in ("speed_error_max_pct", "speed_error_rms_rpm"):
            self.assertLess(figures[name], 1.2 * ideal[name], name)
        self.assertLess(id_a, 1.2 * ID_A)

    def test_s4_with_hall_sensors_alone(self):
        figures, id_a = self.s4("hall", 0)
        self.assertLess(figures["speed_error_max_pct"], 2)
        self.assertLess(id_a, 0.03 * RATED_A)

    def test_s4_with_an_absolute_encoder(self):
        self.assert_as_ideal("absolute", 0)

    def test_s4_with_an_incremental_encoder(self):
        self.assert_as_ideal("encoder", 0)
        self.assert_as_ideal("encoder_index", 0)

    def test_s5_from_the_sensor_to_the_observer(self):
        """From 30 % of rated speed on the angle is the observer's."""
        for kind in ("hall", "absolute", "encoder"):
            with self.subTest(kind=kind):
                figures, id_a = self.s4(kind, 30)
                self.assertLess(figures["speed_error_max_pct"], 2)
                self.assertLess(id_a, 0.03 * RATED_A)


class Starts(Case):
    """From standstill, against a friction of half the rated torque, from anywhere."""

    def start(self, kind, motor, angle_deg, duration_s):
        figures = self.run_image(kind, HERE / "start_friction.toml", motor, "any", {"drive.angle_source": "both"},
                                 **{"scenario.initial_angle_el_deg": angle_deg, "scenario.duration_s": duration_s})
        self.assertLess(figures["command_error_settled_pct"], 2)

    def test_with_hall_sensors(self):
        for angle_deg in ANGLES_DEG:
            self.start("hall", "outrunner_24v", angle_deg, 0.3)

    def test_with_an_absolute_encoder(self):
        for angle_deg in ANGLES_DEG:
            self.start("absolute", "outrunner_48v", angle_deg, 0.5)


class HandOvers(Case):
    """Between sensor and observer."""

    def test_by_speed(self):
        for kind in ("hall", "absolute", "encoder"):
            with self.subTest(kind=kind):
                figures = self.run_image(kind, HERE / "hand_over.toml", self.motor_of(kind)[0], "any",
                                         BOTH | {"drive.observer_above_pct": 40})
                self.assertLess(figures["angle_error_max_deg"], 12)
                self.assertEqual(figures["state_final"], "RUN")

    def test_to_the_observer_when_the_wires_open(self):
        """In RUN, at speed: the pins' resistors pull up, and a counter stands still."""
        faults = {"hall": "what='sensor_high', value=7", "absolute": "what='sensor_high', value=65535", "encoder": "what='angle_stuck'"}
        for kind, fault in faults.items():
            with self.subTest(kind=kind):
                figures, _ = self.s4(kind, 0, **{"scenario.fault": f"[{{time_s=0.3, {fault}}}]"})
                self.assertEqual(figures["state_final"], "RUN")
                self.assertLess(figures["command_error_settled_pct"], 3)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[7:]])
