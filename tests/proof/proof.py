# SPDX-License-Identifier: MIT
"""evidence.proof: no run-time error in the drive and in the recorder's step, proven by Frama-C's Eva.

Proven is an induction over the ticks: drive_init begins within the ranges of state.def, and one drive_step from any
state within them, with any valid configuration and any frame, ends within them and has no overflow, no conversion that
changes a value, no index out of its array, no division by zero, no shift too far, no uninitialised read. The same of
recorder_change and recorder_step, with the ranges of proof_of_recorder.c, and of the decoders of sensors, with those of
proof_of_shaft.c; and that no sample of the sum of the currents has a run-time error, with those of proof_of_current_sum.c.

As a proof without alarms can be empty, four things are asked for: that Frama-C ends well; that there is its list of
properties, with none that is not proven; that each entry gets to its end and asks for each range; and that one or the
other has been through every function and statement.
"""

import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tools" / "evidence"))

import part  # noqa: E402

SAYS = ("Frama-C's Eva proves by induction over the ticks that drive_init, drive_step, the decoders of sensors and recorder_step have no run-time "
        "error, for every valid configuration, every frame and every state that can be: no overflow, no conversion that "
        "changes a value, no index out of its array, no division by zero, no shift too far, no uninitialised read. Not "
        "part of it: what the background does beside the sum of the currents (the rest of the recorder, texts and dumps), the application's interrupt "
        "around these functions, the HALs, and the ARM forms of the arithmetic, in whose place is an equal formulation.")
FLOORS = ("math", "control", "protect", "config", "drive", "record")
DRIVE, RECORDER = "tests/proof/proof_of_drive.c", "tests/proof/proof_of_recorder.c"
CURRENT_SUM = "tests/proof/proof_of_current_sum.c"
SHAFT = "tests/proof/proof_of_shaft.c"
ENTRIES = {"proof_init": DRIVE, "proof_startup": DRIVE, "proof_startup_regulated": DRIVE, "proof_plain": DRIVE,
           "proof_plain_regulated": DRIVE, "proof_no_state": DRIVE, "proof_flipped": DRIVE, "proof_change": DRIVE, "proof_change_regulated": DRIVE,
           "proof_recorder": RECORDER, "proof_current_sum": CURRENT_SUM,
           "proof_hall": SHAFT, "proof_encoder": SHAFT, "proof_absolute": SHAFT}
CHECK = "check_state"  # what each entry ends with
NO_PART_OF_IT = {f"{name}.{kind}" for name in ("cobs", "config_block", "config_ceiling", "config_lock", "config_rule", "drive_words", "fault_text", "frame_code",
                                               "recorder_dump", "recorder_pack", "recorder_rescue")
                 for kind in "ch"}  # not called in a tick
BACKGROUND = {  # of the recorder
    "add_segment", "facts_of", "names_only", "note_further", "ticks_of_segment",
    "count_entries", "count_segments", "fill_view", "has_only_two", "is_configured",
    "is_nearly_full", "is_over", "note_end", "note_hash", "note_sums", "number_after", "offer", "other_config", "prepare", "recorder_begin_state", "recorder_end_state", "recorder_entry", "recorder_entry_is_change", "recorder_entry_sum",
    "recorder_find", "recorder_follow", "recorder_further_config", "recorder_hash", "recorder_history", "recorder_hold", "recorder_keep_state", "recorder_release",
    "recorder_newest", "recorder_service", "recorder_unpack", "segment_after", "segment_before", "sum_entries_to", "trigger",
}

# How many cases Eva keeps apart: those of the case distinctions in the code, and branches of small functions.
CASES = {
    DRIVE: {
        "fx_leading_zeros": 100, "trig_sqrt": 100, "root_of_normalised": 300, "whole_root": 0, "trig_sincos": 1100,
        "estimate_step": 300, "vector_measure": 200, "frame_modulate": 2000, "frame_modulate_plain": 2000, "judge": 50,
        "fx_approach": 20, "average": 20, "share_of": 100, "bits_beyond_15": 20, "heat_up": 60, "observer_rho": 10, "drive_step": 4, "check_samples": 20,
    },
    RECORDER: {"recorder_step": 20, "turn_over": 20, "room_for_tick": 20, "is_within": 10, "ring_is_within": 10},
    CURRENT_SUM: {"sum_of": 10, "current_sum_step": 20},
    SHAFT: {"span_of": 200, "speed_between": 10, "within_turn": 10, "ahead": 10, "expect_edge": 10, "hall_pace": 20},
}
OPTIONS = [
    "-c11", "-machdep", "gcc_x86_32", "-eva", "-eva-precision", "0", "-eva-ilevel", "16",
    "-eva-domains", "equality,symbolic-locations", "-eva-subdivide-non-linear", "10", "-eva-split-limit", "1024",
    "-warn-signed-downcast", "-warn-unsigned-downcast",
]
SPLIT_RETURN = {DRIVE: "fx_leading_zeros:full,protection_check:full", RECORDER: "fx_leading_zeros:full,ring_is_within:full,is_within:full",
                CURRENT_SUM: "fx_leading_zeros:full", SHAFT: "fx_leading_zeros:full"}
