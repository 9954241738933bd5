# SPDX-License-Identifier: MIT
"""target.loop.recorder: what the image records of a fault comes out again on the PC, bit for bit.

test_recorder.py IMAGE BOARD CLOCK MOTORSIM [TEST...]: the image in the emulator fails, sends its recording over its console, and
MOTORSIM replays it.
"""

import random
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import console
import many_runs
from copies import in_a_copy
from rig import BUS, CALIBRATION_TICKS, MIDDLE, answer, instant, make

MOTORSIM = Path(sys.argv[4])
OVERVOLTAGE = 4000  # of the bus' converter, beyond bus_max_v of the board
NOISE = 8           # counts
HISTORY_TICKS = 746  # three segments less their margins and the ticks of a slow period: recorder_entries of the board
POST_TICKS = 64
STRIDE = 1 if many_runs.are_asked() else 7  # instructions
COPY_INSTRUCTIONS = 188  # of a pass that copies the state at least: a word each
RECORDED, DEPARTS, REFUSED = 0, 1, 2


class Drive:
    """The board, running, with noise on all it measures."""

    def __init__(self, running=True):
        self.board = make()
        self.board.chip.usart.instant = True
        self.random = random.Random(1)
        self.board.boot()
        if running:
            self.run(noise=0)

    def run(self, noise=NOISE):
        """After the calibration."""
        self.tick(CALIBRATION_TICKS, noise)
        self.board.type("run")

    def tick(self, ticks=1, noise=NOISE, bus=BUS, background=0):
        """With `background`, that has so many instructions only until the next tick interrupts it."""
        for _ in range(ticks):
            a, b, c = (self.random.randint(-noise, noise) for _ in range(3))
            self.board.set_inputs(MIDDLE + a, MIDDLE + b, bus + c)
            self.board.tick(background=background)

    def fail(self):
        """Returns the drive's number of the tick that sees it."""
        self.tick()  # what was said may have ended within a conversion
        self.tick(bus=OVERVOLTAGE)
        return self.board.ticks - 1

    def fail_and_record(self, ticks=POST_TICKS + 3):
        """And so many ticks behind it."""
        tick = self.fail()
        self.tick(ticks)
        return tick

    def clear_and_run(self):
        self.board.type("clear")
        self.run()
        self.tick(200)  # behind the search, in which the gates open for a while

    def dump(self, ask=True):
        """All that the console says until the dump has ended."""
        said = self.board.said()
        if ask:
            self.board.type("dump")
        while "dump ends" not in said:
            self.tick()
            said += self.board.said()
        return said


