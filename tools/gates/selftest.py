# SPDX-License-Identifier: MIT
"""gate.selftest: each gate that reads the sources fails when it must, and says why.

A small clean tree is made in a temporary folder; then each fault alone is put into it.
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

GATES = Path(__file__).resolve().parent

TAG = "    // cppcheck-suppress misra-c2012-11.4 ; D1: the address is given by the chip\n"

# Finding → files that have this circle and no other. With nothing in the first of them there is none.
CIRCLES = {
    "firmware/protect/a.h:2 includes b.h -> firmware/protect/b.h:2 includes a.h: modules in a circle": {
        "firmware/protect/a.h": '#pragma once\n#include "b.h"\n',
        "firmware/protect/b.h": '#pragma once\n#include "a.h"\n',
    },
    "firmware/drive/a.h:2 includes b.h -> firmware/drive/b.def:1 includes c.h -> firmware/drive/c.c:1 includes a.h: modules": {
        "firmware/drive/a.h": '#pragma once\n#include "b.h"\n',
        "firmware/drive/b.h": "#pragma once\n",
        "firmware/drive/b.def": '#include "c.h"\n',
        "firmware/drive/c.h": "#pragma once\n",
        "firmware/drive/c.c": '#include "a.h"\n',
    },
    "firmware/drive/a.c:3 calls b_step -> firmware/drive/b.c:4 calls a_leaf: modules in a circle": {
        "firmware/drive/a.c": "int b_step(void);\nint a_leaf(void) { return 0; }\nint a_step(void) { return b_step(); }\n",
        "firmware/drive/b.c": "int a_leaf(void);\nint b_step(void)\n{\n    return a_leaf() + 1;\n}\n",
    },
    "firmware/app/a.c:2 calls b_step -> firmware/drive/b.c:2 calls c_step -> firmware/math/c.h:2 calls a_step: modules": {
        "firmware/app/a.c": "int b_step(void);\nint a_step(void) { return b_step(); }\n",
        "firmware/drive/b.c": '#include "c.h"\nint b_step(void) { return c_step(); }\n',
        "firmware/math/c.h": "int a_step(void);\nstatic inline int c_step(void) { return a_step(); }\n",
    },
    "firmware/drive/a.c:3 calls b_each -> firmware/math/b.c:3 calls a_leaf: modules in a circle": {
        "firmware/drive/a.c": "int b_each(int (*f)(int));\nstatic int a_leaf(int x) { return x; }\n"
                              "int a_step(void) { return b_each(a_leaf); }\n",
        "firmware/math/b.c": "int b_each(int (*f)(int))\n{\n    return f(1);\n}\n",
    },
    "firmware/math/a.c:2 calls a_step: a recursion": {
        "firmware/math/a.c": "static int a_leaf(int x) { return x; }\n"
                             "int a_step(int x) { return (x > 0) ? a_step(x - 1) : a_leaf(x); }\n",
    },
    "firmware/math/a.c:2 calls a_even -> firmware/math/a.h:2 calls a_odd: a recursion": {
        "firmware/math/a.c": '#include "a.h"\nint a_odd(int x) { return (x != 0) && a_even(x - 1); }\n',
        "firmware/math/a.h": "int a_odd(int x);\nstatic inline int a_even(int x) { return (x == 0) || a_odd(x - 1); }\n",
    },
    "firmware/math/a.c:2 calls fx_sat -> firmware/math/port/armv7em/fx_port.h:2 calls a_step: modules in a circle": {
        "firmware/math/a.c": '#include "fx_port.h"\nint a_step(int x) { return fx_sat(x); }\n',
        "firmware/math/port/armv7em/fx_port.h": "int a_step(int x);\nstatic inline int fx_sat(int x) { return a_step(x); }\n",
        "firmware/math/port/generic/fx_port.h": "static inline int fx_sat(int x) { return x; }\n",
    },
    "host_sim/run/a.cpp:1 includes b.h -> host_sim/run/b.h:1 includes a.h: modules in a circle": {
        "host_sim/run/a.cpp": '#include "b.h"\n',
        "host_sim/run/a.h": "",
        "host_sim/run/b.h": '#include "a.h"\n',
    },
    "tools/web/src/a.ts:2 imports b.tsx -> tools/web/src/parts/b.tsx:1 imports a.ts: modules in a circle": {
        "tools/web/src/a.ts": 'import { x } from "x";\nimport {\n    b,\n} from "./parts/b.tsx";\n',
        "tools/web/src/parts/b.tsx": 'import type { A } from "../a.ts";\n',
    },
}
DRIVE = {
    "firmware/drive/state.h": "typedef struct {\n    int state;\n    int tick;\n} drive_t;\n",
    "firmware/drive/life.c": '#include "state.h"\nstatic void set_state(drive_t *drive) { drive->state = 1; }\n'
                              "void initialise(drive_t *drive)\n{\n    *drive = (drive_t){.state = 2};\n"
                              "    set_state(drive);\n}\n",
}

CLEAN = {
    "firmware/math/fx.h": "#include <stdint.h>\n",
    "firmware/control/pi.h": '#include "fx.h"\nint32_t pi_step(uint32_t place);\n',
    "firmware/control/pi.c": '#include "pi.h"\n\n/* no float here */\nint32_t pi_step(uint32_t place)\n{\n'
                             + TAG + "    return *(const int32_t *)place;\n}\n",
    "firmware/control/modulator.h": "",
    "firmware/drive/drive.h": '#include "pi.h"\n',
    "firmware/MISRA.md": "| 8.7, 15.5 | reason |\n\n"
                         "| D1 | 11.4 | `firmware/control/pi.c:pi_step` | reason |\n",
    "hal/hal.h": '#include "drive.h"\n',
    "firmware/app/control_isr.c": '#include "hal.h"\n',
    "host_sim/plant/motor.h": "",
    "host_sim/run/sim.h": '#include "drive.h"\n#include "motor.h"\n',
    "host_sim/output/trace.cpp": '#include "sim.h"\n',
    "host_sim/output/trace.h": "",
    "host_sim/motorsim.cpp": '#include "trace.h"\n',
}


def plant(root, files):
    """A repository with these files."""
    subprocess.run(["git", "init", "-q", root], check=True)
    for path, text in files.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text, encoding="utf-8")


class GatesCanFail(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        # clang-format looks for its file upwards from the source.
        style = (GATES.parents[1] / ".clang-format").read_text(encoding="utf-8")
        plant(self.root, {**CLEAN, ".clang-format": style})

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def append(self, path, text):
        self.write(path, (self.root / path).read_text(encoding="utf-8") + text)

    def run_gate(self, gate, *arguments):
        run = subprocess.run([sys.executable, GATES / f"{gate}.py", "--root", self.root, *arguments],
                             capture_output=True, text=True)
        return run.returncode, run.stdout + run.stderr

    def library(self, source, *options):
        (self.root / "lib.c").write_text(source)
        made, library = self.root / "lib.o", self.root / "lib.a"
        subprocess.run(["gcc", "-g", "-fno-builtin", *options, "-c", self.root / "lib.c", "-o", made], check=True)
        subprocess.run(["ar", "rc", library, made], check=True)
        return library

    def assert_fails(self, gate, *texts, arguments=()):
        code, output = self.run_gate(gate, *arguments)
        self.assertEqual(code, 1, output)
        for text in texts:
            self.assertIn(text, output)

    def assert_passes(self, gate, *arguments):
        code, output = self.run_gate(gate, *arguments)
        self.assertEqual(code, 0, output)

    def test_clean_tree_passes(self):
        for gate in ("floors", "format", "misra", "misra_register", "no_float"):
            self.assert_passes(gate)

    def test_licence(self):
        self.write("tools/good", "#!/usr/bin/env python3\n")
        self.write("tools/good.jinja", "{% extends 'frame' %}\n")
        self.assert_fails("licence", "firmware/math/fx.h:1: ", "tools/good:2: ",
                          "tools/good.jinja:1: the line is not '{# SPDX-License-Identifier: MIT #}'")
        self.run_gate("licence", "--fix")
        self.assert_passes("licence")
        for path, text, place in (("firmware/math/new.h", "#include <stdint.h>\n", 1),
                                  ("firmware/math/new.h", "/* SPDX-License-Identifier: GPL-2.0-only */\n", 1),
                                  ("firmware/math/new.h", "\n/* SPDX-License-Identifier: MIT */\n", 1),
                                  ("firmware/math/CMakeLists.txt", "", 1),
                                  ("tools/new", "#!/bin/sh\necho\n", 2),
                                  ("tools/new.rb", "# SPDX-License-Identifier: MIT\n", 1)):
            with self.subTest(f"{path}: {text}"):
                self.write(path, text)
                self.assert_fails("licence", f"{path}:{place}: ")
                (self.root / path).unlink()

    def test_no_float(self):
        for line, word in (("float x;", "float"), ("int x = (int)1.5e3;", "1.5e3"),
                           ("_Float32 x;", "_Float32"), ("_Float64x x;", "_Float64x"), ("__fp16 x;", "__fp16"),
                           ("__float128 x;", "__float128"), ("float32_t x;", "float32_t"),
                           ("_Decimal64 x;", "_Decimal64"), ("void *p = malloc(4);", "malloc")):
            with self.subTest(line):
                self.write("firmware/math/bad.c", f"/* */\n{line}\n")
                self.assert_fails("no_float", f"firmware/math/bad.c:2: {word}")

    def test_no_float_in_objects(self):
        for source, options, finding in (
                ("double log(double); int f(int x) { return (int)log(x); }\n", (), "lib.a(lib.o) calls log"),
                # a name that nobody thought of
                ("typedef __typeof__(__builtin_inff()) number;\nint f(int x) { number y = x; return (int)(y * y); }\n", (),
                 "lib.a uses float: float"),
                ("int f(int x) { return x; }\n", ("-g0",), "lib.a has no debug information")):
            with self.subTest(finding):
                self.assert_fails("no_float", finding, arguments=[self.library(source, *options)])
                (self.root / "lib.a").unlink()
        self.assert_passes("no_float", self.library("#include <stddef.h>\nint f(ptrdiff_t x) { return (int)x; }\n"))

    def test_floors(self):
        for path, include in (
                ("firmware/math/fx.h", '"pi.h"'),
                ("firmware/control/pi.h", '"drive.h"'),
                ("firmware/control/pi.c", '"modulator.h"'),
                ("firmware/control/pi.c", "<stdio.h>"),
                ("firmware/drive/drive.h", '"hal.h"'),
                ("host_sim/plant/motor.h", '"fx.h"'),
                ("host_sim/run/sim.h", '"trace.h"'),
                ("host_sim/output/trace.cpp", '"hal.h"')):
            with self.subTest(f"{path} includes {include}"):
                self.setUp()
                self.append(path, f"#include {include}\n")
                self.assert_fails("floors", path, include)

    def test_floors_knows_each_folder(self):
        for folder in ("firmware/spare", "firmware/drive/deep", "hal/newchip", "host_sim/plant/more", "host_sim"):
            with self.subTest(folder):
                self.setUp()
                self.write(f"{folder}/new.c", '#include "motor.h"\n')
                self.assert_fails("floors", f"{folder}: is no floor")

    def test_circles(self):
        for circle, files in CIRCLES.items():
            with self.subTest(circle):
                self.setUp()
                for path, text in files.items():
                    self.write(path, text)
                self.assert_fails("floors", circle, "1 finding(s)")
                self.write(next(iter(files)), "")
                self.assert_passes("floors")

    def test_a_source_that_cannot_be_parsed(self):
        self.write("firmware/math/fx.h", "\nint f(void) { return g(); }\n")
        self.assert_fails("floors", "firmware/math/fx.h:2: call to undeclared function 'g'")

    def test_state_is_written_by_one_function(self):
        head = '#include "state.h"\nint f(drive_t *drive)\n{\n'
        for path, text in DRIVE.items():
            self.write(path, text)
        for line, what in (("drive->state = 1;", "drive_t.state"), ("(drive->state)++;", "drive_t.state"),
                           ("drive->state |= 1;", "drive_t.state"), ("int *at = &drive->state; *at = 1;", "drive_t.state"),
                           ("*drive = (drive_t){.tick = 1};", "drive_t")):
            with self.subTest(line):
                self.write("firmware/app/f.c", head + line + "\nreturn 0;\n}\n")
                self.assert_fails("floors", f"firmware/app/f.c:4: f writes {what}, which is for ", "1 finding(s)")
        self.write("firmware/app/f.c", head + "drive_t copy = *drive;\ndrive->tick = copy.state;\n"
                                              "return (drive->state > 1) && (copy.tick != 0);\n}\n")
        self.assert_passes("floors")
        self.append("firmware/drive/life.c", "void drive_step(drive_t *drive)\n{\n    drive->state = 3;\n}\n")
        self.assert_fails("floors", "firmware/drive/life.c:10: drive_step writes drive_t.state", "1 finding(s)")

    def test_a_group_of_the_state_is_written_by_one_module(self):
        self.write("firmware/drive/run.h", "typedef struct {\n    int mode;\n    int way[2];\n} motion_t;\n"
                                           "typedef struct {\n    motion_t motion;\n    int tick;\n} machine_t;\n"
                                           "void run_plan(motion_t *motion);\nint run_of(const int *mode);\n"
                                           "void run_set(int *mode);\n")
        self.write("firmware/drive/run.c", '#include "run.h"\nvoid run_plan(motion_t *motion)\n{\n    motion->mode = 1;\n}\n')
        head = '#include "run.h"\nint f(machine_t *machine)\n{\n'
        for line in ("machine->motion.mode = 1;", "machine->motion.mode++;", "machine->motion.way[1] |= 2;",
                     "(machine->motion.way)[0] = 2;", "run_set(&machine->motion.mode);",
                     "int *const mode = &machine->motion.mode; *mode = 1;",
                     "machine->motion = (motion_t){.mode = 1};", "motion_t *const motion = &machine->motion; motion->mode = 1;"):
            with self.subTest(line):
                self.write("firmware/drive/tick.c", head + line + "\nreturn 0;\n}\n")
                self.assert_fails("floors", "firmware/drive/tick.c:4: writes a motion_t, which is for run.c alone",
                                  "1 finding(s)")
        self.write("firmware/drive/tick.c", head + "const int *const mode = &machine->motion.mode;\n"
                                                   "machine->tick = machine->motion.mode + machine->motion.way[1];\n"
                                                   "int table[3];\ntable[machine->motion.mode] = 5;\n"
                                                   "run_plan(&machine->motion);\n"
                                                   "return run_of(&machine->motion.mode) + *mode;\n}\n")
        self.assert_passes("floors")

    def test_who_writes_the_state_is_there(self):
        for path, text in DRIVE.items():
            self.write(path, text.replace("drive_t", "machine_t"))
        self.assert_fails("floors", "set_state of firmware/drive/life.c does not write drive_t.state",
                          "initialise of firmware/drive/life.c does not write drive_t", "2 finding(s)")

    def test_registers_are_touched_in_target_bindings_only(self):
        lines = ("*(volatile uint32_t *)place = 1U;", "*(const volatile uint32_t *)0x40010300U;",
                 "*(uint32_t *)0x40010300U = 1U;", "*(uint32_t volatile *)(place) = 1U;",
                 "extern volatile uint32_t port;", "timer_t *const timer = (timer_t *)1073816320;")
        for path in ("firmware/math/fx.h", "firmware/app/control_isr.c", "hal/hal.h", "hal/host/hal_host.c",
                     "host_sim/plant/motor.h"):
            with self.subTest(path):
                self.setUp()
                self.write(path, "/* a comment\n of two lines */\n" + "\n".join(lines))
                self.assert_fails("floors", *(f"{path}:{3 + k}: " for k in range(len(lines))))
        self.setUp()
        self.write("hal/stm32g4/reg.h", "\n".join(lines))
        self.assert_passes("floors")

    def test_what_is_no_register_passes(self):
        self.append("firmware/math/fx.h", "static volatile uint32_t in_force;\nint32_t f(const uint8_t *bytes, int32_t b);\n"
                                          "#define X(a) (int32_t)(a * 0x4000)\n"
                                          "#define Y(word) f((const uint8_t *)&word, 4U) * (word) * 4\n")
        self.assert_passes("floors")

    def test_misra(self):
        self.write("firmware/control/pi.c", CLEAN["firmware/control/pi.c"].replace(TAG, ""))
        self.assert_fails("misra", "firmware/control/pi.c:6: MISRA [misra-c2012-11.4]")

    def test_misra_tag_that_suppresses_nothing(self):
        self.append("firmware/control/pi.c", TAG.lstrip() + "typedef int32_t pi_t;\n")
        self.assert_fails("misra", "firmware/control/pi.c:10", "unmatchedSuppression")

    def test_each_misra_tag_has_its_row_and_each_row_its_tag(self):
        register, tagged = "firmware/MISRA.md", "firmware/control/modulator.h"
        tag, row = "// cppcheck-suppress misra-c2012-11.5", "| D1 | 11.4 | `firmware/control/pi.c:pi_step` | reason |\n"
        for path, text, finding in (
                (tagged, f"{tag} ; D2: reason\n", "modulator.h: D2 (11.5) is tagged here but"),
                (tagged, f"{tag}\n", "modulator.h:1: a tag reads"),
                (register, row + "| D2 | 11.4 | firmware/math/fx.h:stdint | reason |\n",
                 "D2 (11.4) has no tag in firmware/math/fx.h"),
                (register, row.replace("11.4", "11.6"), "D1 (11.6) has no tag"),
                (register, row.replace("pi.c", "pi.h"), "has no tag in firmware/control/pi.h"),
                (register, row.replace("pi_step", "gone"), "there is no")):
            with self.subTest(finding):
                self.setUp()
                self.write(path, text)
                self.assert_fails("misra_register", finding)

    def built(self, source=None, command=None):
        """A build folder in which this source is compiled, or none."""
        build = self.root / "build"
        build.mkdir()
        entry = {"directory": str(build), "file": str(source), "command": command}
        (build / "compile_commands.json").write_text(json.dumps([entry] if source else []))
        return build

    def test_build_types(self):
        source = self.root / "firmware/math/run.c"
        build = self.built(source, f"gcc -O2 -g -DNDEBUG -Wall -Werror -o run.o -c {source}")
        for text, complaints in (("int f(void);\nint f(void)\n{\n    return 1;\n}\n", ()),
                                 ("#ifndef NDEBUG\nint f(\n#endif\n", ("Debug: ",)),
                                 ("#ifdef __OPTIMIZE_SIZE__\nint f(\n#endif\n", ("MinSizeRel: ",)),
                                 ("#ifdef NDEBUG\nint f(\n#endif\n", ("Release: ", "MinSizeRel: "))):
            with self.subTest(complaints):
                source.write_text(text)
                code, output = self.run_gate("build_types", build)
                self.assertEqual(code, 1 if complaints else 0, output)
                found = {f"{line.split(':')[0]}: " for line in output.splitlines() if line.split(":")[0] in
                         ("Debug", "Release", "MinSizeRel")}
                self.assertEqual(found, set(complaints))

    def test_build_types_that_look_at_nothing(self):
        self.assert_fails("build_types", arguments=[self.built()])

    def test_each_test_is_run(self):
        tests = self.root / "tests/unit"
        for name in ("test_a.c", "test_script.py", "test_module.py", "drive_can_fail.py"):
            self.write(f"tests/unit/{name}", "")
        build = self.built(tests / "test_a.c", "cc -o CMakeFiles/test_a.dir/test_a.c.o")
        (build / "test_a").touch(0o755)
        registered = {
            "test_a.c": f'add_test(a "{build}/test_a")',
            "test_script.py": f'add_test(script python3 "{tests}/test_script.py" "more")',
            "test_module.py": 'add_test(module python3 "-m" "unittest" "test_module")\n'
                              f'set_tests_properties(module PROPERTIES WORKING_DIRECTORY "{tests}")',
            "drive_can_fail.py": f'add_test(fails python3 "{tests}/drive_can_fail.py")',
        }
        for left_out in (None, *registered):
            with self.subTest(left_out):
                lines = [line for name, line in registered.items() if name != left_out]
                (build / "CTestTestfile.cmake").write_text("\n".join(lines))
                code, output = self.run_gate("tests_run", build)
                self.assertEqual(code, 1 if left_out else 0, output)
                self.assertEqual(output.count("no test of"), code, output)
                self.assertIn(left_out or "clean", output)

    def test_format(self):
        self.append("firmware/control/pi.c", "int  *  p ;\n")
        self.assert_fails("format", "firmware/control/pi.c:9", "tools/dev format")


if __name__ == "__main__":
    unittest.main()