COLLECTED_SELDOM = {"OCAMLRUNPARAM": "s=4M,o=200"}  # garbage: a ninth of the time for some more memory
NOT_CALLED = {"crc32_word", "drive_knows_rotor", "drive_position_from_zero_q32", "drive_position_q32", "drive_reads_slow_inputs", "probe_is_done",
              "probing_current", "probing_may_brake", "schedule_next", "words_put"}  # by what is analysed
A_BRANCH_AN_ENTRY = {"drive_may_impose", "obey_when_ready", "run_is_to_be_held", "lowest_torque_speed", "next_free_reference"}  # start-up; sensor or none
UNASKED = "not asked for"
UNREACHED = "never gone through"
UNREACHED_STATEMENTS = "statements cannot be reached"

ASSUMED = re.compile(r"Neither code nor specification for function (\w+)")
FUNCTION = re.compile(r"^\w[\w \*]*?\b(\w+)\([^;]*?\)\s*\n\{", re.MULTILINE)
COVERED = re.compile(r"^  (\w+): (\d+) stmts out of (\d+) \(", re.MULTILINE)
RANGE = re.compile(r"state\.def:(\d+):\s+Frama_C_show_each_range:\s+(\[[^\]]*\]|\{[^}]*\})")
FIELD = re.compile(r"FIELD\(([^,]+), [^,]+, [^,]+, \w+\)")
OUT = re.compile(r"Frama_C_show_each_out:((?:\s+(?:\[[^\]]*\]|\{[^}]*\}),?(?:\d+%\d+,?)?){4})")


def functions(root):
    """The functions of the firmware that the proof has to go through."""
    found = set()
    for floor in FLOORS:
        for path in (root / "firmware" / floor).glob("*.[ch]"):
            if path.name not in NO_PART_OF_IT:
                found |= set(FUNCTION.findall(path.read_text(encoding="utf-8")))
    return found


def analyse(root, entry, folder):
    """Runs Eva from one entry: exit code, output, properties that are not proven, or None without a list of them."""
    paths = ["-Ifirmware/math", "-Itests/proof/port", "-Ifirmware/control", "-Ifirmware/protect",
             "-Ifirmware/config", "-Ifirmware/drive", "-Ifirmware/record", "-Itests/proof",
             "-include tests/proof/split.h"]
    source = ENTRIES[entry]
    cases = ",".join(f"{name}:{count}" for name, count in CASES[source].items())
    rows = folder / f"{entry}.csv"
    run = subprocess.run(
        ["frama-c", f"-cpp-extra-args={' '.join(paths)}", *OPTIONS, "-eva-slevel-function", cases,
         "-eva-split-return-function", SPLIT_RETURN[source], "-main", entry,
         source, "-then", "-metrics-eva-cover",
         "-then", "-report-no-proven", "-report-csv", rows],
        cwd=root, env={**os.environ, **COLLECTED_SELDOM, "PWD": str(root)},  # Frama-C believes PWD
        capture_output=True, text=True, check=False)
    (folder / f"{entry}.log").write_text(run.stdout + run.stderr, encoding="utf-8")
    listed = None
    if rows.is_file():
        with rows.open(encoding="utf-8", newline="") as file:
            listed = list(csv.DictReader(file, delimiter="\t"))
    return run.returncode, run.stdout, listed


def covered(output):
    """Function → (statements gone through, statements)."""
    return {name: (int(reached), int(all_)) for name, reached, all_ in COVERED.findall(output)}


def named(row, fields):
    """One property that is not proven, as a line."""
    place = f"{row['directory']}/{row['file']}:{row['line']} ({row['function']})"
    if row["file"] == "state.def":
        place += f": {fields[int(row['line']) - 1]}"
    return f"{place}: {row['property kind']}: {row['property']}"


def bounds(text):
    """[a..b] or {a; b} as the smallest and the largest number."""
    numbers = [int(number) for number in re.findall(r"-?\d+", text)]
    return min(numbers), max(numbers)


def ranges(root, outputs):
    """What is proven of each word of the state and of the output frame, over all entries."""
    lines = (root / "firmware/drive/state.def").read_text(encoding="utf-8").splitlines()
    proven = {}

    def note(name, text):
        low, high = bounds(text)
        before = proven.get(name, (low, high))
        proven[name] = (min(low, before[0]), max(high, before[1]))

    for output in outputs:
        for line, text in RANGE.findall(output):
            field = FIELD.match(lines[int(line) - 1])
            if field:
                note(field[1], text)
        for text in OUT.findall(output):
            values = re.findall(r"\[[^\]]*\]|\{[^}]*\}", text)
            for name, value in zip(("compare.phase[0]", "compare.phase[1]", "compare.phase[2]", "gate_enable"),
                                   values):
                note(f"out.{name}", value)
    return {name: {"min": low, "max": high} for name, (low, high) in proven.items()}


