# SPDX-License-Identifier: MIT
"""What a figure needs to know of the samples: steps, peaks, wraps and windows to zoom into."""

import math
from dataclasses import dataclass

import numpy as np

from report.runs import TIME

STEP_SHARE = 0.05    # a jump between two samples is a step from this share of the signal's peak
ZOOM_TURNS = 3       # electrical turns in a zoomed window
ZOOM_LONGEST_S = 0.1


@dataclass(frozen=True)
class Event:
    """A step of a command or of the load."""

    time: float
    text: str


@dataclass(frozen=True)
class Window:
    start: float
    end: float
    text: str


def envelope(time, values, buckets):
    """At most 2·buckets + 4 samples: each bucket keeps its lowest and highest; no peak is lost."""
    size = math.ceil(len(values) / buckets)
    if size <= 2:
        return time, values
    full = len(values) // size * size
    blocks = values[:full].reshape(-1, size)
    starts = np.arange(0, full, size)
    ends = [0, len(values) - 1]
    tail = values[full:]
    if len(tail):
        ends += [full + tail.argmin(), full + tail.argmax()]
    keep = np.unique(np.concatenate(
        [starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1), ends]))
    return time[keep], values[keep]


def pieces(time, degrees):
    """An angle as unbroken pieces within ±180°; each ends where the next would wrap.

    A rotor at rest is at 0 in most runs: there it does not flicker between the two ends.
    """
    wrapped = np.mod(degrees + 180.0, 360.0) - 180.0
    cuts = np.flatnonzero(np.abs(np.diff(wrapped)) > 180.0) + 1
    return list(zip(np.split(time, cuts), np.split(wrapped, cuts)))


def radians_text(value):
    turns = value / math.pi
    if abs(turns - round(turns)) < 1e-3 and round(turns):
        factor = "" if abs(round(turns)) == 1 else str(abs(round(turns)))
        return f"{'−' if turns < 0 else ''}{factor}π rad"
    return f"{value:.3g} rad".replace("-", "−")


def number_text(unit):
    return lambda value: f"{value:.4g} {unit}".replace("-", "−")


def load_text(value):
    return f"load {value:.3g} N·m".replace("-", "−") if value else "no load"


# The signals whose steps are marked, and how a marker is worded.
STEPPED = {
    "speed_command_rpm": number_text("rpm"),
    "position_command_rad": radians_text,
    "load_torque_nm": load_text,
}


def end(time):
    """The end of the last sample, which holds for as long as the one before."""
    return 2 * time[-1] - time[-2]


def steps(time, values, text):
    jumps = np.abs(np.diff(values))
    found = jumps > STEP_SHARE * max(np.abs(values).max(), 1e-9)
    first = found & ~np.concatenate([[False], found[:-1]])
    return [Event(time[k + 1], text(values[k + 1])) for k in np.flatnonzero(first)]


def events(trace):
    """The steps of the position command, or else of the speed command, and of the load."""
    marked = []
    for name, text in STEPPED.items():
        if trace.has([name]):
            marked.append(steps(trace[TIME], trace[name], text))
        else:
            marked.append([])
    speed, position, load = marked
    return sorted((position or speed) + load, key=lambda event: event.time)


def zoom_windows(trace, marked):
    """Some electrical turns at each of the first two steps, and at the end of the trace."""
    time = trace[TIME]
    angle = np.unwrap(trace["angle_el_deg"], period=360.0)
    windows = []
    for event in marked[:2]:
        start = max(event.time - 0.1 * ZOOM_LONGEST_S, time[0])
        windows.append(Window(start, min(turned(time, angle, event.time), end(time)), event.text))
    before = turned(-time[::-1], angle[::-1], -time[-1])
    windows.append(Window(max(-before, time[0]), end(time), "end"))
    return windows


def turned(time, angle, start):
    """When the rotor has made ZOOM_TURNS after `start`, or ZOOM_LONGEST_S later."""
    first = min(np.searchsorted(time, start), len(time) - 1)
    moved = np.abs(angle[first:] - angle[first]) >= 360.0 * ZOOM_TURNS
    later = time[first + moved.argmax()] if moved.any() else math.inf
    return min(later, start + ZOOM_LONGEST_S)
