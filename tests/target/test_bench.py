# SPDX-License-Identifier: MIT
"""target.bench: tools/bench_target.py counts what it says it counts, and refuses what is no figure.

test_bench.py IMAGE FOLDER: a replay image for a Cortex-M3, and a recording of `record` for it.
"""

import subprocess
import sys
import unittest
from collections import Counter
from pathlib import Path

IMAGE, FOLDER = sys.argv[1:3]
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tools"))

from support import FolderTest, captured  # noqa: E402
import bench_target  # noqa: E402
from bench import budget, cycles, machine, profile, replay, sizes, stack  # noqa: E402
from bench.blocks import Decoder  # noqa: E402
from bench.image import BenchError, Image  # noqa: E402

# Calls `counted` with r0 = 0, 1, ... r5 − 1 and ends; `counted` is what each test adds.
FRAME = """
    .syntax unified
    .thumb
    .word 0x20000400, start + 1
    .global counted
    .thumb_func
    .type start, %function
start:
    movs r4, #0
    movs r5, #{calls}
again:
    mov r0, r4
    bl counted
    adds r4, #1
    cmp r4, r5
    bne again
    movs r0, #0x20
    adr r1, exit
    bkpt 0xAB
    .align 2
exit: .word 0x20026, 0, 0
    .size start, . - start
    .thumb_func
    .type counted, %function
    .size counted, 2
counted:
{code}
"""


def assembled(folder, core, code, calls):
    """The image of a program."""
    source, image = folder / "program.s", folder / "program.elf"
    source.write_text(FRAME.format(calls=calls, code=code))
    subprocess.run(["arm-none-eabi-gcc", f"-mcpu={core}", "-mthumb", "-nostdlib", "-Wl,-Ttext=0",
                    "-Wl,-e,start", source, "-o", image], check=True, capture_output=True)
    return Image(image)


def model(title):
    return next(one for one in cycles.MODELS if one.title == title)


class Program(FolderTest):
    """A program whose cost can be counted by hand."""

    def run_calls(self, core, code, calls):
        """The blocks of each call with its return address, and the bytes of stack."""
        image = assembled(self.folder, core, code, calls)
        trails, host = machine.run(core, image.content, image.symbol("counted").address,
                                   image.symbol("start").addresses, {})
        self.assertEqual(host.exit_code, 0)
        decoder = Decoder(image.content)
        ways = {number: way for way, number in trails.trails.items()}
        found = [([decoder.block(at, trails.sizes[at]) for at in ways[call][:-1]], ways[call][-1])
                 for call in trails.calls]
        return found, trails.stack_bytes

    def counts(self, core, code, calls):
        ways, _ = self.run_calls(core, code, calls)
        return [sum(len(block.instructions) for block in blocks) for blocks, _ in ways]

    def cycles(self, title, code, calls):
        ways, _ = self.run_calls(model(title).core, code, calls)
        return [cycles.Clock(model(title)).cycles(*way) for way in ways]


SKIPPING = """
    push {r4, lr}
    cmp r0, #1
    ittt eq
    addeq r1, #1
    addeq r1, #1
    addeq r1, #1
    bl leaf
    pop {r4, pc}
    .thumb_func
leaf:
    nop
    bx lr
"""
LEAVING = """
    cmp r0, #1
    it eq
    bxeq lr
    adds r1, #1
    bx lr
"""
LOOP = """
    adds r3, r0, #1
1:  subs r3, #1
    bne 1b
    bx lr
"""


class Counts(Program):
    def test_what_is_skipped_counts_and_each_time_around_and_nothing_behind_a_return(self):
        for cores, code, counts in ((("cortex-m3", "cortex-m4"), SKIPPING, [10, 10]), (("cortex-m4",), LEAVING, [5, 3, 5]),
                                    (machine.CPU, LOOP, [4, 6, 8])):
            for core in cores:
                with self.subTest(core=core, code=code):
                    self.assertEqual(self.counts(core, code, len(counts)), counts)

    def test_stack_is_what_is_written(self):
        _, size = self.run_calls("cortex-m3", SKIPPING, 2)
        self.assertEqual(size, 8)

    def test_exception_is_no_figure(self):
        with self.assertRaises(BenchError):
            self.run_calls("cortex-m0plus", "    udf #0", 1)