def unasked(root, entry, output, fields):
    """What an entry leaves out of the question itself: its own statements, its end, a range."""
    own = set(FUNCTION.findall((root / ENTRIES[entry]).read_text(encoding="utf-8")))
    reached = {name: counts for name, counts in covered(output).items() if name in own}
    for name in sorted({entry, CHECK} | set(reached)):
        share, whole = reached.get(name, (0, 0))
        if share < whole or whole == 0:
            yield f"{entry}: {name}: {share} of {whole or 'its'} statements of the proof: {UNASKED}"
    if ENTRIES[entry] == DRIVE:
        asked = {int(line) for line, _ in RANGE.findall(output)}
        for line, field in enumerate(fields, 1):
            if FIELD.match(field) and line not in asked:
                yield f"{entry}: firmware/drive/state.def:{line}: {field}: {UNASKED}"


def of_an_entry(root, entry, fields, code, output, rows):
    """What is not as it has to be in one run of Eva."""
    if code != 0 or "ANALYSIS SUMMARY" not in output:
        yield f"{entry}: frama-c ended with {code}: {output.strip().splitlines()[-1:]}"
    for name in ASSUMED.findall(output):
        yield f"{entry}: {name} has neither code nor a contract: what it does is invented"
    if rows is None:
        yield f"{entry}: frama-c has left no list of properties"
    for row in rows or []:
        yield f"{entry}: {named(row, fields)}"
    yield from unasked(root, entry, output, fields)


def findings(root, entries, folder):
    """All that is not as it has to be, what Eva said of each entry, and function → (statements reached, statements)."""
    bad, outputs, reached = [], [], {}
    fields = (root / "firmware/drive/state.def").read_text(encoding="utf-8").splitlines()
    for entry in entries:
        code, output, rows = analyse(root, entry, folder)
        outputs.append(output)
        bad += of_an_entry(root, entry, fields, code, output, rows)
        for name, (share, whole) in covered(output).items():
            reached[name] = max(reached.get(name, (0, whole)), (share, whole))
    there = functions(root)
    needed = there - NOT_CALLED - BACKGROUND
    bad += [f"tests/proof/proof.py: leaves out {name}, which there is not" for name in sorted((NOT_CALLED | BACKGROUND | A_BRANCH_AN_ENTRY) - there)]
    bad += [f"{UNREACHED}: {name}" for name in sorted(needed - set(reached))]
    bad += [f"{name}: {whole - share} of {whole} {UNREACHED_STATEMENTS}"
            for name, (share, whole) in sorted(reached.items())
            if share < whole and name in needed - A_BRANCH_AN_ENTRY]
    return bad, outputs, {name: reached.get(name, (0, 0)) for name in needed}


def text_of(some, whole):
    return f"{some} of {whole}"


def evidence(bad, entries, reached, proven):
    """Figures and tables of the page."""
    unreached = [line for line in bad if line.startswith(UNREACHED)]
    not_asked = [line for line in bad if line.endswith(UNASKED)]
    unproven = len([line for line in bad
                    if line not in unreached + not_asked and not line.endswith(UNREACHED_STATEMENTS)])
    gone_through = len(reached) - len(unreached)
    statements, of_all = (sum(column) for column in zip(*reached.values()))
    figures = [
        part.figure("alarms and other properties not proven", unproven, 0, unproven == 0),
        part.figure("ranges and statements of the proof not asked for, of all entries", len(not_asked), 0, not not_asked),
        part.figure("functions gone through", text_of(gone_through, len(reached)), "all", not unreached),
        part.figure("statements reached by an entry", text_of(statements, of_all),
                    f"all; in {', '.join(sorted(A_BRANCH_AN_ENTRY))} one branch an entry",
                    not [line for line in bad if line.endswith(UNREACHED_STATEMENTS)]),
        part.figure("entries analysed", text_of(len(entries), len(ENTRIES)), "all", len(entries) == len(ENTRIES)),
    ]
    tables = [
        part.table("Proven range of each signal and output, raw", ("Name", "Smallest", "Largest"),
                   [(name, limits["min"], limits["max"]) for name, limits in sorted(proven.items())]),
        part.table("Functions gone through", ("Function", "Statements reached"),
                   [(name, text_of(*reached[name])) for name in sorted(reached)]),
    ]
    return figures, tables


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, default=ROOT)
    parser.add_argument("--entry", action="append", help="only from this entry; may be repeated")
    parser.add_argument("--ranges", type=Path, help="write the proven range of each signal there, as JSON")
    args = part.arguments(parser)
    entries = args.entry or list(ENTRIES)
    if args.ranges:
        args.ranges.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        bad, outputs, reached = findings(args.root.resolve(), entries, Path(folder))
    proven = ranges(args.root, outputs)
    if args.ranges:
        args.ranges.parent.mkdir(parents=True, exist_ok=True)
        args.ranges.write_text(json.dumps(proven, indent=1) + "\n", encoding="utf-8")
    return part.end(args.out, "proof", "Proof", SAYS, *evidence(bad, entries, reached, proven), bad)


if __name__ == "__main__":
    sys.exit(main())
