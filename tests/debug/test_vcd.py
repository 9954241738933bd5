# SPDX-License-Identifier: MIT
"""The value change dump of motorsim run: its grammar, its window, and the edges of the gates."""

import csv
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

MOTORSIM = Path(sys.argv.pop(1)).resolve()
HOLDS, BAD_INPUT = 0, 2
NS = 1e-9
TICK_NS = 100_000
TIMER_HZ = 170e6       # of the bench board: 8500 counts up, 8500 down
TIMER_COUNTS = 8500
DEAD_TIME_NS = 2000    # of the set `deadtime`
EDGE_NS = 1.5          # two edges to nearest 1 ns, and what the float adds
DIGITS = 1e-5          # the trace has 6, the dump 9


class Dump:
    """A reader for the part of IEEE 1364 that a dump of reals, vectors and wires needs; refuses anything else."""

    def __init__(self, text):
        header, _, body = text.partition("$enddefinitions $end\n")
        self.names = {}
        self.changes = {}   # name -> [(time, value)]
        self.kinds = {}
        self.read_header(header)
        self.time = None
        for line in body.splitlines():
            self.read_change(line)

    def read_header(self, header):
        scopes = []
        for keyword, content in re.findall(r"\$(\w+)\s+(.*?)\s*\$end", header, flags=re.DOTALL):
            if keyword == "scope":
                scopes.append(re.fullmatch(r"module (\w+)", content)[1])
            elif keyword == "upscope":
                scopes.pop()
            elif keyword == "var":
                kind, size, code, name = re.fullmatch(
                    r"(reg|real|wire) (\d+) ([!-~]+) (\w+)", content).groups()
                assert scopes and code not in self.names, content
                self.names[code] = name
                self.kinds[code] = (kind, int(size))
                self.changes[name] = []
            else:
                assert keyword in ("version", "timescale", "comment", "date"), keyword
                if keyword == "comment":
                    self.comment = content
                if keyword == "timescale":
                    assert content == "1 ns", content
        assert not scopes
        assert re.sub(r"\$\w+\s.*?\$end", "", header, flags=re.DOTALL).strip() == ""

    def read_change(self, line):
        if time := re.fullmatch(r"#(\d+)", line):
            assert self.time is None or int(time[1]) > self.time, line
            self.time = int(time[1])
            return
        wire = re.fullmatch(r"([01])([!-~]+)", line)
        vector = re.fullmatch(r"b([01]+) ([!-~]+)", line)
        real = re.fullmatch(r"r(\S+) ([!-~]+)", line)
        value, code = (wire or vector or real).groups()
        kind, size = self.kinds[code]
        assert kind == ("wire" if wire else "reg" if vector else "real"), line
        assert not vector or len(value) == size, line
        number = float(value) if real else int(value, 2)
        changes = self.changes[self.names[code]]
        assert self.time is not None and (not changes or changes[-1][1] != number), line
        changes.append((self.time, number))

    def at(self, name, time):
        return [value for when, value in self.changes[name] if when <= time][-1]


class VcdTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def motorsim(self, *args):
        return subprocess.run([MOTORSIM, "run", *args], cwd=self.folder, text=True,
                              capture_output=True, check=False)

    def dump(self, *args):
        done = self.motorsim(*args, "--vcd", "run.vcd")
        self.assertNotEqual(done.returncode, BAD_INPUT, done.stderr)
        return Dump((self.folder / "run.vcd").read_text(encoding="utf-8"))

    def refused(self, *args):
        done = self.motorsim(*args)
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertEqual(done.stderr.count("\n"), 1)
        return done.stderr

    def test_signals_are_those_of_the_trace_at_each_tick(self):
        dump = self.dump("s2", "--vcd-from", "0.5", "--vcd-to", "0.51", "--trace", "t.csv")
        with open(self.folder / "t.csv", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if 0.49995 < float(row["time_s"]) < 0.51005]
        self.assertEqual(len(rows), 101)
        for row in rows:
            time = round(float(row["time_s"]) / NS)
            for name in ("speed_rpm", "i_q_a", "duty_a", "v_q_v"):
                self.assertAlmostEqual(dump.at(name, time), float(row[name]),
                                       delta=DIGITS * max(1, abs(float(row[name]))))

    def test_the_window_begins_and_ends_where_it_was_told(self):
        dump = self.dump("s2", "--vcd-from", "0.5", "--vcd-to", "0.501")
        times = [time for changes in dump.changes.values() for time, _ in changes]
        self.assertEqual(min(times), 500_000_000)
        self.assertLess(max(times), 501_000_000 + TICK_NS)
        self.assertEqual(dump.time, 501_000_000 + TICK_NS)

    def test_a_window_before_zero_counts_from_its_beginning(self):
        dump = self.dump("s1_robust", "--vcd-from", "-0.5", "--vcd-to", "-0.49")
        self.assertEqual(min(t for changes in dump.changes.values() for t, _ in changes), 0)

    def test_states_change_at_their_tick(self):
        dump = self.dump("s1_robust", "--vcd-from", "-1")
        legend = re.search(r"state:(.*); fault:", dump.comment)[1]
        names = {int(code): name for code, name in re.findall(r"(\d+)=(\w+)", legend)}
        states = [names[code] for _, code in dump.changes["state"]]
        self.assertEqual(states[:3], ["OFFSET_CAL", "READY", "FLYING_START"])
        self.assertIn("RUN", states)
        for time, _ in dump.changes["state"]:
            self.assertEqual(time % TICK_NS, dump.changes["state"][0][0] % TICK_NS)

    def test_edges_are_where_the_timer_puts_them(self):
        # Duty d of tick k acts in the next period, centred in its middle: edges at T/2·(1 ∓ d).
        dump = self.dump("s2", "--vcd-from", "0.6", "--vcd-to", "0.602")
        for k in range(1, 20):
            start = 600_000_000 + k * TICK_NS
            for leg in "abc":
                duty = dump.at(f"duty_{leg}", start - TICK_NS)
                edges = [time - start for time, _ in dump.changes[f"gate_{leg}_high"]
                         if start <= time < start + TICK_NS]
                counts = round(duty * TIMER_COUNTS)
                expected = [(TIMER_COUNTS + sign * counts) / TIMER_HZ / NS for sign in (-1, 1)]
                self.assertEqual(len(edges), 2)
                for edge, place in zip(edges, expected):
                    self.assertAlmostEqual(edge, place, delta=EDGE_NS)

    def test_both_switches_of_a_leg_are_open_for_the_dead_time_at_each_edge(self):
        dump = self.dump("s2_robust", "--with", "deadtime", "--vcd-from", "0.6", "--vcd-to", "0.61")
        for leg in "abc":
            both = sorted([(time, "high", value) for time, value in dump.changes[f"gate_{leg}_high"]]
                          + [(time, "low", value) for time, value in dump.changes[f"gate_{leg}_low"]])
            gaps = [after[0] - before[0] for before, after in zip(both[2:], both[3:])
                    if before[2] == 0 and after[2] == 1]
            self.assertGreater(len(gaps), 150)
            for gap in gaps:
                self.assertAlmostEqual(gap, DEAD_TIME_NS, delta=EDGE_NS)

    def test_bad_options_are_refused_in_a_line(self):
        self.assertIn("need --vcd FILE", self.refused("s1", "--vcd-from", "0"))
        self.assertIn("is after", self.refused("s1", "--vcd", "a", "--vcd-from", "2", "--vcd-to", "1"))
        self.assertIn("no tick of the run", self.refused("s1", "--vcd", "a", "--vcd-from", "5"))
        for option, time in (("--vcd-from", "nan"), ("--vcd-to", "inf"), ("--vcd-from", "-inf")):
            self.assertIn(f"{option} is a finite number of seconds, found {time}",
                          self.refused("s1", "--vcd", "a", option, time))
        self.assertIn("same file", self.refused("s1", "--vcd", "a", "--trace", "./a"))
        self.assertIn("no/such/folder: cannot write: No such file or directory",
                      self.refused("s1", "--vcd", "no/such/folder"))
        self.assertIn("/dev/full", self.refused("s1", "--vcd", "/dev/full"))
        self.assertTrue(Path("/dev/full").exists())

    def test_a_dump_that_fails_leaves_no_file(self):
        self.refused("s1", "--vcd", "a", "--vcd-from", "5")
        self.refused("s1", "--vcd", "a", "--set", "motor.inductance_d_h=1")
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_states_and_faults_have_a_legend(self):
        self.motorsim("s1_robust", "--vcd", "run.vcd", "--vcd-from", "0.3",
                      "--set", 'scenario.fault=[{time_s=0.4, what="overcurrent", value=19}]')
        text = (self.folder / "run.vcd").read_text(encoding="utf-8")
        states, faults = re.search(r"state:((?: \d+=\w+)+); fault:((?: \d+=\w+)+) \$end", text).groups()
        legends = [dict(pair.split("=") for pair in legend.split()) for legend in (states, faults)]
        dump = Dump(text)
        self.assertEqual([legends[0][str(value)] for _, value in dump.changes["state"]], ["RUN", "FAULT"])
        self.assertEqual([legends[1][str(value)] for _, value in dump.changes["fault"]], ["NONE", "OVERCURRENT"])


unittest.main()
