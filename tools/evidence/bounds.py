# SPDX-License-Identifier: MIT
"""evidence.bounds: between which values each signal stays, how deep the stack gets, how long a tick is.

Seen are the smallest and the largest value of each intermediate of the drive and of its output, over every scenario with
every set of imperfections; they have to lie within what is proven. Stack and instructions are those that the test
target.cost has measured and computed; the thresholds are the linker's reservation and the budget.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import part

sys.path.append(str(part.ROOT / "tools"))

from bench.image import Image  # noqa: E402
from bench.replay import state_names  # noqa: E402
from bench.stack import EXCEPTION_BYTES, computed  # noqa: E402

BOARD = part.ROOT / "build/stm32g4/neurofoc_g4.elf"
BACKGROUND, EXCEPTIONS = "main", ("ADC1_2_IRQHandler", "SysTick_Handler", "NMI_Handler")  # of the board's image
BUDGET = part.ROOT / "tools/bench/budget.toml"
AT_ONCE = 2
LIMIT_BROKEN = 1  # exit status: what the run found counts all the same
STACK_SIZE = re.compile(r"_stack_size\s*=\s*(\d+)(K?)\s*;")


def names(kind):
    return sorted(path.stem for path in (part.ROOT / "host_sim" / kind).glob("*.toml"))


def motorsim(program, arguments):
    """The exit status, and what it says on its error output."""
    run = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    return run.returncode, run.stderr.strip()


def extremes(program, folder, scenario, imperfections):
    """The signals of one run, or why there are none."""
    path = folder / f"{scenario}.{imperfections}.json"
    status, said = motorsim(program, ["run", scenario, "--with", imperfections, "--json",
                                      f"{path}.result", "--extremes", path])
    if status not in (0, LIMIT_BROKEN):
        return scenario, imperfections, [], said
    return scenario, imperfections, json.loads(path.read_text(encoding="utf-8")), ""


def all_runs(program):
    pairs = [(scenario, imperfections) for scenario in names("scenarios") for imperfections in names("imperfections")]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(max_workers=AT_ONCE) as pool:
        return list(pool.map(lambda pair: extremes(program, Path(folder), *pair), pairs))


def si(signal, raw):
    return (raw - signal["zero"]) * signal["one"]


def gathered(runs):
    """Signal → its extremes: raw with the run that each is of, and SI; the bases differ from motor to motor."""
    found = {}
    for scenario, imperfections, signals, _ in runs:
        run = f"{scenario} {imperfections}"
        for signal in signals:
            low, high = (signal["min"], run), (signal["max"], run)
            ends = sorted((si(signal, signal["min"]), si(signal, signal["max"])))
            seen = found.setdefault(signal["name"], {"unit": signal["unit"], "low": low, "high": high, "si": ends})
            seen["low"] = min(seen["low"], low, key=lambda end: end[0])
            seen["high"] = max(seen["high"], high, key=lambda end: end[0])
            seen["si"] = [min(seen["si"][0], ends[0]), max(seen["si"][1], ends[1])]
    return found


def proven_name(name):
    return name.removeprefix("drive.")


def outside(found, proven):
    """A line for each signal that was seen outside what is proven, or of which nothing is."""
    lines = []
    for name, seen in found.items():
        bounds = proven.get(proven_name(name))
        if bounds is None:
            lines.append(f"firmware/drive/state.def:1: {name}: nothing is proven of it")
        elif seen["low"][0] < bounds["min"] or seen["high"][0] > bounds["max"]:
            run = seen["low" if seen["low"][0] < bounds["min"] else "high"][1]
            lines.append(f"firmware/drive/state.def:1: {name}: seen {seen['low'][0]} to {seen['high'][0]} ({run}), "
                         f"proven {bounds['min']} to {bounds['max']}")
    return lines


def signal_table(found, proven):
    rows = []
    for name, seen in found.items():
        bounds = proven.get(proven_name(name), {"min": "none", "max": "none"})
        rows.append([name, seen["low"][0], seen["high"][0], f"{seen['si'][0]:.4g} to {seen['si'][1]:.4g} {seen['unit']}",
                     bounds["min"], bounds["max"], f"{seen['low'][1]}\n{seen['high'][1]}"])
    return part.table("Signals over all runs",
                      ["signal", "seen, least", "most", "in SI units", "proven, least", "most", "least, most seen in"],
                      rows)


def reservation(binding):
    """Bytes of stack that the linker reserves."""
    script = part.ROOT / "hal" / binding / f"{binding}.ld"
    size, kilo = STACK_SIZE.search(script.read_text(encoding="utf-8")).groups()
    return int(size) * (1024 if kilo else 1)


def stack_rows(cost, reserved):
    """Rows, and the largest need."""
    rows, largest = [], 0
    for core, of_core in cost.items():
        for tuning, stack in of_core["stack"].items():
            largest = max(largest, EXCEPTION_BYTES + max(stack["computed"], stack["measured"]))
            rows.append([core, tuning, stack["measured"], stack["computed"], reserved,
                         f"{100 * stack['computed'] / reserved:.0f} %", " → ".join(stack["deepest"])])
    return rows, largest


def instruction_rows(cost, budget):
    """Rows, and a line for each state whose longest tick is over the budget."""
    rows, over = [], []
    for core, of_core in cost.items():
        for tuning, states in of_core["ticks"].items():
            for state, ticks in states.items():
                allowed = budget[core][tuning].get(f"{state.lower()}_max_instructions", [0, 0])[1]
                rows.append([core, tuning, state, ticks["max"], allowed])
                if ticks["max"] > allowed:
                    over.append(f"tools/bench/budget.toml:1: {core} {tuning} {state}: {ticks['max']} instructions, "
                                f"allowed {allowed}")
    return rows, over


def uncounted(cost):
    """Core and state of each that no tick ended in. INIT is left in the tick in which it is entered."""
    _, *others = state_names()
    return [f"{core} {state}" for core, of_core in cost.items() for state in others
            if not any(state in states for states in of_core["ticks"].values())]


def board_rows(image):
    """What each of the stack's users takes in the board's image with its deepest call, and the sum: one on the other."""
    rows, total = [], 0
    for entry in (BACKGROUND, *EXCEPTIONS):
        size, chain = computed(image, entry)
        size += EXCEPTION_BYTES if entry in EXCEPTIONS else 0
        total += size
        rows.append([entry, size, " → ".join(chain)])
    return rows, total


def figures_of(runs, lines, over, missing, stacks):
    """`stacks`: what for, bytes needed, bytes reserved."""
    refused = [run for run in runs if not run[2]]
    return [
        part.figure("runs: scenarios × sets of imperfections", f"{len(runs) - len(refused)} of {len(runs)}", "all",
                    not refused),
        part.figure("signals outside of what is proven", len(lines), 0, not lines),
        part.figure("states whose longest tick is over the budget", len(over), 0, not over),
        part.figure("states of which no tick was counted", ", ".join(missing) or "none", "none", not missing),
        *(part.figure(f"stack, {what}", f"{need} bytes", f"at most {reserved} bytes", 0 < need <= reserved)
          for what, need, reserved in stacks),
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motorsim", type=Path, default=part.ROOT / "build/host/motorsim")
    parser.add_argument("--proven", type=Path, required=True, help="as evidence.proof has written it")
    parser.add_argument("--cost", type=Path, required=True, help="as tools/bench_target.py --json has written it")
    parser.add_argument("--board", type=Path, default=BOARD, help="the board's image, its call graph beside it")
    args = part.arguments(parser)
    proven = json.loads(args.proven.read_text(encoding="utf-8"))
    cost = json.loads(args.cost.read_text(encoding="utf-8"))
    runs = all_runs(args.motorsim)
    found = gathered(runs)
    reserved = reservation("mps2")
    stacks, largest = stack_rows(cost, reserved)
    on_board, total = board_rows(Image(args.board))
    ticks, over = instruction_rows(cost, tomllib.loads(BUDGET.read_text(encoding="utf-8")))
    lines = outside(found, proven)
    refused = [f"host_sim/scenarios/{run[0]}.toml:1: with {run[1]}: {run[3]}" for run in runs if not run[2]]
    tables = [
        signal_table(found, proven),
        part.table("Longest tick by state, instructions of the control interrupt",
                   ["core", "tuning", "state", "longest", "budget"], ticks),
        part.table("Stack of the control interrupt, its own frame included, bytes",
                   ["core", "tuning", "measured", "computed", "reserved", "of it", "deepest call"], stacks),
        part.table("Stack in the board's image, with the frame of each exception, bytes",
                   ["function", "computed", "deepest call"], on_board),
    ]
    figures = figures_of(runs, lines, over, uncounted(cost), [
        ("the largest of a control interrupt", largest, reserved),
        ("background and both interrupts of the board, each at its deepest", total, reservation("stm32g4"))])
    return part.end(args.out, "bounds", "Bounds",
                    "Each signal's extremes over all scenarios and sets of imperfections lie within the interval that "
                    "the proof gives it. Stack is the deepest way down the call graph; instructions are counted in the "
                    "emulated cores.", figures, tables, refused + lines + over)


if __name__ == "__main__":
    sys.exit(main())
