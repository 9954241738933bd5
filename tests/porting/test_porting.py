# SPDX-License-Identifier: MIT
"""target.porting: a binding outside of the project is built as docs/porting.md says, for the PC and for a Cortex-M4.

test_porting.py NFCONFIG [TEST...]
"""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

NFCONFIG = Path(sys.argv[1]).resolve()
ROOT = Path(__file__).resolve().parents[2]
BINDING = Path(__file__).resolve().parent / "binding"
EXAMPLE = ROOT / "examples/own_board"
OF_EXAMPLE = ("main.c", "board.c", "board.h", "vectors.c", "own_board.ld")
GUIDE = (ROOT / "docs/porting.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"(?:^(?:    .*)?\n)+", re.MULTILINE)


def blocks():
    """The indented blocks of the guide, without their indentation."""
    for block in BLOCK.findall(GUIDE):
        yield "".join(line.removeprefix("    ") for line in block.strip("\n").splitlines(keepends=True)) + "\n"


COMMANDS = next(block for block in blocks() if block.startswith("build/host/nfconfig header"))
# In place of the firmware's own.
UNITS = """
#include "units.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

step_t units_step(const units_rotation_t *rotation, int32_t rpm)
{
    (void)rpm;
    printf("\\nrotation %" PRIu32 " %" PRIu32 "\\n", rotation->pole_pairs, rotation->tick_ps);
    exit(0);
}

uint32_t units_ticks(const units_rotation_t *rotation, uint32_t us)
{
    (void)rotation;
    return us;
}

int32_t units_hundredth_turns(const units_rotation_t *rotation, int32_t turns_q16)
{
    (void)rotation;
    return turns_q16;
}

int32_t units_rpm(const units_rotation_t *rotation, step_t step)
{
    (void)rotation;
    return step;
}

int32_t units_decihertz(const units_rotation_t *rotation, uint32_t halves, uint32_t ticks)
{
    (void)rotation;
    return (int32_t)(halves + ticks);
}

int64_t units_torque_base(const units_rotation_t *rotation, uint32_t current_full_scale_ua, uint32_t bus_full_scale_uv,
                          uint32_t speed_shift)
{
    (void)rotation;
    (void)speed_shift;
    return (int64_t)current_full_scale_ua + bus_full_scale_uv;
}

int32_t units_torque(int64_t base, int32_t torque_q28)
{
    (void)base;
    return torque_q28;
}

int32_t units_torque_q28(int64_t base, int32_t torque)
{
    (void)base;
    return torque;
}

int32_t units_thousandths(int32_t value, int32_t one, uint32_t base_millionths)
{
    (void)one;
    (void)base_millionths;
    return value;
}
"""


class Porting(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        shutil.copytree(BINDING, self.folder / "my_binding")
        for name in OF_EXAMPLE:
            shutil.copy(EXAMPLE / name, self.folder / "my_binding")

    def run_command(self, *command, cwd=None, **more):
        run = subprocess.run(command, cwd=cwd or self.folder, capture_output=True, text=True, check=False, **more)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return run.stdout

    def build(self, preset):
        self.run_command("cmake", "-S", ROOT, "--preset", preset, "-B", preset, "-DNF_HAL=./my_binding",
                         f"-DNF_NFCONFIG={NFCONFIG}", "-DBUILD_TESTING=OFF")
        self.run_command("cmake", "--build", preset, "--target", "mine")

    def compile(self, commands):
        """Without CMake, in a folder with nothing but what these name."""
        shutil.copytree(ROOT / "firmware", self.folder / "project/firmware")
        shutil.copytree(ROOT / "hal", self.folder / "project/hal")
        (self.folder / "project/build/host").mkdir(parents=True)
        (self.folder / "project/build/host/nfconfig").symlink_to(NFCONFIG)
        self.run_command("sh", "-e", "-c", commands, cwd=self.folder / "project")

    def test_for_the_pc_it_calibrates_and_enables_the_gates(self):
        """As it is told by its console."""
        self.build("host")
        said = self.run_command("./mine", cwd=self.folder / "host")
        self.assertRegex(said, r"^neurofoc: motor A .*\n(.+\n)*ok\nok\n(.+\n)*READY, speed unknown, asked 1000 rpm, ")

    def test_for_a_cortex_m4_it_is_an_image(self):
        self.build("cortex-m4")
        symbols = subprocess.run(["arm-none-eabi-nm", self.folder / "cortex-m4/mine.elf"], check=True,
                                 capture_output=True, text=True).stdout
        self.assertRegex(symbols, r"40010000 . board_registers\n")
        for name in ("board_conversions_complete", "device_vectors", "main"):
            self.assertRegex(symbols, rf" \w {name}\n")

    def test_the_sources_and_include_paths_of_the_guide_are_all_that_a_compiler_needs(self):
        self.compile(COMMANDS)
        self.run_command("./mine", cwd=self.folder / "project")

    def test_for_another_motor_and_board_it_asks_for_their_speed(self):
        """What makes rpm the firmware's unit gets their pole pairs and control tick, and not those of the example."""
        (self.folder / "my_binding/units.c").write_text(UNITS, encoding="utf-8")
        self.compile(COMMANDS.replace("--motor motor_a --board bench_310v", "--motor outrunner_24v --board b_g431b_esc1")
                     .replace("pretended.c", "pretended.c ../my_binding/units.c")
                     .replace("firmware/*/*.c", "firmware/[!a]*/*.c firmware/app/[!u]*.c"))
        run = subprocess.run(["./mine"], cwd=self.folder / "project", capture_output=True, text=True, check=False)
        self.assertRegex(run.stdout, r"\nrotation 7 50000000\n$")

    def test_the_guide_quotes_what_is_built(self):
        quoted = list(blocks())
        for path in (EXAMPLE / "main.c", BINDING / "CMakeLists.txt"):
            _, _, below_licence = path.read_text(encoding="utf-8").partition("\n")
            self.assertIn(below_licence, quoted, path)

    def configure_with(self, nfconfig):
        """Only configured, by a path relative to the folder in which cmake is called."""
        return subprocess.run(["cmake", "-S", ROOT, "--preset", "cortex-m4", "-B", "m4", "-DNF_HAL=./my_binding",
                               f"-DNF_NFCONFIG={nfconfig}"], cwd=self.folder, capture_output=True, text=True, check=False)

    def test_a_relative_path_of_nfconfig_is_of_the_folder_in_which_cmake_is_called(self):
        (self.folder / "tools").mkdir()
        (self.folder / "tools/nfconfig").symlink_to(NFCONFIG)
        run = self.configure_with("tools/nfconfig")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.run_command("cmake", "--build", "m4", "--target", "binding/mine_config/drive_config.h")

    def test_an_nfconfig_that_is_not_there_is_named_with_its_whole_path(self):
        run = self.configure_with("tools/nowhere")
        self.assertNotEqual(run.returncode, 0)
        self.assertIn(f"There is no {self.folder.resolve()}/tools/nowhere.", " ".join(run.stderr.split()))

    def test_a_folder_that_is_no_binding_is_named(self):
        for given, words in (("./nowhere", "there is no CMakeLists.txt in it"), ("nowhere", "a binding of your own")):
            run = subprocess.run(["cmake", "-S", ROOT, "--preset", "cortex-m4", "-B", f"bad{len(given)}", f"-DNF_HAL={given}",
                                  f"-DNF_NFCONFIG={NFCONFIG}"], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertNotEqual(run.returncode, 0)
            self.assertIn(words, " ".join(run.stderr.split()))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
