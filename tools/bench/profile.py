# SPDX-License-Identifier: MIT
"""Where the instructions go: of each source function or line, with what was inlined told apart."""

from collections import Counter
from dataclasses import dataclass

# Arithmetic that is one or two instructions wherever it is used: it counts to its user, because a
# sum over all its uses says nothing about where to look.
HELPERS = ("/fx.h", "/fx_shift.h", "/fx_port.h", "/fx_armv7.h")
FOLDERS = ("/firmware/", "/hal/")
LIBRARY = "(compiler's library)"


@dataclass(frozen=True)
class Share:
    function: str
    file: str
    mean: float   # instructions a tick
    worst: int    # in the most expensive tick


def owner(chain):
    """The innermost source position that is no helper; None for code that is not the project's."""
    known = [frame for frame in chain if short(frame.file)]
    for frame in known:
        if not frame.file.endswith(HELPERS):
            return frame
    return known[-1] if known else None


def key_of(image, address, chain, by_line):
    frame = owner(chain)
    if frame is None:
        symbol = image.function_at(address)
        return (symbol.name if symbol else hex(address)), LIBRARY
    line = f":{frame.line}" if by_line else ""
    return frame.function, short(frame.file) + line


def short(path):
    """A source file from the project's folder on; empty if it is not the project's."""
    for folder in FOLDERS:
        if folder in path:
            return folder[1:] + path.rpartition(folder)[2]
    return ""


def executed(bench, way):
    """Executions by the address of each instruction on a way."""
    return Counter(one.address for block in bench.blocks(way) for one in block.instructions)


def profile(bench, state, by_line=False, by_worst=False):
    """Shares of the ticks in a state, the largest first: of the mean, or of the longest tick."""
    ways = bench.ways(state)
    ticks = sum(ways.values())
    counts = {way: executed(bench, way) for way in ways}
    longest = max(counts.values(), key=Counter.total)
    chains = bench.image.frames(sorted(set().union(*counts.values())))
    mean, worst = Counter(), Counter()
    for at, chain in chains.items():
        key = key_of(bench.image, at, chain, by_line)
        mean[key] += sum(counts[way][at] * n for way, n in ways.items()) / ticks
        worst[key] += longest[at]
    shares = [Share(*key, mean[key], worst[key]) for key in mean]
    return sorted(shares, key=lambda share: share.worst if by_worst else share.mean, reverse=True)
