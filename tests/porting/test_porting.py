"""target.porting: a binding outside of the project is built as hal/PORTING.md says, for the PC and for a Cortex-M4.

test_porting.py NFCONFIG
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
GUIDE = (ROOT / "hal/PORTING.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"(?:^(?:    .*)?\n)+", re.MULTILINE)


def blocks():
    """The indented blocks of the guide, without their indentation."""
    for block in BLOCK.findall(GUIDE):
        yield "".join(line.removeprefix("    ") for line in block.strip("\n").splitlines(keepends=True)) + "\n"


class Porting(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        shutil.copytree(BINDING, self.folder / "my_binding")

    def run_command(self, *command, cwd=None, **more):
        run = subprocess.run(command, cwd=cwd or self.folder, capture_output=True, text=True, check=False, **more)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    def build(self, preset):
        self.run_command("cmake", "-S", ROOT, "--preset", preset, "-B", preset, "-DNF_HAL=./my_binding",
                         f"-DNF_NFCONFIG={NFCONFIG}", "-DBUILD_TESTING=OFF")
        self.run_command("cmake", "--build", preset, "--target", "mine")

    def test_for_the_pc_it_calibrates_and_enables_the_gates(self):
        self.build("host")
        self.run_command("./mine", cwd=self.folder / "host")

    def test_for_a_cortex_m4_it_is_an_image(self):
        self.build("cortex-m4")
        symbols = subprocess.run(["arm-none-eabi-nm", self.folder / "cortex-m4/mine.elf"], check=True,
                                 capture_output=True, text=True).stdout
        self.assertRegex(symbols, r"40010000 . mine_registers\n")
        for name in ("mine_conversions_complete", "device_vectors", "main"):
            self.assertRegex(symbols, rf" \w {name}\n")

    def test_the_sources_and_include_paths_of_the_guide_are_all_that_a_compiler_needs(self):
        commands = next(block for block in blocks() if block.startswith("build/host/nfconfig header"))
        shutil.copytree(ROOT / "firmware", self.folder / "project/firmware")
        shutil.copytree(ROOT / "hal", self.folder / "project/hal")
        (self.folder / "project/build/host").mkdir(parents=True)
        (self.folder / "project/build/host/nfconfig").symlink_to(NFCONFIG)
        self.run_command("sh", "-e", "-c", commands, cwd=self.folder / "project")
        self.run_command("./mine", cwd=self.folder / "project")

    def test_the_guide_quotes_what_is_built(self):
        quoted = list(blocks())
        for name in ("main.c", "CMakeLists.txt"):
            self.assertIn((BINDING / name).read_text(encoding="utf-8"), quoted, name)

    def test_a_folder_that_is_no_binding_is_named(self):
        for given, words in (("./nowhere", "there is no CMakeLists.txt in it"), ("nowhere", "a binding of your own")):
            run = subprocess.run(["cmake", "-S", ROOT, "--preset", "cortex-m4", "-B", f"bad{len(given)}", f"-DNF_HAL={given}",
                                  f"-DNF_NFCONFIG={NFCONFIG}"], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertNotEqual(run.returncode, 0)
            self.assertIn(words, " ".join(run.stderr.split()))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