def replay(log, *arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "field.log"
        path.write_text(log, newline="")
        return subprocess.run([MOTORSIM, "replay", path, *arguments], capture_output=True, text=True)


class Recorder(unittest.TestCase):
    def assert_replays(self, log):
        run = replay(log)
        self.assertEqual(run.returncode, RECORDED, run.stdout + run.stderr)
        self.assertIn("are those recorded", run.stdout)
        return run.stdout

    def assert_records_a_fault(self, drive):
        tick = drive.fail_and_record()
        self.assertIn(f"fault at tick {tick}, ", self.assert_replays(drive.dump()))

    def test_a_fault_comes_out_again_in_the_same_tick_with_the_same_state(self):
        drive = Drive()
        drive.tick(1500)  # without a motor LOST_PHASE comes soon
        self.assertTrue(drive.board.chip.timer.gates_on())
        tick = drive.fail()
        drive.tick(POST_TICKS + 100)
        out = self.assert_replays(drive.dump())
        self.assertIn(f"fault at tick {tick}, ", out)
        self.assertIn("OVERVOLTAGE", out)
        first, last, count = map(int, re.search(r"ticks (\d+) to (\d+): (\d+) of", out).groups())
        self.assertEqual(last, tick + POST_TICKS)
        self.assertGreaterEqual(count, HISTORY_TICKS)
        self.assertEqual(count, last - first + 1)

    def test_a_tick_may_interrupt_the_background_at_any_instruction_while_it_freezes(self):
        """The state that is copied, the offer and the frames that come upon it: the hash is that of the end.

        What the image dumps follows from what it is then: of those that are equal in that, one dumps.
        """
        drive = Drive(running=False)
        tick = drive.fail()
        drive.tick(POST_TICKS - 1)

        def go_on(instructions):
            drive.tick(background=instructions)
            slept = drive.board.core.asleep
            drive.tick(2)
            alive = drive.board.core.alive()
            return f"{'slept' if slept else 'interrupted'}\n{alive}\n{'' if alive in ends else drive.dump()}"

        ends, instructions, how = {}, 0, "interrupted"  # `ends`: of each state that the image can be in, where its recording ends
        while how == "interrupted":
            instructions += STRIDE
            how, alive, log = in_a_copy(lambda: go_on(instructions)).split("\n", 2)
            if alive not in ends:
                with self.subTest(instructions):
                    out = self.assert_replays(log)
                    self.assertIn(f"fault at tick {tick}, ", out)
                    ends[alive] = int(re.search(r"ticks \d+ to (\d+):", out)[1])
        self.assertGreater(instructions, COPY_INSTRUCTIONS)
        # Accepted at once; interrupted before the copy, or during it; between the copy and its offer.
        self.assertEqual(set(ends.values()), {tick + POST_TICKS + late for late in range(3)})

    def test_the_stepper_opens_on_the_tick_that_failed(self):
        drive = Drive()
        drive.tick(300)
        tick = drive.fail_and_record()
        log = drive.dump()
        with tempfile.NamedTemporaryFile("w") as script:
            script.write("print drive.tick.raw drive.fault.id drive.fault.tick.raw\nback 1\n"
                         "print state\n")
            script.flush()
            run = replay(log, "--debug", "--script", script.name)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertRegex(run.stdout, rf"drive\.tick .*raw {tick + 1} ")  # counted at its end
        self.assertRegex(run.stdout, rf"drive\.fault\.tick .*raw {tick} ")
        self.assertRegex(run.stdout, r"state +(?!FAULT)[A-Z_]+ ")

    def failed_and_cleared(self, cleared_after=POST_TICKS + 3):
        """A drive that runs after a fault, and the tick of that."""
        drive = Drive()
        drive.tick(200)
        tick = drive.fail_and_record(cleared_after)
        drive.clear_and_run()
        self.assertTrue(drive.board.chip.timer.gates_on())
        return drive, tick

    def status(self, drive):
        said = answer(drive.board, "status")
        drive.tick(2)
        return said + drive.board.said()

    def test_a_clear_keeps_the_recording_of_the_fault_until_it_is_dumped(self):
        for cleared_after in (3, POST_TICKS + 3):
            with self.subTest(cleared_after):
                drive, first = self.failed_and_cleared(cleared_after)
                self.assertIn(", keeps the recording of a fault: dump or record\r\n", self.status(drive))
                drive.fail()
                drive.board.type("clear")
                drive.tick(CALIBRATION_TICKS)
                self.assertIn(f" to {first + POST_TICKS}: ", self.assert_replays(drive.dump()))
                self.assertNotIn("keeps", self.status(drive))
                drive.tick(100)
                self.assert_records_a_fault(drive)

    def test_record_gives_up_the_recording_of_a_fault(self):
        drive, _ = self.failed_and_cleared()
        drive.board.said()
        drive.board.type("record")
        drive.tick(2)
        self.assertEqual(drive.board.said(), "ok\r\n")
        self.assertNotIn("keeps", self.status(drive))
        self.assert_records_a_fault(drive)

    def test_record_does_not_touch_what_is_being_dumped(self):
        drive, tick = self.failed_and_cleared()
        drive.board.type("dump")
        drive.tick(20)
        drive.board.type("record")
        log = drive.dump(ask=False)
        self.assertIn("error: a dump is under way", log)
        self.assertIn(f"fault at tick {tick}, ", self.assert_replays(log))

    def test_without_a_tick_a_dump_is_refused_in_one_line(self):
        """Before the first one, and when the next one does not come."""
        made = make()
        made.chip.usart.instant = True
        made.chip.timer.trigger = lambda: None
        made.boot()
        refused = "error: the control tick does not run, nothing is recorded"
        self.assertIn(refused, console.lines(answer(made, "dump")))
        self.assertEqual(made.ticks, 0)
        made = instant()
        made.chip.timer.trigger = lambda: None  # no conversion: the tick guard comes
        self.assertEqual(made.handle_next(), made.chip.system.SYSTICK)
        made.type("dump")
        self.assertEqual(made.said(), f"{refused}\r\n")

    def test_without_a_fault_the_drive_goes_on_and_is_recorded_again(self):
        drive = Drive()
        drive.tick(500)
        out = self.assert_replays(drive.dump())
        self.assertNotIn("fault", out)
        self.assertTrue(drive.board.chip.timer.gates_on())
        drive.tick(300)
        self.assert_records_a_fault(drive)

    def test_the_console_answers_and_the_drive_protects_itself_while_it_dumps(self):
        drive = Drive()
        drive.tick(500)
        drive.board.type("dump")
        drive.tick(20)
        drive.board.type("status")
        drive.board.type("dump")
        drive.fail()
        self.assertFalse(drive.board.chip.timer.gates_on())
        log = drive.dump(ask=False)
        self.assertIn("speed unknown, asked 0 rpm", log)
        self.assertIn("error: a dump is under way", log)
        self.assertIn("FAULT by OVERVOLTAGE", log)
        self.assert_replays(log)

    def test_a_log_with_several_dumps_gives_the_last(self):
        drive = Drive()
        drive.tick(200)
        first = drive.fail_and_record()
        log = drive.dump() + drive.dump()
        drive.clear_and_run()
        second = drive.fail_and_record()
        self.assertIn(f"fault at tick {first}, ", self.assert_replays(log))
        self.assertIn(f"fault at tick {second}, ", self.assert_replays(log + drive.dump()))

    def test_a_lost_line_or_a_wrong_bit_is_refused(self):
        drive = Drive()
        drive.tick(200)
        drive.fail_and_record()
        lines = drive.dump().splitlines(keepends=True)
        marked = [k for k, line in enumerate(lines) if line.startswith("~")]
        lost = marked[len(marked) // 2]
        flipped = lines[lost][:40] + ("A" if lines[lost][40] != "A" else "B") + lines[lost][41:]
        for changed, text in ((lines[:lost] + lines[lost + 1:], "is missing"),
                              (lines[:lost] + [flipped] + lines[lost + 1:], "it is damaged"),
                              (lines[:lost], "it is cut off")):
            with self.subTest(text):
                run = replay("".join(changed))
                self.assertEqual(run.returncode, REFUSED, run.stdout)
                self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
                self.assertIn(text, run.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]])
