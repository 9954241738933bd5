# SPDX-License-Identifier: MIT
"""target.loop.store: which configuration the image of a board starts with, by what is in the slots of its flash.

test_store.py IMAGE BOARD CLOCK NFCONFIG. A slot is written here as store.h says, a second time.
"""

import binascii
import struct
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import board
import digital
import elf
import many_runs
from copies import in_a_copy
from flash import LOCK, PAGE, PowerFails, store_of
from link import Link
from rig import BOARD, CALIBRATION_TICKS, IMAGE, STAGE, WIRING, answer, booted, make, ready

NFCONFIG = Path(sys.argv[4])
STRIDE = 1 if many_runs.are_asked() else 47
EDGE = 6  # steps at either end that do something else: an erase, the first words, stamps
SLOTS = (store_of(WIRING.facts), store_of(WIRING.facts) + PAGE)
STAMPS = 192 * 8  # bytes of a slot before them
MAGIC, SCHEMA_AT, BOARD_AT = b"NFCB", 12, 16
# Motor and tuning of the image, another motor that the board can drive, and another tuning.
IMAGES, OWN, OTHERS, OTHER = {
    "g431_bench": ("motor_a", "robust_motor_a", "motor_b", "any"),
    "g474_in_line": ("outrunner_48v", "any", "teknic_m2310p", "published"),
}[BOARD.stem]


def motor_file(motor):
    return tomllib.loads((BOARD.parent.parent / "motors" / f"{motor}.toml").read_text(encoding="utf-8"))["motor"]


def name_of(motor, tuning):
    path = BOARD.parent.parent / "tunings" / f"{tuning}.toml"
    title = tomllib.loads(path.read_text(encoding="utf-8"))["tuning"]["name"]
    return f"neurofoc: {motor_file(motor)['name']}, {STAGE['name']}, {title}"


IMAGES_NAME = name_of(IMAGES, OWN)
OTHERS_NAME = name_of(OTHERS, "any")


def block(motor=OTHERS, tuning="any"):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.nfb"
        subprocess.run([NFCONFIG, "block", "--motor", motor, "--board", BOARD, "--tuning", tuning, "-o", file],
                       check=True)
        return file.read_bytes()


def sealed(data):
    return data[:-4] + struct.pack("<I", binascii.crc32(data[:-4]))


def changed(data, at, value=0):
    return sealed(data[:at] + struct.pack("<I", value) + data[at + 4:])


def slot(number, data, sequence=2):
    stamp = struct.pack("<I", sequence)
    stamp += struct.pack("<I", binascii.crc32(stamp + data[-4:]))
    return [(SLOTS[number], data), (SLOTS[number] + STAMPS, stamp)]


class Store(unittest.TestCase):
    def start(self, *flashed):
        self.made = ready(flashed=[part for parts in flashed for part in parts])
        said = self.made.said().splitlines()
        self.assertIn("READY", said[-1])
        return said[0], said[1]

    def test_a_stored_block_of_another_motor_is_what_it_runs_with(self):
        self.assertEqual(self.start(slot(0, block())), (OTHERS_NAME, "configuration: the stored one"))
        self.assertIn(f"at most {motor_file(OTHERS)['max_speed_rpm']:.0f} either way", answer(self.made, "speed x"))

    def test_of_two_blocks_the_newer_one_counts(self):
        images, others = block(IMAGES, OWN), block()
        self.assertEqual(self.start(slot(0, images, 4), slot(1, others, 6))[0], OTHERS_NAME)
        self.assertEqual(self.start(slot(0, images, 8), slot(1, others, 6))[0], IMAGES_NAME)

    def test_without_a_block_for_it_the_image_has_its_own_configuration_and_says_why(self):
        good, none, another = block(), "none is stored", "not the stored one: the block was made for another "
        damaged = good[:300] + bytes([good[300] ^ 1]) + good[301:]
        for flashed, why in (([], none), (slot(0, damaged), none), (slot(0, good)[:1], none),  # without its stamp
                             (slot(0, changed(good, SCHEMA_AT)), another + "firmware"),
                             (slot(0, changed(good, BOARD_AT)), another + "board")):
            with self.subTest(why, parts=len(flashed)):
                self.assertEqual(self.start(flashed), (IMAGES_NAME, f"configuration: that of the image, {why}"))

    def test_nothing_of_the_image_lies_in_the_slots(self):
        self.assertLessEqual(max(address + len(data) for address, data in elf.segments(IMAGE)), SLOTS[0])