class Cycles(Program):
    def test_each_core_has_its_least_and_most_for_each_call(self):
        multiply = "    muls r0, r0, r0\n    bx lr"
        long_multiply_and_division = "    smull r0, r1, r0, r0\n    sdiv r0, r0, r1\n    bx lr"
        for title, code, cycles_of_calls in (
                # push 3, cmp 1, it 0–1, add 3, bl 1, nop 1, bx 1, pop 3; three refills of 1–3
                ("M4", SKIPPING, [(16, 23)]),
                # adds, subs each time, bne 2 or 1, bx 2
                ("M0+", LOOP, [(5, 5), (8, 8), (11, 11)]),
                ("M0+", multiply, [(3, 3)]),
                ("M0+ slow MULS", multiply, [(34, 34)]),
                ("M3", long_multiply_and_division, [(7, 21)]),
                ("M4", long_multiply_and_division, [(5, 17)]),
                # push 3, pop with pc 3 + n
                ("M0+", "    push {r4, lr}\n    pop {r4, pc}", [(8, 8)])):
            with self.subTest(title=title, code=code):
                self.assertEqual(self.cycles(title, code, len(cycles_of_calls)), cycles_of_calls)


GRAPH = """
node: { title: "main" label: "main\\nm.c:1:1\\n16 bytes (static)" }
node: { title: "/tmp/x.o:f.part.0" label: "f\\nm.c:2:1\\n24 bytes (static)" }
node: { title: "/tmp/x.o:g" label: "g\\nm.c:3:1\\n8 bytes (static)" }
node: { title: "memset" label: "__builtin_memset\\n<built-in>" shape : ellipse }
edge: { sourcename: "main" targetname: "/tmp/x.o:g" label: "m.c:1:2" }
edge: { sourcename: "main" targetname: "/tmp/x.o:f.part.0" label: "m.c:1:3" }
edge: { sourcename: "/tmp/x.o:g" targetname: "memset" }
"""


class Stack(Program):
    def deepest(self, text, indirect=None, library=lambda name: (4, ())):
        frames, calls = stack.parse(text)
        return stack.deepest("main", frames, stack.resolve_pointers(calls, indirect or {}), library)

    def test_deepest_way(self):
        self.assertEqual(self.deepest(GRAPH), (40, ("main", "f.part.0")))
        deep_library = self.deepest(GRAPH, library=lambda name: (20, ()))
        self.assertEqual(deep_library, (44, ("main", "g", "memset")))

    def test_pointer_must_be_resolved(self):
        text = GRAPH + 'edge: { sourcename: "/tmp/x.o:g" targetname: "__indirect_call" }\n'
        with self.assertRaisesRegex(BenchError, "g calls through a pointer"):
            self.deepest(text)
        self.assertEqual(self.deepest(text, {"g": ("f.part.0",)})[0], 16 + 8 + 24)

    def test_a_call_of_what_is_not_linked_is_none(self):
        frames, calls = stack.parse(GRAPH)
        self.assertEqual(stack.linked(frames, calls, {"memset"}.__contains__), calls)
        self.assertEqual(stack.linked(frames, calls, lambda name: False), calls | {"g": set()})

    def test_recursion_and_unbounded_frames_are_refused(self):
        text = GRAPH + 'edge: { sourcename: "/tmp/x.o:g" targetname: "main" }\n'
        with self.assertRaisesRegex(BenchError, "main calls itself"):
            self.deepest(text)
        with self.assertRaisesRegex(BenchError, "no fixed size"):
            self.deepest(GRAPH.replace("8 bytes (static)", "8 bytes (dynamic)"))

    def test_frame_of_a_library_function(self):
        code = "    push {r4, r5, lr}\n    sub sp, #20\n    bl other\n    add sp, #20\n" \
               "    pop {r4, r5, pc}\n    .size counted, .-counted\n    .type other, %function\n" \
               "other:\n    bx lr\n    .size other, .-other\n"
        image = assembled(self.folder, "cortex-m0plus", code, 1)
        self.assertEqual(stack.library_frame(image, "counted"), (32, {"other"}))


