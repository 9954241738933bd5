# SPDX-License-Identifier: MIT
"""tools/dev with stand-ins for what it calls. Each command: it gets to its end, and what it calls is in the project. demo:
what it builds, and what it says of runs that do not hold. quick: what it builds and runs, and that a failure ends it."""

import fcntl
import os
import re
import shutil
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HOLDS, BROKEN = 0, 1
CONTRAST = "phase_compensator.lead_max_deg"  # of the one run that is meant to break its limits

MOTORSIM = f"""#!/bin/sh
echo "$@" >>runs.log
case "$*" in
    *{CONTRAST}*) echo 's4: id_settled_a = 3.5, limit: 0.05' >&2; exit $CONTRAST_STATUS ;;
    *) exit $STATUS ;;
esac
"""
SCRIPTS = sorted(path.name for path in (ROOT / "tools/setup").iterdir() if os.access(path, os.X_OK))
RECORDER = '#!/bin/sh\necho "$@" >>"$LOG"\n'
# Takes a file of the project for its word only if there is one.
STRICT = f"""#!/bin/sh
for word; do
    case "$word" in
        tools/web/node_modules/* | */all) ;;
        tools/* | tests/*) [ -e "{ROOT}/$word" ] || {{ echo "there is no $word" >&2; exit 127; }} ;;
    esac
done
"""


class Dev(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        (self.root / "tools").mkdir()
        shutil.copy(ROOT / "tools/dev", self.root / "tools/dev")
        shutil.copy(ROOT / "CMakePresets.json", self.root)
        for name in ("tools/requirements.txt", "tools/requirements_checks.txt"):
            self.write(name, "")
        for name in (*(f"tools/setup/{name}" for name in SCRIPTS), ".cache/venv/bin/python"):
            self.script(name, "#!/bin/sh\n")
        self.built()
        self.script("bin/cmake", RECORDER)
        self.script("bin/ctest", RECORDER + "exit $STATUS\n")

    def built(self):
        self.script("build/host/gaindesign", "#!/bin/sh\n")
        self.script("build/host/motorsim", MOTORSIM)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def script(self, name, text):
        path = self.write(name, text)
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    def dev(self, command, status=HOLDS, contrast=BROKEN):
        environment = {**os.environ, "PATH": f"{self.root / 'bin'}:{os.environ['PATH']}", "LOG": str(self.root / "cmake.log"),
                       "STATUS": str(status), "CONTRAST_STATUS": str(contrast)}
        words = [command] if isinstance(command, str) else command
        return subprocess.run([self.root / "tools/dev", *words], env=environment, text=True,
                              capture_output=True, check=False)

    def called(self):
        return (self.root / "cmake.log").read_text(encoding="utf-8")


class Commands(Dev):
    """What is not made by the set-up or a build has to be in the project."""

    def setUp(self):
        super().setUp()
        self.script("tools/web/node_modules/.bin/tsc", STRICT)
        self.write("tools/web/package-lock.json", "{}")
        for path in (ROOT / "tools").rglob("*"):
            name = path.relative_to(ROOT)
            if path.is_file() and os.access(path, os.X_OK) and name.name != "dev" and "node_modules" not in name.parts:
                self.script(name, STRICT)
        for name in (".cache/venv/bin/python", "bin/cmake", "bin/ctest", "bin/node"):
            self.script(name, STRICT)

    def commands(self):
        """Each command, and each with the option that the help names."""
        text = (self.root / "tools/dev").read_text(encoding="utf-8")
        cases = re.search(r'^case "\$command" in\n(.*?)^esac', text, re.M | re.S)[1]
        commands = set(re.findall(r"^    ([a-z]\w*)\)", cases, re.M))
        described = re.findall(r"^  ([a-z]\w*)(?: \[(.*?)\])? ", self.dev("--help").stdout, re.M)
        self.assertEqual({command for command, _ in described}, commands)
        return [[command] for command in sorted(commands)] + [[command, option] for command, option in described
                                                              if option.startswith("--")]

    def test_each_that_takes_no_words_refuses_one_in_one_line(self):
        for command in ("setup", "quick", "demo", "docs", "format", "clean"):
            done = self.dev([command, "--fast"])
            self.assertEqual((done.returncode, done.stderr), (2, f"tools/dev {command}: found '--fast'; allowed: nothing\n"))
        self.assertTrue((self.root / "build").is_dir())

    def test_a_preset_that_is_not_there_is_refused_before_anything_is_installed(self):
        done = self.dev(["build", "nopreset"])
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"^tools/dev build: found 'nopreset'; allowed: host, .*stm32g4.*\n$")
        self.assertEqual(done.stdout, "")

    def test_words_that_a_program_refuses_or_that_only_ask_for_its_help_build_nothing(self):
        for said, status in (("found 'x'; allowed: y", 2), ("what may be said", 0)):
            self.script(".cache/venv/bin/python", f"#!/bin/sh\necho \"{said}\"\nexit {status}\n")
            for command in ("test", "evidence", "figures", "cost"):
                with self.subTest(command=command, status=status):
                    done = self.dev([command, "word"])
                    self.assertEqual((done.returncode, done.stdout + done.stderr), (status, f"{said}\n"))

    def test_two_at_once_set_up_one_after_the_other(self):
        words = [self.root / "tools/dev", "setup"]
        with (self.root / ".cache/lock").open("w", encoding="utf-8") as other:
            fcntl.flock(other, fcntl.LOCK_EX)
            with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as second:
                self.assertIn("waits until another tools/dev", second.stdout.readline())
                self.assertIsNone(second.poll())
                fcntl.flock(other, fcntl.LOCK_UN)
                self.assertIn("setup: Debian packages", second.stdout.readline())
                second.stdout.read()
        self.assertEqual(second.returncode, 0)

    def test_each_gets_to_its_end_with_what_is_in_the_project(self):
        self.assertGreater(len(self.commands()), 10)
        for words in self.commands():
            self.built()  # anew, as one of them removes it
            with self.subTest(words):
                done = self.dev(words)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_script_that_is_not_there_is_found(self):
        text = (self.root / "tools/dev").read_text(encoding="utf-8")
        for script, other in (("tools/gates/format.py", "tools/gates/none.py"), ("tools/gates/preset", "tools/gates/none")):
            self.write("tools/dev", text.replace(script, other))
            self.assertEqual([words for words in (["format"], ["cost"], ["docs"]) if self.dev(words).returncode],
                             [["format"] if script.endswith(".py") else ["cost"]])


