# SPDX-License-Identifier: MIT
"""evidence.pin_maps: random board files of the STM32G4 family. nfconfig takes those that the facts of the chips allow, and no others;
it says what is wrong with a refused one; and the image of an accepted one measures, switches and opens in the emulator.

pin_maps.py NFCONFIG CLOCK [--number N] [--seed N] [--build FOLDER] [--out FILE]: rules of its own (pin_rules.py) judge each file,
too. Files and image stay in the folder, so that a map can be looked at.
"""

import argparse
import collections
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pin_draw
import pin_rules

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TARGET = "neurofoc_esc1"  # the image whose generated files are replaced: it needs no report of random motors
TUNING = "any"
PATIENCE_S = 120  # a map takes one or two
FILES = {"hal_config.h": "hal-header", "drive_config.h": "header", "hal_memory.ld": "hal-memory"}
REFUSAL = re.compile(r"nfconfig: (?P<file>.*?)(?::(?P<line>\d+))?: (?P<table>board|hal)\.(?P<key>\w+) = (?P<value>.*?): (?P<problem>.+); "
                     r"allowed: (?P<allowed>.+)\n")
SAYS = ("Random board files of four STM32G4 chips: pins, gates with enables or without, amplifiers inside or outside, comparators or "
        "a fault line, two or three shunts, polarities, crystals. Half of them are spoilt. Rules of their own, which search the facts "
        "in `tests/chips` for an assignment of pins, say whether a file has to be accepted; nfconfig has to agree. A refusal names the "
        "line, the key, what is written there and what is allowed. The image of an accepted file runs in the emulator: it becomes "
        "ready, shows each current, switches each phase, opens the gates by comparator or fault line without software, and its "
        "watchdog bites when the ticks stop.")


class Failed(Exception):
    """An image that cannot be built or does not work."""


class Map:
    """A drawn board file, and what becomes of it."""

    def __init__(self, draw, file):
        self.draw, self.file = draw, file
        self.problems = pin_rules.Rules(draw.stage, draw.hal).problems()
        file.write_text(pin_draw.text(draw), encoding="utf-8")

    def arguments(self):
        return ["--motor", pin_draw.MOTORS[self.draw.base], "--board", self.file, "--tuning", TUNING]

    def kind(self):
        """A row of the table."""
        hal = self.draw.hal
        return (hal["chip"], "inside" if hal["pga_gain"] > 1 else "outside", "fault line" if hal.get("break_pin") else "comparators")


def configure(folder, nfconfig):
    """Without optimisation of the whole image: then only what reads a board's numbers is compiled again. It is
    compiled for size (-Os), because it would not fit into the flash otherwise."""
    for command in (["cmake", "-S", ROOT, "--preset", "stm32g4", "-B", folder, f"-DNF_NFCONFIG={nfconfig}",
                     "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-Os -g -fno-lto"], ["cmake", "--build", folder, "--target", TARGET]):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise Failed(done.stdout + done.stderr)


def made_by(nfconfig, one, command):
    """(what nfconfig writes for a map, "") or (None, its refusal)."""
    done = subprocess.run([nfconfig, command, *one.arguments()], capture_output=True, text=True, check=False)
    return (done.stdout, "") if done.returncode == 0 else (None, done.stderr)


def build(folder, nfconfig, one):
    for name, command in FILES.items():
        text, refusal = made_by(nfconfig, one, command)
        if text is None:
            raise Failed(refusal)
        (folder / "hal/stm32g4" / f"{TARGET}_config" / name).write_text(text, encoding="utf-8")
    done = subprocess.run(["cmake", "--build", folder, "--target", TARGET], capture_output=True, text=True, check=False)
    if done.returncode:
        raise Failed(done.stdout[-2000:])
    return folder / f"{TARGET}.elf"


