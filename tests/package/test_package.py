# SPDX-License-Identifier: MIT
"""package.own_board: other projects find, fetch and pack this one, and examples/own_board turns its motor in each way.

test_package.py BUILD NFCONFIG
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

from platformio.fs import match_src_files

BUILD = Path(sys.argv[1]).resolve()
NFCONFIG = Path(sys.argv[2]).resolve()
ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples/own_board"
NAMES = ("--motor", "motor.toml", "--board", "board.toml")

FOREIGN = """\
cmake_minimum_required(VERSION 3.25)
project(foreign VERSION 1.0.0 LANGUAGES C)
set(CMAKE_MODULE_PATH ${CMAKE_CURRENT_SOURCE_DIR})
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(WITH)
    add_subdirectory(${WITH} neurofoc)
    foreach(target IN ITEMS core app plant)
        if(NOT TARGET neurofoc::${target})
            message(FATAL_ERROR "no neurofoc::${target}")
        endif()
    endforeach()
endif()
add_executable(foreign foreign.c)
"""


class Package(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.example = shutil.copytree(EXAMPLE, self.folder / "own_board")

    def call(self, *command, status=0, cwd=None, **environment):
        run = subprocess.run(command, cwd=cwd or self.folder, capture_output=True, text=True, check=False,
                             env={**os.environ, **environment})
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        return run.stdout + run.stderr

    def install(self):
        """A prefix that has been moved since it was installed."""
        self.call("cmake", "--install", BUILD, "--prefix", self.folder / "first")
        return (self.folder / "first").rename(self.folder / "prefix")

    def configure(self, source, build, *options, status=0):
        return self.call("cmake", "-S", source, "-B", build, "-G", "Ninja", *options, status=status)

    def fetch(self, build, nfconfig=NFCONFIG, status=0):
        return self.configure(self.example, build, f"-DFETCHCONTENT_SOURCE_DIR_NEUROFOC={ROOT}",
                              "-DFETCHCONTENT_TRY_FIND_PACKAGE_MODE=NEVER", f"-DNF_NFCONFIG={nfconfig}", status=status)

    def turns(self, program):
        """By its console: what it says on the way, and what the motor does in the end."""
        said = self.call(program)
        self.assertRegex(said, r"\nok\nok\n(.+\n)*RUN, speed \d+ of 2000 rpm, .*, bus 23\.999 V")
        self.assertRegex(said, r"\nown_board: 2000 rpm asked for, (19[89]\d|20[01]\d|2020) rpm turned\n$")


class Found(Package):
    def test_installed_it_turns_the_motor_on_the_pc(self):
        self.configure(self.example, "pc", f"-DCMAKE_PREFIX_PATH={self.install()}")
        self.call("cmake", "--build", "pc")
        self.turns("pc/own_board")

    def test_installed_it_is_an_image_for_a_cortex_m4_compiled_as_the_project_says(self):
        self.configure(self.example, "chip", f"-DCMAKE_PREFIX_PATH={self.install()}", "-DCMAKE_BUILD_TYPE=MinSizeRel",
                       "-DCMAKE_TOOLCHAIN_FILE=cortex_m4.cmake")
        self.call("cmake", "--build", "chip")
        symbols = self.call("arm-none-eabi-nm", "chip/own_board.elf")
        self.assertRegex(symbols, r"40010000 . board_registers\n")
        for name in ("board_conversions_complete", "control_isr", "drive_step", "device_vectors", "main"):
            self.assertRegex(symbols, rf" \w {name}\n")
        self.assertIn("Tag_ABI_VFP_args: VFP registers", self.call("arm-none-eabi-readelf", "-A", "chip/own_board.elf"))

    def test_the_installed_nfconfig_reads_the_data_that_were_installed_with_it(self):
        prefix = self.install()
        shutil.copy(EXAMPLE / "motor.toml", prefix / "share/neurofoc/host_sim/motors/only_installed.toml")
        self.assertIn(" only_installed ", self.call(prefix / "bin/nfconfig", "list", NEUROFOC_DATA=""))


class Fetched(Package):
    def test_as_source_it_turns_the_motor_on_the_pc_and_a_motor_without_a_magnet_fails(self):
        self.fetch("pc")
        self.call("cmake", "--build", "pc")
        self.turns("pc/own_board")
        bench = self.example / "bench.c"
        bench.write_text(re.sub(r"(\.flux_linkage_wb = )[\d.]+", r"\g<1>0.0", bench.read_text(encoding="utf-8")), encoding="utf-8")
        self.call("cmake", "--build", "pc")
        self.call("pc/own_board", status=1)

    def test_without_an_nfconfig_it_says_where_to_get_one(self):
        said = self.fetch("none", nfconfig=self.folder / "nowhere", status=1)
        self.assertRegex(said, r"There is no /.*/nowhere\.\s+Run `tools/dev build` in the sources of neurofoc")


class Added(Package):
    """To a project that does not use it."""

    def configure_foreign(self, build, *options):
        (self.folder / "CMakeLists.txt").write_text(FOREIGN, encoding="utf-8")
        (self.folder / "foreign.c").write_text("int main(void) { return 0; }\n", encoding="utf-8")
        for module in (ROOT / "tools/cmake").glob("*.cmake"):
            (self.folder / module.name).write_text('message(FATAL_ERROR "a module of the foreign project")\n', encoding="utf-8")
        self.configure(self.folder, build, *options)
        cache = (self.folder / build / "CMakeCache.txt").read_text(encoding="utf-8")
        commands = json.loads((self.folder / build / "compile_commands.json").read_text(encoding="utf-8"))
        foreign = next(entry["command"] for entry in commands if entry["file"].endswith("/foreign.c"))
        return set(re.findall(r"^([^#/\s][^:]*):", cache, re.MULTILINE)), foreign

    def test_it_adds_no_option_no_cache_variable_no_test_and_nothing_to_build(self):
        cache, command = self.configure_foreign("without")
        cache_with, command_with = self.configure_foreign("with", f"-DWITH={ROOT}")
        self.assertEqual(command_with, command)
        self.assertEqual(cache_with - cache,
                         {"WITH", "neurofoc_BINARY_DIR", "neurofoc_SOURCE_DIR", "neurofoc_IS_TOP_LEVEL"})
        self.assertIn("No tests were found", self.call("ctest", "--test-dir", "with"))
        self.call("cmake", "--build", "with")
        self.assertEqual(list((self.folder / "with/neurofoc").rglob("*.[ao]")), [])


class Packed(Package):
    def pack(self):
        """The package as PlatformIO makes and unpacks it."""
        archive = self.folder / "neurofoc.tar.gz"
        self.call(sys.executable, "-m", "platformio", "pkg", "pack", ROOT, "-o", archive,
                  PLATFORMIO_CORE_DIR=str(self.folder / "core"), PLATFORMIO_SETTING_ENABLE_TELEMETRY="no")
        with tarfile.open(archive) as packed:
            packed.extractall(self.folder / "package", filter="data")
        return self.folder / "package"

    def test_packed_by_platformio_it_turns_the_motor_on_the_pc(self):
        package = self.pack()
        example = package / "examples/own_board"
        self.call(NFCONFIG, "header", *NAMES, "--out", "drive_config.h", cwd=example)
        build = json.loads((package / "library.json").read_text(encoding="utf-8"))["build"]
        sources = [Path(build["srcDir"], name) for name in match_src_files(package / build["srcDir"], build["srcFilter"], ["c"])]
        plant = ROOT / "host_sim/plant"  # the bench's; it is no part of the package
        self.call("gcc", "-o", self.folder / "packed", *" ".join(build["flags"]).split(), *sources, f"-I{plant}",
                  *(example / name for name in ("main.c", "board.c", "bench.c")), *plant.glob("*.c"), "-lm", cwd=package)
        self.turns(self.folder / "packed")

    def test_the_versions_are_one(self):
        manifest = json.loads((ROOT / "library.json").read_text(encoding="utf-8"))
        project = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
        self.assertIn(f"project(neurofoc VERSION {manifest['version']} ", project)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
