# SPDX-License-Identifier: MIT
"""scenario.identify_command: `motorsim identify` as its users meet it, of a simulated motor and of a board's records."""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
DONE, REFUSED, BAD_INPUT = 0, 1, 2
PLATE = """[motor]
name = "plate"
pole_pairs = 2
max_current_a = 10
continuous_current_a = 8
max_speed_rpm = 2000
"""
BOARD = "bench_310v"


def identify(folder, *args):
    return subprocess.run([MOTORSIM, "identify", *map(str, args)], cwd=folder, text=True, capture_output=True, check=False)


class Identify(unittest.TestCase):
    """Each test begins with a name plate, and with what a console has sent."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            done = identify(folder, "s1", "--motor", "motor_a", "--log", "console.log")
            assert done.returncode == DONE, done.stderr
            cls.console = Path(folder, "console.log").read_text(encoding="utf-8")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "plate.toml").write_text(PLATE, encoding="utf-8")
        (self.folder / "console.log").write_text(self.console, encoding="utf-8")
        self.before = self.content()

    def content(self):
        return {path.name: path.read_text(encoding="utf-8") for path in self.folder.iterdir()}

    def of_records(self, *args, records="console.log"):
        return identify(self.folder, "--records", records, "--motor", "plate.toml", "--board", BOARD, *args)

    def assert_refused(self, done, *messages):
        """One line, and the folder is as it was."""
        self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
        self.assertEqual((done.stdout, len(done.stderr.splitlines())), ("", 1), done.stderr)
        for message in messages:
            self.assertIn(message, done.stderr)
        self.assertEqual(self.content(), self.before)


class Records(Identify):
    def test_the_motor_file_is_written_beside_the_table(self):
        done = self.of_records("-o", "measured.toml")
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertRegex(done.stdout, r"(?m)^J +0\.00\d+ ")
        text = (self.folder / "measured.toml").read_text(encoding="utf-8")
        self.assertIn("of the records console.log", text)
        self.assertIn("[measured]", text)

    def test_the_temperature_is_that_of_the_winding(self):
        for temperature in (-5, 80):
            done = self.of_records("-o", f"{temperature}.toml", "--temperature", temperature)
            self.assertEqual(done.returncode, DONE, done.stderr)
            self.assertIn(f"temperature_c = {temperature}\n", (self.folder / f"{temperature}.toml").read_text(encoding="utf-8"))
        for temperature in ("300", "warm"):
            self.assert_refused_before(temperature)

    def assert_refused_before(self, temperature):
        done = self.of_records("--temperature", temperature)
        self.assertEqual((done.returncode, len(done.stderr.splitlines())), (BAD_INPUT, 1), done.stderr)
        self.assertIn("--temperature", done.stderr)

    def test_plate_and_board_are_needed(self):
        for args in ((), ("--motor", "plate.toml"), ("--board", BOARD)):
            self.assert_refused(identify(self.folder, "--records", "console.log", *args), "--records needs the name plate", "--board")

    def test_records_that_are_none_are_named(self):
        self.assert_refused(self.of_records(records="nowhere.log"), "nowhere.log: cannot read")
        self.assert_refused(self.of_records(records="plate.toml"), "plate.toml")
        (self.folder / "half.log").write_text(self.console[: len(self.console) // 2], encoding="utf-8")
        self.before = self.content()
        self.assert_refused(self.of_records(records="half.log"), "half.log")

    def table_of(self, log):
        """What the records in these bytes say."""
        (self.folder / "other.log").write_bytes(log)
        done = self.of_records(records="other.log")
        self.assertEqual(done.returncode, DONE, done.stderr)
        return done.stdout

    def test_what_a_terminal_program_adds_does_not_matter(self):
        table = self.table_of(self.console.encode())
        stamped = [f"[12:00:{k % 60:02}.{k:03}] {line}" for k, line in enumerate(self.console.splitlines())]
        self.assertEqual(self.table_of("\r\n".join(stamped).encode()), table)
        self.assertEqual(self.table_of("\n".join(line for line in stamped for _ in (1, 2)).encode()), table)
        for encoding in ("utf-8-sig", "utf-16", "utf-16-be"):
            self.assertEqual(self.table_of(self.console.encode(encoding)), table)

    def test_a_changed_digit_is_refused_with_its_line(self):
        lines = self.console.splitlines(keepends=True)
        for k in [number for number, line in enumerate(lines) if line.startswith("= ")][::10]:
            at = next(place for place, c in enumerate(lines[k]) if c.isdigit())
            changed = lines[k][:at] + str((int(lines[k][at]) + 1) % 10) + lines[k][at + 1 :]
            (self.folder / "changed.log").write_text("".join([*lines[:k], changed, *lines[k + 1 :]]), encoding="utf-8")
            self.before = self.content()
            self.assert_refused(self.of_records(records="changed.log"), f"changed.log:{k + 1}: the record's checksum is ")

    def test_a_scenario_beside_them_is_refused(self):
        self.assert_refused(self.of_records("s1"), "name a scenario", "--records")
        self.assert_refused(identify(self.folder), "name a scenario", "--records")

    def test_what_belongs_to_a_simulated_motor_is_refused(self):
        for args in (("--log", "copy.log"), ("--with", "adc")):
            self.assert_refused(self.of_records(*args), "--log and --with are for a simulated motor")


class Outputs(Identify):
    def test_a_motor_file_is_replaced_only_when_asked_for(self):
        (self.folder / "old.toml").write_text("of yesterday", encoding="utf-8")
        self.before = self.content()
        self.assert_refused(self.of_records("-o", "old.toml"), "old.toml: is there already; --overwrite")
        self.assert_refused(identify(self.folder, "s1", "-o", "old.toml"), "old.toml: is there already; --overwrite")
        self.assertEqual(self.of_records("-o", "old.toml", "--overwrite").returncode, DONE)
        self.assertNotEqual(self.content()["old.toml"], "of yesterday")

    def test_nothing_is_written_over_what_is_read(self):
        for option in ("--output", "--json"):
            for name in ("plate.toml", "console.log", "./console.log"):
                with self.subTest((option, name)):
                    self.assert_refused(self.of_records(option, name, "--overwrite"), option, name)

    def test_nothing_is_written_twice_to_a_file(self):
        self.assert_refused(self.of_records("-o", "x", "--json", "./x"), "x: --output and --json cannot go to the same file")
        for a, b in (("--output", "--log"), ("--json", "--log")):
            self.assert_refused(identify(self.folder, "s1", a, "x", b, "x"), f"x: {a} and {b} cannot go to the same file")

    def test_a_plate_of_a_simulated_motor_is_not_written_over(self):
        done = identify(self.folder, "s1", "--motor", "motor_a", "--json", "motor_a.json", "--overwrite")
        self.assertEqual(done.returncode, DONE, done.stderr)
        found = json.loads((self.folder / "motor_a.json").read_text(encoding="utf-8"))
        self.assertEqual(found["inertia_kg_m2"].keys(), {"value", "bar", "truth"})



class Script(Identify):
    """What of a scenario an identification has."""

    def test_a_fault_of_the_scenario_acts_also_late(self):
        for time_s, says in ((0.01, "phase a is open"), (6, "identify refused: ")):
            fault = f'scenario.fault=[{{time_s={time_s}, what="phase_a_open"}}]'
            done = identify(self.folder, "any", "--set", fault)
            self.assertEqual(done.returncode, REFUSED, done.stdout)
            self.assertIn(says, done.stderr)

    def test_commands_and_loads_are_refused(self):
        for list_name, entry in (("load", "torque_nm=1"), ("command", "speed_rpm=5"), ("request", "run=true")):
            done = identify(self.folder, "any", "--set", f"scenario.{list_name}=[{{time_s=1, {entry}}}]")
            self.assert_refused(done, f"--set scenario.{list_name}=", f"an identification has no {list_name} of a scenario")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