def emulate(image, one, clock):
    """The tests of a map's wiring."""
    try:
        done = subprocess.run([sys.executable, "-B", HERE / "test_pin_map.py", image, one.file, clock], capture_output=True,
                              text=True, check=False, timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        raise Failed(f"no end within {PATIENCE_S} s") from None
    if done.returncode:
        raise Failed(done.stderr[-2000:])


def written(one, table, key):
    values = one.draw.stage if table == "board" else one.draw.hal
    value = values.get(key, [])  # what is not written is an empty list
    return value if isinstance(value, list) else [value]


def bad_refusal(one, said):
    """What a refusal lacks, each in a line."""
    match = REFUSAL.fullmatch(said)
    if not match:
        yield f"is not FILE:LINE: KEY = VALUE: PROBLEM; allowed: ...: {said.strip()}"
        return
    key, value = match["key"], match["value"]
    blamed = {name for problem in one.problems for name in problem.keys}
    if key not in blamed:
        yield f"blames {key}, and the rules {sorted(blamed)}: {said.strip()}"
    if match["file"] != str(one.file) or not _is_at(one, key, match["line"]):
        yield f"names another line: {said.strip()}"
    texts = [str(item) for item in written(one, match["table"], key)]
    shown = f"[{', '.join(texts)}]"
    if value.strip('"') not in (*texts, shown) and not _is_number(value, texts):
        yield f"shows another value than {texts}: {said.strip()}"


def _is_at(one, key, number):
    """Whether that is the key's line; a key that is not written has none."""
    lines = one.file.read_text(encoding="utf-8").splitlines()
    places = [str(place) for place, line in enumerate(lines, start=1) if line.startswith(f"{key} =")]
    return number in places if places else number is None


def _is_number(value, texts):
    try:
        return any(float(value) == float(text) for text in texts)
    except ValueError:
        return False


class Trial:
    """All maps, one after the other."""

    def __init__(self, nfconfig, judge):
        """`judge`: a function that runs an accepted map, and raises Failed."""
        self.nfconfig, self.judge = nfconfig, judge
        self.accepted, self.refused = collections.Counter(), collections.Counter()
        self.disagreements, self.bad_refusals, self.failures = [], [], []

    def try_one(self, one):
        text, refusal = made_by(self.nfconfig, one, "hal-header")
        if (text is None) != bool(one.problems):
            reason = refusal.strip() or "; ".join(f"{problem.keys}: {problem.says}" for problem in one.problems)
            self.disagreements.append(f"{one.file}: nfconfig {'refuses' if text is None else 'accepts'} it: {reason}")
        elif text is None:
            self.refused[REFUSAL.sub(r"\g<table>.\g<key>", refusal)] += 1
            self.bad_refusals += [f"{one.file}: the refusal {lack}" for lack in bad_refusal(one, refusal)]
        else:
            self.accepted[one.kind()] += 1
            self.run(one)

    def run(self, one):
        try:
            self.judge(one)
        except Failed as failure:
            self.failures.append(f"{one.file}: {failure}")

    def findings(self):
        return self.disagreements + self.bad_refusals + self.failures


def drawn(number, seed, folder):
    """So many maps, every other one possible, the rest spoilt in some way."""
    source = random.Random(seed)
    for index in range(number):
        draw = pin_draw.possible(source) if index % 2 == 0 else pin_draw.spoilt(source)
        yield Map(draw, folder / f"map_{index}.toml")


def in_emulator(folder, nfconfig, clock):
    """A judge that builds in a folder."""
    configure(folder, nfconfig)
    return lambda one: emulate(build(folder, nfconfig, one), one, clock)


def trial_of(args):
    shutil.rmtree(args.build, ignore_errors=True)
    maps = args.build / "maps"
    maps.mkdir(parents=True)
    trial = Trial(args.nfconfig, in_emulator(args.build / "image", args.nfconfig, args.clock))
    for index, one in enumerate(drawn(args.number, args.seed, maps)):
        trial.try_one(one)
        if index % 20 == 19:
            print(f"{index + 1} of {args.number} maps, {sum(trial.accepted.values())} accepted, "
                  f"{len(trial.findings())} findings", flush=True)
    return trial


def rows(counts):
    return [[*(key if isinstance(key, tuple) else (key,)), count] for key, count in sorted(counts.items())]


def main():
    import part  # of tools/evidence, on PYTHONPATH

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("nfconfig", type=lambda text: Path(text).resolve())
    parser.add_argument("clock", type=lambda text: Path(text).resolve())
    parser.add_argument("--number", type=int, default=300)
    parser.add_argument("--seed", type=int, default=45)
    parser.add_argument("--build", type=lambda text: Path(text).resolve(), default=ROOT / "build/pin_maps")
    args = part.arguments(parser)
    print(f"seed {args.seed}", flush=True)
    trial = trial_of(args)
    accepted, refused = sum(trial.accepted.values()), sum(trial.refused.values())
    return part.end(
        args.out, "pin_maps", "Pin maps", SAYS,
        [part.figure("disagreements with the rules", len(trial.disagreements), 0, not trial.disagreements),
         part.figure("refusals without line, key, value and range", len(trial.bad_refusals), 0, not trial.bad_refusals),
         part.figure("accepted maps that fail in the emulator", len(trial.failures), 0, not trial.failures),
         part.figure("maps accepted", f"{accepted} of {args.number}", "a third", 3 * accepted >= args.number),
         part.figure("maps refused", f"{refused} of {args.number}", "a quarter", 4 * refused >= args.number)],
        [part.table(f"Accepted maps, seed {args.seed}", ["chip", "amplifiers", "trip", "maps"], rows(trial.accepted)),
         part.table("Refused maps", ["key", "maps"], rows(trial.refused))], trial.findings())


if __name__ == "__main__":
    sys.exit(main())
