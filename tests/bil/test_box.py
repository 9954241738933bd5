# SPDX-License-Identifier: MIT
"""target.loop.box: what the image keeps of a run that a fault, a reset or a loss of power ends.

test_box.py IMAGE BOARD CLOCK MOTORSIM [TEST...]: the board is reset at random instants of a run, within the background and the
control interrupt, and its power fails in steps of its flash. What it sends then is a whole recording, which MOTORSIM replays
bit for bit, or it says by rule why there is none.
"""

import random
import re
import struct
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import board
import many_runs
from copies import in_a_copy
from core import NEVER, RAM, THREAD
from digital import WatchdogBites
from flash import PowerFails, box_of
from rig import CALIBRATION_TICKS, STAGE, WIRING, address_of, answer, change_what_is_read, reset
from test_recorder import POST_TICKS, RECORDED, Drive, replay

INSTANTS = many_runs.of(8, 80, 300)
STRIDE = many_runs.of(211, 13, 1)
EDGE = 5 if many_runs.are_asked() else 2  # steps at either end that do something else: stamps, erases, the first words
LEAST_TICKS = 200
RESCUE_S = 0.6  # more than a start takes that saves the recording
SAVING_TICKS = 1500  # more than a saving takes
READY, FAULT = 0x2B, 0xA5  # drive_state_t, whose codes ascend
HARD_FAULT = 3
SAVED = "; the run before it is saved, `last` sends it"
EARLIER = "; an earlier recording is saved, `last` sends it"
NOTHING = "; no recording is saved"
NONE = "; no recording of the run before it: "
RESETS = {"watchdog": board.WATCHDOG_FLAG, "pin": 0, "software": board.SOFTWARE_FLAG, "supply": board.SUPPLY_FLAG,
          "watchdog after exception 3": board.WATCHDOG_FLAG}


def state_of(made):
    """The drive's state, which is after the pointer to its configuration."""
    return struct.unpack("<I", made.core.uc.mem_read(address_of("app") + 4, 4))[0]


def started(made):
    """What the board says when it has started."""
    made.chip.usart.instant = True
    made.boot()
    return re.search(r"last reset: [^\r]*", made.said())[0].removeprefix("last reset: ")


def sent(made, command, end):
    """What it sends after a command, until a line that begins so."""
    made.said()
    made.type(command)
    said = made.said()
    while not re.search(rf"^{end}", said, re.MULTILINE):
        made.tick()
        said += made.said()
    return said


def last(made):
    return sent(made, "last", "dump ends|error")


def faults(made):
    said = answer(made, "faults")
    while len(more := (made.tick(), made.said())[1]):
        said += more
    return said


REPLAYED = {}


class Kept(unittest.TestCase):
    def assert_replays(self, log, least=LEAST_TICKS):
        if log not in REPLAYED:
            run = replay(log)
            self.assertEqual(run.returncode, RECORDED, run.stdout + run.stderr)
            self.assertIn("are those recorded", run.stdout)
            REPLAYED[log] = run.stdout
        first, end = map(int, re.search(r"ticks (\d+) to (\d+):", REPLAYED[log]).groups())
        self.assertGreaterEqual(end - first + 1, least)
        return REPLAYED[log]


class Fault(Kept):
    def test_it_is_saved_and_sent_after_a_loss_of_power(self):
        drive = Drive()
        drive.tick(1500)
        tick = drive.fail_and_record(SAVING_TICKS)
        made = reset(drive.board, board.SUPPLY_FLAG, ram=False)
        self.assertEqual(started(made), "supply" + EARLIER)
        out = self.assert_replays(last(made))
        self.assertIn(f"fault at tick {tick}, ", out)
        self.assertIn("\n  last reset: pin\n", out)
        self.assertRegex(faults(made), r"1: power-up 1, 0 s: OVERVOLTAGE \d+\.\d+ V, limit \d+\.\d+ V\r")
        self.assertIn(", last reset: supply\r", answer(made, "status"))

    def test_the_next_fault_is_recorded_and_saved_too_and_the_log_has_both(self):
        drive = Drive()
        drive.tick(600)
        drive.fail_and_record(SAVING_TICKS)
        drive.clear_and_run()
        second = drive.fail_and_record(SAVING_TICKS)
        made = reset(drive.board, board.SUPPLY_FLAG, ram=False)
        self.assertEqual(started(made), "supply" + EARLIER)
        self.assertIn(f"fault at tick {second}, ", self.assert_replays(last(made)))
        self.assertEqual(len(re.findall("power-up 1, .*OVERVOLTAGE", faults(made))), 2)

    def test_a_run_that_begins_while_it_is_saved_goes_on_and_the_next_rest_saves_it(self):
        drive = Drive()
        drive.tick(600)
        tick = drive.fail_and_record(POST_TICKS + 60)
        drive.clear_and_run()
        self.assertTrue(drive.board.chip.timer.gates_on())
        drive.board.type("stop")
        drive.tick(SAVING_TICKS)
        made = reset(drive.board, board.SUPPLY_FLAG, ram=False)
        started(made)
        self.assertIn(f"fault at tick {tick}, ", self.assert_replays(last(made)))

    def test_console_and_watchdog_go_on_while_it_is_saved(self):
        drive = Drive()
        drive.tick(600)
        drive.fail_and_record(POST_TICKS + 3)
        steps = drive.board.chip.power.flash.steps
        for _ in range(20):
            drive.tick(5)
            self.assertIn("FAULT by OVERVOLTAGE", answer(drive.board, "status"))
        self.assertGreater(drive.board.chip.power.flash.steps, steps + 20)


