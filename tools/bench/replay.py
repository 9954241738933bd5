# SPDX-License-Identifier: MIT
"""Recordings replayed by an image in the emulator: which ways its control ticks took, how often."""

import re
import struct
import subprocess
import tempfile
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from . import machine
from .blocks import Decoder
from .image import BenchError, Image

ROOT = Path(__file__).resolve().parents[2]
ENTRY = "control_interrupt"  # of hal/mps2/main.c: nothing but a call of control_isr()
CALLER = "main"
HEADER = struct.Struct("<IHHII")  # hal/mps2/recording.h
RESULT = struct.Struct("<HHHBBI")
STATE = 4  # of a result

# The recordings of a tuning, and what `record` takes for each. The robust ones see every state.
FAULT = "scenario.fault=[{time_s=1.6, what='break_input'}]"
RECORDINGS = {
    "published": {name: (name, "ideal") for name in ("s1", "s2", "s3")},
    "robust": {
        "s1_robust": ("s1_robust", "all"),
        "s2_robust": ("s2_robust", "all"),
        "s3_robust": ("s3_robust", "all", FAULT),
        "identify": ("s1_robust", "all", "identify"),
    },
    "voltage_phase": {"s5": ("s5", "adc")},
}


@dataclass(frozen=True)
class Replay:
    """What an image did with one recording."""

    scenario: str
    ways: Counter  # (state after the tick, tuple of blocks and the return address): ticks
    sizes: dict    # bytes by block address
    stack_bytes: int


@dataclass(frozen=True)
class Bench:
    """One image and all its replays."""

    core: str
    tuning: str
    image: Image
    decoder: Decoder
    replays: tuple

    def blocks(self, way):
        """The blocks of a way; its last address is where it returns to."""
        return [self.decoder.block(at, self.sizes[at]) for at in way[:-1]]

    @cached_property
    def sizes(self):
        return {at: size for replay in self.replays for at, size in replay.sizes.items()}

    def ways(self, state):
        """Ticks by way in a state, over all replays."""
        return sum((Counter({way: n for (of, way), n in replay.ways.items() if of == state})
                    for replay in self.replays), Counter())

    @property
    def states(self):
        return [name for name in state_names()
                if any(of == name for replay in self.replays for of, _ in replay.ways)]


def state_names():
    """The drive's states in their order."""
    return list(state_codes().values())


def state_codes():
    """The name of each state by its code."""
    header = (ROOT / "firmware/drive/state.h").read_text(encoding="utf-8")
    listed = re.search(r"typedef enum \{([^}]*)\} drive_state_t;", header)[1]
    return {int(code, 16): name for name, code in re.findall(r"DRIVE_STATE_(\w+) = (0x\w+)", listed)}


def record(build, folder, scenario, *choices):
    """A recording of the simulator, made now: an older one could be of another core."""
    program = build / "host/record"
    if not program.is_file():
        raise BenchError(f"{program}: no such program; build it with `tools/dev build`")
    run = subprocess.run([program.resolve(), folder, scenario, *choices],
                         capture_output=True, text=True)
    if run.returncode:
        raise BenchError(run.stderr.strip())


def read_recording(folder):
    return {name: (Path(folder) / name).read_bytes() for name in ("frames.nfr", "results.nfr")}


def states_of(results):
    names = state_codes()
    return [names[record[STATE]] for record in RESULT.iter_unpack(results[HEADER.size:])]


def replay(core, image, scenario, recording, on_read):
    """Runs the recording; a tick that differs from the PC's is an error, as its cost means nothing."""
    trails, host = machine.run(core, image.content, image.symbol(ENTRY).address, image.symbol(CALLER).addresses,
                               {"frames.nfr": recording["frames.nfr"]}, on_read)
    if host.exit_code != 0:
        raise BenchError(f"{image.path}, {scenario}: {host.text.strip() or host.exit_code}")
    results = bytes(host.files["results.nfr"])
    if results != recording["results.nfr"]:
        raise BenchError(f"{image.path}, {scenario}: other results than on the PC; "
                         "build image and host from one state of the sources")
    way_of = {number: way for way, number in trails.trails.items()}
    ways = Counter(zip(states_of(results), map(way_of.get, trails.calls)))
    return Replay(scenario, ways, trails.sizes, trails.stack_bytes)


def measure(build, cores, tunings, progress):
    """A Bench for each core and tuning."""
    with tempfile.TemporaryDirectory() as work:
        recordings = {}
        for tuning in tunings:
            for name, (scenario, *choices) in RECORDINGS[tuning].items():
                folder = Path(work) / name
                record(build, folder, scenario, *choices)
                recordings.setdefault(tuning, {})[name] = read_recording(folder)
    return [bench(build, core, tuning, recordings[tuning], progress)
            for core in cores for tuning in tunings]


def bench(build, core, tuning, recordings, progress):
    image = Image(build / core / f"replay_{tuning}.elf")
    decoder = Decoder(image.content)
    replays = []
    for scenario, recording in recordings.items():
        with progress(f"{core} {scenario}", len(recording["frames.nfr"])) as advance:
            replays.append(replay(core, image, scenario, recording, advance))
    return Bench(core, tuning, image, decoder, tuple(replays))
