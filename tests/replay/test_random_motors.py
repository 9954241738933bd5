# SPDX-License-Identifier: MIT
"""replay.random_motors: whatever motor and board one buys, it is refused in the user's terms or it works as the shipped ones do.

test_random_motors.py TRY_MOTORS COMPILER [COUNT [SEED]]: TRY_MOTORS writes the files of COUNT motors of the zoo, reads them, records
and replays a run of each. COMPILER compiles board.c of the STM32G431 and about_t with the headers of each.
"""

import json
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import many_runs  # noqa: E402

TRY_MOTORS, COMPILER = sys.argv[1:3]
FEW, MANY = 300, 1000
COUNT = int(sys.argv[3]) if len(sys.argv) > 3 else MANY if many_runs.are_asked() else FEW
SEED = int(sys.argv[4]) if len(sys.argv) > 4 else 1
ROOT = Path(__file__).resolve().parents[2]
INCLUDES = ("hal", "firmware/app", "firmware/drive", "firmware/config", "firmware/protect", "firmware/control",
            "firmware/math", "firmware/math/port", "firmware/math/port/generic")

G431_CLOCK_HZ = 170_000_000
LEAST_FRAMES = 64  # the recorder's ticks behind a fault
# Half of a unit that a scale is recorded in: the tick of 25 us in ps, 0.5 A and 10 V in millionths.
TICK_ERROR = 0.5 / 25e6
SCALE_ERROR = 0.5 / 0.5e6


ABOUT = ("rotation.pole_pairs", "rotation.tick_ps", "current_full_scale_ua", "bus_full_scale_uv")
HAL = ("dead_time_ticks", "trip_count")
SHOWN = ABOUT + HAL
HEADERS = ("drive_config.h", "hal_config.h")


def all_boards(folders):
    """A program in C that is about_t and the macros of the headers of one after the other, and prints what they came to."""
    names = sorted({name for folder in folders for header in HEADERS
                    for name in re.findall(r"#define (\w+)", (folder / header).read_text())})
    forget = "".join(f"#undef {name}\n" for name in [*names, "DRIVE_CONFIG"])
    boards = "".join(
        f"{forget}#define DRIVE_CONFIG DRIVE_CONFIG_{folder.name}\n"
        + "".join(f'#include "{folder}/{header}"\n' for header in HEADERS)
        + "".join(f"static const unsigned HAL_{folder.name}_{name} = HAL_{name.upper()};\n" for name in HAL)
        + f'static const about_t ABOUT_{folder.name} = {{DRIVE_ABOUT}};\n' for folder in folders)
    form = " ".join(["%u"] * len(SHOWN))
    shown = "".join(
        '    printf("{}\\n", {});\n'.format(form, ", ".join([f"ABOUT_{folder.name}.{field}" for field in ABOUT]
                                                      + [f"HAL_{folder.name}_{name}" for name in HAL]))
        for folder in folders)
    return (f'#include "about.h"\n#include <stdbool.h>\n#include <stdio.h>\n{boards}\n'
            f"int main(void)\n{{\n{shown}    return 0;\n}}\n")


def written(folder, part):
    return tomllib.loads((folder / f"{part}.toml").read_text())[part]


class RandomMotors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        run = subprocess.run([TRY_MOTORS, cls.folder.name, "0", str(COUNT), str(SEED)], capture_output=True, text=True,
                             check=True)
        folders = [Path(cls.folder.name) / str(number) for number in range(COUNT)]
        outcomes = dict(zip(folders, map(json.loads, run.stdout.splitlines()), strict=True))
        cls.refused = [out["refused"] for out in outcomes.values() if "refused" in out]
        cls.accepted = {one: out for one, out in outcomes.items() if "refused" not in out}

    def test_each_is_accepted(self):
        self.assertEqual(self.refused, [])

    def test_each_recording_replays_to_the_same_hash(self):
        for folder, out in self.accepted.items():
            with self.subTest(folder.name):
                self.assertFalse(out["departs"], out)
                self.assertEqual(out["recorded_hash"], out["replayed_hash"])
                self.assertGreater(out["frames"], LEAST_FRAMES)

    def test_each_recording_has_the_scales_of_its_run(self):
        for folder, out in self.accepted.items():
            for name, error in (("rpm_of_a_step", TICK_ERROR), ("current_a", SCALE_ERROR),
                                ("voltage_v", SCALE_ERROR)):
                with self.subTest(folder.name, scale=name):
                    self.assertAlmostEqual(out["replayed_" + name] / out[name], 1, delta=error)

    def boards(self):
        folder = Path(self.folder.name)
        (folder / "boards.c").write_text(all_boards(self.accepted))
        run = subprocess.run(
            [COMPILER, "-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Werror", f"-I{folder}",
             *(f"-I{ROOT / include}" for include in INCLUDES), "-o", folder / "boards", folder / "boards.c"],
            capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr[:2000])
        lines = subprocess.run([folder / "boards"], capture_output=True, text=True, check=True).stdout.splitlines()
        return zip(self.accepted, (dict(zip(SHOWN, map(int, line.split()), strict=True)) for line in lines), strict=True)

    def test_each_board_compiles_to_what_its_files_say(self):
        for folder, made in self.boards():
            with self.subTest(folder.name):
                motor, board = written(folder, "motor"), written(folder, "board")
                half_period = G431_CLOCK_HZ / 2 / board["pwm_frequency_hz"]
                self.assertEqual(made["rotation.pole_pairs"], motor["pole_pairs"])
                self.assertAlmostEqual(made["rotation.tick_ps"] * board["pwm_frequency_hz"] / 1e12, 1,
                                       delta=0.5 / half_period + TICK_ERROR)
                self.assertAlmostEqual(made["current_full_scale_ua"] / 1e6, board["current_full_scale_a"], delta=1e-6)
                self.assertAlmostEqual(made["bus_full_scale_uv"] / 1e6, board["bus_full_scale_v"], delta=1e-6)
                self.assertGreaterEqual(made["dead_time_ticks"] / G431_CLOCK_HZ,
                                        board["dead_time_s"] * (1 - 1e-9))
                self.assertTrue(0 < made["trip_count"] < 4096)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