class Instants(Kept):
    """Of a run, in the background and in the interrupt."""

    @classmethod
    def setUpClass(cls):
        cls.drive = Drive()
        cls.drive.tick(400)

    def interrupted(self, chance):
        """The board some ticks and instructions later."""
        drive = self.drive
        begin = chance.choice((0, 0, 0, 1, 2))
        if begin == 1:
            drive.fail_and_record(chance.randrange(2 * POST_TICKS))
        elif begin == 2:
            drive.fail_and_record(SAVING_TICKS)
        else:
            drive.tick(chance.randrange(1, 900))
        if chance.random() < 0.5:
            drive.tick(background=chance.randrange(1, 300))
        else:
            drive.board.chip.wait_for_exception()
            drive.board.core.handle(drive.board.chip.system.take(THREAD), instructions=chance.randrange(1, 900))
        return drive.board

    def kept(self, seed):
        """How the board was stopped, its state, what it says after that, what it sends, and its log."""
        chance = random.Random(seed)
        made = self.interrupted(chance)
        how = chance.choice(list(RESETS))
        if how.endswith("3"):
            made.core.handle(HARD_FAULT, instructions=1000)
        lost = chance.random() < 0.2  # the supply, in place of this
        again = reset(made, board.SUPPLY_FLAG if lost else RESETS[how], ram=not lost)
        state = state_of(made)
        said = started(again)
        log = last(again)
        if not log.startswith("ok"):
            log = ""
        return "\0".join([how, str(int(lost)), str(state), said, log, faults(again)])

    def test_a_reset_at_any_of_them_leaves_a_whole_recording_or_none_by_rule(self):
        count = {}
        for seed in range(INSTANTS):
            with self.subTest(seed):
                how, lost, state, said, log, told = in_a_copy(lambda seed=seed: self.kept(seed)).split("\0")
                reason, _, what = said.partition(";")
                what = ";" + what
                count[what] = count.get(what, 0) + 1
                if int(lost):
                    self.assertEqual(reason, "supply")
                    self.assertIn(what, (EARLIER, NOTHING))
                    self.assertEqual(what == EARLIER, bool(log))
                else:
                    self.assertEqual(reason, how)
                    self.assert_rule(int(state), what, told)
                if log:
                    out = self.assert_replays(log)
                    if what == SAVED and "fault at" not in out:
                        self.assertIn(f"\n  ends with a reset: {how}\n", out)
                    if int(state) == FAULT:
                        self.assertIn("OVERVOLTAGE", out)
        print(f"{INSTANTS} instants:", *(f"{number}{what}" for what, number in sorted(count.items())))

    def assert_rule(self, state, what, told):
        """What is said of a run that was in this state."""
        if state == FAULT:
            self.assertIn(what, (SAVED, NONE + "it was saved before"))
            self.assertTrue("OVERVOLTAGE" in told or what == SAVED)  # the background may not have seen it
        else:
            self.assertGreater(state, READY)
            self.assertEqual(what, SAVED)
            self.assertIn("reset: ", told)

    def test_a_lock_up_is_ended_by_the_watchdog_and_saved(self):
        def act():
            made = self.drive.board
            made.core.handle(HARD_FAULT, instructions=1000)
            try:
                made.chip.wait(NEVER)
                while True:  # the core does nothing any more
                    made.chip.wait(NEVER)
            except WatchdogBites:
                pass
            again = reset(made, board.WATCHDOG_FLAG)
            return started(again) + "\n" + last(again)

        said, _, log = in_a_copy(act).partition("\n")
        self.assertEqual(said, "watchdog after exception 3" + SAVED)
        self.assert_replays(log)

    def test_a_ram_that_a_short_loss_of_the_supply_has_changed_is_no_recording(self):
        def act(seed):
            again = reset(self.drive.board, board.SUPPLY_FLAG)
            chance = random.Random(seed)
            ram = bytearray(again.core.ram())
            for _ in range(1 << chance.randrange(1, 17)):
                ram[chance.randrange(len(ram))] ^= 1 << chance.randrange(8)
            again.core.set_ram(bytes(ram))
            return started(again) + "\n" + last(again)

        for seed in range(INSTANTS // 2):
            with self.subTest(seed):
                said, _, log = in_a_copy(lambda seed=seed: act(seed)).partition("\n")
                self.assertIn(said.removeprefix("supply"), (SAVED, NONE + "what lies in the RAM is no recording"))
                if said.endswith(SAVED):
                    self.assert_replays(log, least=1)  # an older part may have changed

    def test_a_ram_that_is_broken_after_a_reset_keeps_the_drive_from_starting(self):
        """The stack's end is tested before the rescue, what is kept behind it."""
        for place in (RAM + 0x40, address_of("ring")):
            with self.subTest(hex(place)):
                again = reset(self.drive.board, board.WATCHDOG_FLAG)
                change_what_is_read(again, place, lambda word: word | 1 << 7)
                again.go_on(RESCUE_S)
                self.assertIn("cannot start:\r\nthe RAM does not hold what is written\r\n", again.said())
                self.assertFalse(again.chip.timer.gates_on())

    def test_a_flash_that_keeps_nothing_after_a_reset_is_said_and_the_drive_starts(self):
        for fault in ({"deaf": lambda: True}, {"protected": True}):
            with self.subTest(fault):
                again = reset(self.drive.board, board.WATCHDOG_FLAG)
                vars(again.chip.power.flash).update(fault)
                self.assertEqual(started(again), "watchdog" + NONE + "the flash does not keep what is written")
                again.tick(CALIBRATION_TICKS)
                self.assertIn("READY", answer(again, "status"))

    def test_a_reset_that_this_image_never_makes_is_told_as_such(self):
        for flag in (1 << 25, 1 << 30, 1 << 31):  # option bytes, the window watchdog, low power: RM0440 7.4.28
            self.assertEqual(started(reset(self.drive.board, flag)), "of another kind" + SAVED)

    def test_another_image_does_not_look_at_the_ram(self):
        def act():
            again = reset(self.drive.board, 0)
            words = again.chip.power.backup.words
            again.chip.power.backup.words = [word ^ (number == 7) << 9 for number, word in enumerate(words)]
            return started(again)

        self.assertEqual(in_a_copy(act), "pin" + NOTHING)


class Cuts(Kept):
    """Power fails in a step of the flash: each of the first and last ones, and every STRIDEth between, which all program."""

    @classmethod
    def setUpClass(cls):
        cls.drive = Drive()
        cls.drive.tick(500)
        cls.first = cls.drive.fail_and_record(SAVING_TICKS)
        cls.drive.clear_and_run()
        cls.drive.tick(300)

    def cuts(self, steps):
        return [cut for cut in range(steps) if cut < EDGE or cut >= steps - EDGE or cut % STRIDE == 0]

    def after_cut(self, act, cut):
        """What a start finds when power has failed in this step of `act`, which returns the flash that it has used."""
        flash = self.drive.board.chip.power.flash
        content, steps = flash, flash.steps
        try:
            content, how = act(cut), "whole"
        except PowerFails as failure:
            content, how = failure.args[0] if failure.args else flash, "cut"
        again = reset(self.drive.board, board.SUPPLY_FLAG, ram=False)
        again.chip.power.flash.units = dict(content.units)
        return "\n".join([how, str(content.steps - (steps if content is flash else 0)), started(again), last(again)])

    def save_of_a_fault(self, cut):
        flash = self.drive.board.chip.power.flash
        flash.chance.seed(cut)
        flash.cut = flash.steps + cut
        self.drive.fail_and_record(SAVING_TICKS)
        return flash

    def save_at_a_start(self, cut):
        again = reset(self.drive.board, board.WATCHDOG_FLAG)
        flash = again.chip.power.flash
        flash.chance.seed(cut)
        flash.cut = cut
        try:
            started(again)
        except PowerFails as failure:
            raise PowerFails(flash) from failure
        return flash

    def assert_cuts(self, act, ends):
        """What is found is the first recording, or that which `ends` so: this one once it was whole."""
        steps = int(in_a_copy(lambda: self.after_cut(act, 10 ** 6)).split("\n")[1])
        for cut in [*self.cuts(steps), steps]:
            with self.subTest(cut):
                how, _, said, log = in_a_copy(lambda cut=cut: self.after_cut(act, cut)).split("\n", 3)
                self.assertEqual(how, "whole" if cut == steps else "cut")
                self.assertEqual(said, "supply" + EARLIER)
                out = self.assert_replays(log)
                old = f"fault at tick {self.first}, " in out
                self.assertTrue(old or ends in out, out)
                self.assertFalse(old and how == "whole")
        print(f"{len(self.cuts(steps))} cuts in the {steps} steps")

    def test_of_a_saving_after_a_fault(self):
        self.assert_cuts(self.save_of_a_fault, "OVERVOLTAGE")

    def test_of_a_saving_at_a_start(self):
        self.assert_cuts(self.save_at_a_start, "ends with a reset: watchdog")


class Flash(unittest.TestCase):
    def test_nothing_of_the_image_lies_in_its_pages(self):
        import elf
        from rig import IMAGE
        self.assertLessEqual(max(address + len(data) for address, data in elf.segments(IMAGE)), box_of(WIRING.facts))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]])