class Quick(Dev):
    FOLDERS = ("tests/unit", "tests/board", "tests/scenario")

    def test_it_builds_and_runs_the_tests_of_the_firmware_and_the_format_gate(self):
        done = self.dev("quick")
        self.assertEqual(done.returncode, 0, done.stderr)
        built = re.search(r"^--build .*--target (.*)$", self.called(), re.M)[1].split()
        self.assertEqual(built, ["motorsim", *(f"{folder}/all" for folder in self.FOLDERS)])
        for folder in self.FOLDERS:
            self.assertTrue((ROOT / folder / "CMakeLists.txt").is_file(), folder)
            self.assertRegex(self.called(), rf"(?m)^--test-dir build/host/{folder} -LE \^evidence\$ .*--no-tests=error")
        self.assertIn("-R ^gate\\.format$", self.called())

    def test_a_test_that_fails_is_a_failure(self):
        self.assertEqual(self.dev("quick", status=BROKEN).returncode, BROKEN)


class Web(Dev):
    def setUp(self):
        super().setUp()
        self.write("tools/web/package-lock.json", "{}")
        self.script("tools/web/node_modules/.bin/tsc", "#!/bin/sh\n")
        self.script("bin/node", RECORDER + "exit $STATUS\n")

    def test_it_builds_the_simulator_then_the_page(self):
        done = self.dev("web")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.called().splitlines(), ["--preset web", "--build --preset web",
                                                      "tools/web/build.mjs build/wasm build/web"])

    def test_a_page_that_cannot_be_made_is_a_failure(self):
        self.assertEqual(self.dev("web", status=BROKEN).returncode, BROKEN)

    def test_another_option_is_refused_in_one_line(self):
        done = self.dev(["web", "--help-me"])
        self.assertEqual((done.returncode, done.stderr),
                         (2, "tools/dev web: found '--help-me'; allowed: nothing or --serve\n"))


class Demo(Dev):
    def demo(self, status=HOLDS, contrast=BROKEN):
        return self.dev("demo", status, contrast)

    def test_it_builds_the_programs_of_readme_and_guides_and_nothing_else(self):
        done = self.demo()
        self.assertEqual(done.returncode, 0, done.stderr)
        built = re.search(r"^--build .*--target (.*)$", (self.root / "cmake.log").read_text(encoding="utf-8"), re.M)[1]
        pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
        named = {name for page in pages for name in re.findall(r"build/host/(\w+)", page.read_text(encoding="utf-8"))}
        self.assertEqual(set(built.split()), named)

    def test_each_scenario_of_the_report_is_run(self):
        self.demo()
        runs = (self.root / "runs.log").read_text(encoding="utf-8")
        for scenario in ("s1", "s2", "s3", "s4", "s5", "s_weakening", "s_weakening_compressor"):
            self.assertIn(f"run {scenario} --trace build/runs/{scenario}.csv", runs)

    def test_a_run_that_is_meant_to_break_its_limits_says_what_it_shows(self):
        said = self.demo().stdout.splitlines()
        at = next(k for k, line in enumerate(said) if CONTRAST in line)
        self.assertRegex(said[at + 1], r"^no failure, but a contrast: .*lead is held")
        self.assertEqual(said[at + 2], "    what it costs: s4: id_settled_a = 3.5, limit: 0.05")

    def test_any_other_run_that_breaks_its_limits_is_a_failure(self):
        self.assertEqual(self.demo(status=BROKEN).returncode, BROKEN)

    def test_a_contrast_that_shows_none_is_a_failure(self):
        done = self.demo(contrast=HOLDS)
        self.assertEqual(done.returncode, BROKEN)
        self.assertIn("should have broken its limits: the lead is held", done.stderr)


if __name__ == "__main__":
    unittest.main()
