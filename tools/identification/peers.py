# SPDX-License-Identifier: MIT
"""The motors on which another project tests its identification, measured by this drive."""

import argparse
import json
import os
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import user_text

from . import motor, table

ROOT = Path(__file__).resolve().parents[2]
FILES = Path(__file__).with_name("peers")
DONE, REFUSED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
KEYS = ("resistance_ohm", "inductance_d_h", "inductance_q_h", "flux_linkage_wb", "inertia_kg_m2")
TITLES = {"inductance_q_h": "L_q"}     # of table.VALUES, without the condition that stands below this table
MOST_SEEDS = 99
SETS = {"bench": "as there", "user": "as users have it"}

HELP = """Identifies the four motors on which phobia (github.com/rombrew/phobia) tests its own identification, and says how far the
results are off, beside what phobia is off. Each is measured twice: with noise, dead time and friction as in its test bench,
and with what the zoo's motors of users have: the dead time off by half, soft commutation, mismatch of the sensors, bus ripple,
cogging, harmonics, saturated iron.

  tools/measure_peers                    all four, two minutes
  tools/measure_peers rotomax_120 --seeds 1

A cell is the largest error of the seeds of the noise, with the median bar. Motors, board and both sets are in
tools/identification/peers/. The motor files, the console's lines and the results stay in the folder.
"""


@dataclass(frozen=True)
class Peer:
    name: str           # of its file
    title: str
    theirs_pct: tuple   # |error| of phobia, of each of KEYS
    supply: str = ""    # set of a bus voltage other than the board's


# Phobia's are those of its own test bench, commit c83f624, the largest of the seeds 1 to 5. The truth is that of the winding's
# temperature behind each measurement: R and flux linkage of the hub motor change by 4 % and 2 % while it is measured. The drag
# with the square of the speed, Mq[2], is 0 as in this simulator: with it J of the XNOVA is off by 18 %.
PEERS = (
    Peer("xnova_4530", "XNOVA Lightning 4530", (0.67, 1.9, 5.6, 2.4, 4.3)),
    Peer("rotomax_120", "Turnigy RotoMax 1.20", (0.36, 2.1, 2.7, 1.0, 3.4), supply="bus_22v"),
    Peer("hub_250w", "hub motor, 250 W", (0.86, 0.36, 0.29, 0.45, 0.65)),
    Peer("qs_138", "QS 138, 3000 W", (0.26, 0.62, 1.1, 0.55, 0.59)),
)


def seeds(text):
    if not text.isdigit() or not 1 <= int(text) <= MOST_SEEDS:
        raise argparse.ArgumentTypeError(f"{text}: expected a whole number from 1 to {MOST_SEEDS}")
    return int(text)


def parser():
    found = user_text.Parser(prog="measure_peers", description=HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("motors", nargs="*", metavar="MOTOR", help=f"{', '.join(peer.name for peer in PEERS)}; default all")
    found.add_argument("--seeds", type=seeds, default=5, help="so many of the noise, from 1 on; default 5")
    found.add_argument("--motorsim", type=Path, default=ROOT / "build/host/motorsim", help="the program")
    found.add_argument("--out", type=Path, default=ROOT / "build/identified/peers", help="folder of the results")
    return found


def chosen(names):
    """The peers of these names, all without a name. ValueError says which name is none."""
    for name in names:
        if name not in {peer.name for peer in PEERS}:
            raise ValueError(f"{name}: no such motor; expected {', '.join(peer.name for peer in PEERS)}")
    return [peer for peer in PEERS if not names or peer.name in names]


def command(motorsim, peer, with_set, seed, stem):
    sets = [with_set, *([peer.supply] if peer.supply else [])]
    return [str(motorsim), "identify", "any", "--motor", str(FILES / f"{peer.name}.toml"), "--board", str(FILES / "board.toml"),
            *(word for name in sets for word in ("--with", str(FILES / f"{name}.toml"))), "--set", f"scenario.seed={seed}",
            "--json", "-", "-o", f"{stem}.toml", "--overwrite", "--log", f"{stem}.log"]


def measured(motorsim, peer, with_set, seed, folder):
    """What `motorsim identify --json` says of it, with `refusal`."""
    stem = folder / f"{peer.name}_{with_set}_{seed}"
    done = subprocess.run(command(motorsim, peer, with_set, seed, stem), capture_output=True, text=True, check=False,
                          timeout=motor.LONGEST_S)
    lines = done.stderr.strip().splitlines() or [""]
    found = {"motor": peer.name, "set": with_set, "seed": seed, "refusal": None if done.returncode == 0 else lines[-1]}
    if done.returncode == 0:
        found |= json.loads(done.stdout)
    stem.with_suffix(".json").write_text(json.dumps(found), encoding="utf-8")
    return found


def compared():
    return [value for value in table.VALUES if value.key in KEYS]


def cell(value, results):
    """Largest error and median bar of one motor."""
    found = table.errors(value, results)
    return f"{max(error for error, _ in found):.2g} (± {statistics.median(bar for _, bar in found):.2g}) %"


def row(head, results):
    if any(result["refusal"] is not None for result in results):
        return f"| {head} |" + " refused |" * len(KEYS)
    return f"| {head} |" + "".join(f" {cell(value, results)} |" for value in compared())


def lines(peers, results):
    """Of each motor the errors with each set, and below them those of the other project."""
    heads = "".join(f" {TITLES.get(value.key, value.title)} |" for value in compared())
    text = [f"| |{heads}", "| --- |" + " --- |" * len(KEYS)]
    for peer in peers:
        for name, title in SETS.items():
            of_set = [result for result in results if (result["motor"], result["set"]) == (peer.name, name)]
            text.append(row(f"{peer.title}, {title}", of_set))
        text.append(f"| {peer.title}, phobia |" + "".join(f" {error:g} % |" for error in peer.theirs_pct))
    return text


def refusals(results):
    return [f"{each['motor']}, {SETS[each['set']]}, seed {each['seed']}: {each['refusal']}"
            for each in results if each["refusal"] is not None]


def all_of(args, peers):
    runs = [(peer, name, seed) for peer in peers for name in SETS for seed in range(1, args.seeds + 1)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda run: measured(args.motorsim.resolve(), *run, args.out), runs))


def main(words=None):
    args = parser().parse_args(words)
    try:
        peers = chosen(args.motors)
    except ValueError as problem:
        print(f"measure_peers: {problem}", file=sys.stderr)
        return BAD_INPUT
    if not os.access(args.motorsim, os.X_OK):
        print(f"measure_peers: {args.motorsim}: no program; run tools/dev build", file=sys.stderr)
        return BAD_INPUT
    args.out.mkdir(parents=True, exist_ok=True)
    try:
        results = all_of(args, peers)
    except KeyboardInterrupt:
        return INTERRUPTED
    refused = refusals(results)
    print("\n".join([*lines(peers, results), *([""] if refused else []), *refused]))
    return REFUSED if refused else DONE