class Linked(unittest.TestCase):
    """A board whose image stores by way of its link."""

    LINE_TAKES_TIME = True

    @classmethod
    def setUpClass(cls):
        cls.made = booted()
        cls.flash = cls.made.chip.power.flash
        cls.made.chip.usart.instant = not cls.LINE_TAKES_TIME
        cls.made.tick(CALIBRATION_TICKS)
        cls.link = Link(cls.made)
        cls.link.hello()

    @classmethod
    def apply(cls, data):
        cls.link.line("unlock")
        if verdict := cls.link.apply(data):
            raise AssertionError(verdict)
        cls.made.tick(2 * board.SLOW_TICKS + CALIBRATION_TICKS)  # some settings ask for new zeros


class Cuts(Linked):
    """Power fails in a step of a store: each of its first and last ones, and every STRIDEth between, which all program."""

    LINE_TAKES_TIME = False

    def start_behind(self, cut):
        """What a start says that follows a store without the power from this step on, and whether the store has ended."""
        flash = self.flash
        flash.chance.seed(cut)
        flash.cut = flash.steps + cut
        try:
            verdict = self.link.store()
        except PowerFails:
            verdict = "cut"
        again = make(flashed=flash.content())
        again.chip.usart.instant = True
        again.boot()
        return "\n".join([verdict, *again.said().splitlines()[:2]])

    def assert_cuts(self, steps, old, new):
        """Either block, and the new one once the store has ended."""
        cuts = [cut for cut in range(steps) if cut < EDGE or cut >= steps - EDGE or cut % STRIDE == 0]
        for cut in cuts:
            said = in_a_copy(lambda cut=cut: self.start_behind(cut))
            self.assertIn(said, ["\n".join(["cut", *old]), "\n".join(["cut", *new])], f"step {cut}")
        self.assertEqual(in_a_copy(lambda: self.start_behind(steps)), "\n".join(["", *new]))
        print(f"{len(cuts)} cuts in the {steps} steps of a store")

    def test_each_start_behind_a_cut_finds_the_old_block_or_the_new_one(self):
        of_image = (IMAGES_NAME, "configuration: that of the image, none is stored")
        first, second = ((name, "configuration: the stored one") for name in (
            name_of(IMAGES, OTHER), IMAGES_NAME))
        data = block(IMAGES, OTHER)
        units = -(-len(data) // 8)
        self.apply(data)
        self.assert_cuts(units + 2, of_image, first)  # an erase, the block, a stamp
        self.assertEqual(self.link.store(), "")
        self.apply(block(IMAGES, OWN))
        self.assert_cuts(units + 4, first, second)    # and two stamps of the block that is kept


class Refusals(Linked):
    """A flash that does not do what it should."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.apply(block(IMAGES, OTHER))

    def verdict(self, CR=None, settling=None, **of_flash):
        """Of a store with these in place of what the flash and the watchdog have."""
        def act():
            if CR is not None:
                self.flash["CR"] = CR
            if settling is not None:
                self.made.chip.watchdog.settling = settling
            vars(self.flash).update(of_flash)
            try:
                return self.link.store()
            except digital.WatchdogBites:
                return "reset"
        return in_a_copy(act)

    def test_one_that_takes_no_key_or_programs_nothing_is_said(self):
        for behind, faults, verdict in (
                ("no key", {"deaf": lambda: True}, "the flash cannot be erased"),
                ("no page can be erased", {"protected": True}, "the flash cannot be erased"),
                ("no key behind the erase", {"deaf": lambda: self.flash.steps > 0}, "the flash does not keep what is written"),
                ("nothing is programmed", {"refuses": True}, "the flash does not keep what is written")):
            with self.subTest(behind):
                self.assertEqual(self.verdict(**faults), verdict)

    def test_one_that_is_open_or_busy_is_stored_to(self):
        opened = self.flash["CR"] & ~LOCK
        for state, faults in (("open", {"CR": opened}), ("open and busy for 3 looks", {"CR": opened, "busy": 3}),
                              ("busy before the first step", {"busy": 3}),
                              ("lets the core run while it is busy", {"lasting": 3})):
            with self.subTest(state):
                self.assertEqual(self.verdict(**faults), "")

    def test_it_does_not_matter_how_fast_the_watchdog_takes_a_new_length(self):
        for deaf, verdict in ((False, ""), (True, "the flash cannot be erased")):
            self.assertEqual(self.verdict(settling=0, deaf=lambda deaf=deaf: deaf), verdict)

    def test_one_that_stays_busy_ends_in_a_reset(self):
        self.assertEqual(self.verdict(busy=10 ** 9), "reset")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
