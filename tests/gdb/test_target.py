# SPDX-License-Identifier: MIT
"""gdb on an image in QEMU: what it shows of a tick is what the stepper on the PC shows of that tick.

test_target.py GDB MOTORSIM IMAGE
"""

import re
import socket
import subprocess
import sys
import unittest

import support

GDB, MOTORSIM, IMAGE = sys.argv[1:]
TICK = 1400  # ALIGN: a current flows


class OnTheTarget(support.GdbTest):
    """A replay of s1_robust."""

    MOTORSIM, CHOICE = MOTORSIM, ("s1_robust", "--with", "deadtime")
    GDB = (GDB, IMAGE)
    START = (f"target remote | {support.ROOT}/tools/gdb/emulator {IMAGE} s1_robust deadtime",)

    def test_the_tick_on_the_target_is_the_one_on_the_pc(self):
        scales, first, there, shown, bus, again, crc = self.gdb(
            ["scales s1_robust --with deadtime", "step-isr", f"step-isr {TICK + 1}", "stages",
             "print app.drive.bus", "step-isr", "print app.drive.cfg->crc"], self.START)
        self.assertIn("s1_robust: I_b = 40 A, U_b = 450 V, 100 us a tick", scales)
        self.assertEqual(first.strip(), "before the first tick  INIT")
        self.assertEqual(there.strip(), f"tick {TICK}  ALIGN")
        self.assert_same_stages(shown, TICK)
        self.assert_shows(bus, "drive.bus", TICK)
        self.assertEqual(again.strip(), f"tick {TICK + 1}  ALIGN")
        self.assertRegex(crc, r"= [1-9]\d+\n$")

    def test_scales_are_asked_for_and_those_of_another_configuration_refused(self):
        shown, vector, refused, _, _, kept = self.gdb(
            ["step-isr 2", "stages", "print app.drive.control.voltage", "scales s1",
             "scales s1_robust --with deadtime", "scales s1", "print app.drive.control.voltage"], self.START)[1:]
        self.assertEqual(shown.strip(), "the scales are not known: `scales SCENARIO` chooses them")
        self.assertIn("(raw 0, 0; as Q15)", vector)
        self.assertIn("Q15 of U_b = 450 V", kept)
        self.assertTrue(re.fullmatch(r"scales: the drive's configuration has crc \S+, that of s1 \S+: choose the one "
                                     r"that the program was built for", refused.strip()), refused)

    def emulator(self, port):
        made = subprocess.Popen([support.ROOT / "tools/gdb/emulator", IMAGE, "s1_robust", "deadtime", "--port", str(port)],
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(made.communicate)
        self.addCleanup(made.kill)
        return made

    def test_the_port_is_open_once_the_emulator_says_so(self):
        said = ""
        emulator = self.emulator(0)
        while "waits for gdb at" not in said:
            said = emulator.stdout.readline()
            self.assertTrue(said, "it has ended")
        host, port = re.search(r"tcp:(\S+):(\d+)$", said.strip()).groups()
        first, there = self.gdb(["step-isr", "step-isr 3"], (f"target remote {host}:{port}",))
        self.assertEqual(first.strip(), "before the first tick  INIT")
        self.assertTrue(there.startswith("tick 2 "), there)

    def test_a_port_in_use_is_refused_in_one_line(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            emulator = self.emulator(port)
            error = emulator.communicate()[1]
        self.assertEqual(emulator.returncode, 2)
        self.assertRegex(error, rf"^emulator: --port {port}: .*in use.*\n$")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