class Budget(Program):
    FIGURES = {"cortex-m4.published": {"run_max": 400, "run_mean": 299.5}}

    def read(self, text):
        path = self.folder / "budget.toml"
        path.write_text(text)
        return budget.read(path)

    def findings(self, text):
        return budget.findings(self.FIGURES, self.read(text))

    def test_both_sides(self):
        group = "[cortex-m4.published]\nrun_max = {}\nrun_mean = [290, 310]\n"
        self.assertEqual(self.findings(group.format("[400, 400]")), [])
        name = "cortex-m4.published.run_max: 400, "
        self.assertEqual(self.findings(group.format("[1, 399]")),
                         [name + "more than allowed (1 to 399)"])
        self.assertEqual(self.findings(group.format("[401, 500]")),
                         [name + "less than allowed (401 to 500)"])

    def test_each_figure_is_in_both(self):
        found = self.findings("[cortex-m4.published]\nrun_max = [1, 999]\nstack = [1, 2]\n")
        self.assertEqual(found, ["cortex-m4.published.run_mean: 299.5, not in the budget",
                                 "cortex-m4.published.stack: not measured, allowed 1 to 2"])

    def test_written_budget_allows_what_was_measured(self):
        text = budget.as_toml(self.FIGURES)
        self.assertEqual(self.findings(text), [])
        self.assertEqual(self.read(text)["cortex-m4.published"]["run_max"], [360, 412])

    def test_bad_budgets(self):
        for text in ("[cortex-m4.x]\na = 3\n", "[cortex-m4.x]\na = [2, 1]\n", "[cortex-m4.x\n",
                     "[cortex-m4.x]\na = [1, 2, 3]\n", '[cortex-m4.x]\na = ["1", "2"]\n',
                     "core = 3\n", "[core]\na = [1, 2]\n"):
            with self.subTest(text), self.assertRaises(BenchError):
                self.read(text)


class Replays(unittest.TestCase):
    """The image itself."""

    @classmethod
    def setUpClass(cls):
        cls.image = Image(IMAGE)
        cls.recording = replay.read_recording(FOLDER)
        cls.bench = replay.Bench("cortex-m3", "published", cls.image, Decoder(cls.image.content), (
            replay.replay("cortex-m3", cls.image, "s1", cls.recording, lambda size: None),))

    def test_every_tick_is_counted_under_its_state(self):
        frames = self.recording["frames.nfr"]
        frame_bytes = replay.HEADER.unpack_from(frames)[2]
        ticks = (len(frames) - replay.HEADER.size) // frame_bytes
        ways = self.bench.replays[0].ways
        self.assertEqual(ways.total(), ticks)
        by_state = Counter(replay.states_of(self.recording["results.nfr"]))
        for state in by_state:
            self.assertEqual(self.bench.ways(state).total(), by_state[state])

    def test_profile_leaves_nothing_out(self):
        ways = self.bench.ways("RUN")
        instructions = sum(len(block.instructions) * ticks for way, ticks in ways.items()
                           for block in self.bench.blocks(way))
        for by_line in (False, True):
            shares = profile.profile(self.bench, "RUN", by_line)
            self.assertAlmostEqual(sum(share.mean for share in shares),
                                   instructions / ways.total(), places=6)
        self.assertIn("nn_observer.c", " ".join(share.file for share in shares))

    def test_sizes_leave_nothing_out(self):
        found = sizes.measure(self.image)
        self.assertEqual(sum(found.code.values()), found.sections[".text"])
        self.assertEqual(sum(found.constants.values()), found.sections[".rodata"])

    def test_measured_stack_is_within_the_computed(self):
        size, _ = stack.computed(self.image, replay.ENTRY)
        self.assertLessEqual(self.bench.replays[0].stack_bytes, size)

    def test_another_result_is_no_figure(self):
        wrong = bytearray(self.recording["results.nfr"])
        wrong[-1] ^= 1
        with self.assertRaisesRegex(BenchError, "other results than on the PC"):
            replay.replay("cortex-m3", self.image, "s1",
                          self.recording | {"results.nfr": bytes(wrong)}, lambda size: None)


class CommandLine(unittest.TestCase):
    def test_bad_input(self):
        for words, text in ((["--build", "/nowhere"], "/nowhere/host/record: no such program"),
                            (["--cores", "cortex-m9"], "'cortex-m9' is none of cortex-m0plus"),
                            (["--state", "FLYING"], "invalid choice: 'FLYING'"),
                            (["--write-budget", "--cores", "cortex-m4"], "all cores")):
            with self.subTest(words):
                status, _, errors = captured(bench_target.main, *words)
                self.assertEqual(status, 2)
                self.assertIn(text, errors.splitlines()[-1])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
