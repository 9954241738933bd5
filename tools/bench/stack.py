# SPDX-License-Identifier: MIT
"""The stack that a function can need at most, by the compiler's call graph.

gcc's -fcallgraph-info=su lists, at the link, each function's frame and whom it calls. Functions of
the compiler's library are in it by name alone: their frames are read off their code, all they push
and take added up.
"""

import re

import capstone
from capstone import arm

from .blocks import Decoder
from .image import BenchError

# The exception's own frame: 8 registers, and up to 4 bytes to align it (no FPU context).
EXCEPTION_BYTES = 8 * 4 + 4
INDIRECT_CALL = "__indirect_call"
# Whom a function calls through a pointer, by its name. The control tick has no such call.
INDIRECT = {}

NODE = re.compile(r'node: \{ title: "(?:[^"]*:)?([^":]+)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "(?:[^"]*:)?([^":]+)" targetname: "(?:[^"]*:)?([^":]+)"')
BYTES = re.compile(r"(\d+) bytes \((\w+)\)")


def parse(text):
    """Frames by function, and the functions that each calls."""
    frames, calls = {}, {}
    for name, label in NODE.findall(text):
        size = BYTES.search(label)
        if size and size[2] != "static":
            raise BenchError(f"{name} has a frame of no fixed size ({size[0]})")
        if size:
            # Two partitions of the link, or an older file beside it: the larger frame holds.
            frames[name] = max(int(size[1]), frames.get(name, 0))
    for caller, callee in EDGE.findall(text):
        calls.setdefault(caller, set()).add(callee)
    return frames, calls


def resolve_pointers(calls, indirect):
    """The calls with those through a pointer replaced by what the table says."""
    resolved = {}
    for caller, callees in calls.items():
        if INDIRECT_CALL in callees and caller not in indirect:
            raise BenchError(f"{caller} calls through a pointer; name the functions in "
                             "INDIRECT of tools/bench/stack.py")
        resolved[caller] = (callees - {INDIRECT_CALL}) | set(indirect.get(caller, ()))
    return resolved


def library_frame(image, name):
    """(bytes, functions called) of a function without an entry in the call graph."""
    symbol = image.symbol(name)
    code = Decoder(image.content).disassemble(symbol.address, symbol.size)
    size, calls = 0, set()
    for one in code:
        size += taken(one)
        target = one.operands[0].imm if leaves(one) else symbol.address
        if not symbol.address <= target < symbol.address + symbol.size:
            calls.add(image.function_at(target).name)
    return size, calls


def leaves(one):
    """A branch or call whose target is in the instruction."""
    return (one.group(capstone.CS_GRP_JUMP) or one.group(capstone.CS_GRP_CALL)) and (
        one.operands[0].type == arm.ARM_OP_IMM)


def taken(one):
    """Bytes of stack that an instruction takes."""
    if one.id == arm.ARM_INS_PUSH:
        return 4 * len(one.operands)
    to_sp = one.operands and one.operands[0].type == arm.ARM_OP_REG and (
        one.operands[0].reg == arm.ARM_REG_SP)
    if one.id == arm.ARM_INS_SUB and to_sp:
        return one.operands[-1].imm
    if one.id in (arm.ARM_INS_STMDB, arm.ARM_INS_STR) and one.writeback and "sp" in one.op_str:
        return 4 * max(1, len(one.operands) - 1)
    return 0


def deepest(name, frames, calls, library, above=()):
    """(bytes, chain of functions) of the deepest way down from a function."""
    if name in above:
        raise BenchError(f"{name} calls itself")
    size, callees = (frames[name], calls.get(name, ())) if name in frames else library(name)
    ways = [deepest(callee, frames, calls, library, (*above, name)) for callee in sorted(callees)]
    below, chain = max(ways, default=(0, ()))
    return size + below, (name, *chain)


def linked(frames, calls, has):
    """The calls less those of functions that are not in the image: gcc also notes the call of a division that it has weighed
    and then done in another way. `has`: whether the image has a name."""
    return {caller: {callee for callee in callees if callee in frames or has(callee)} for caller, callees in calls.items()}


def by_one_name(calls, frames, names_of):
    """The calls with each function by the name that has its frame: functions of the same code are one after the link, and
    the call graph lists that one alone. `names_of`: all names at the address of a name."""
    def known(callee):
        return callee if callee in frames else next((name for name in names_of(callee) if name in frames), callee)
    return {caller: {known(callee) for callee in callees} for caller, callees in calls.items()}


def graph(image):
    """Frames and calls of all functions of the image but those of the compiler's library."""
    files = sorted(image.path.parent.glob(f"{image.path.name}.ltrans*.ci"))
    if not files:
        raise BenchError(f"{image.path}: no call graph beside it, {image.path.name}.ltrans*.ci; "
                         "build the image anew")
    frames, calls = parse("".join(file.read_text(encoding="utf-8") for file in files))
    calls = linked(frames, resolve_pointers(calls, INDIRECT), image.has)
    return frames, by_one_name(calls, frames, image.names_at)


def computed(image, entry):
    """(bytes, chain) of the deepest way down from `entry`, its own frame included."""
    frames, calls = graph(image)
    return deepest(entry, frames, calls, lambda name: library_frame(image, name))


def of_library(image, entry):
    """Names of the functions of the compiler's library that can be called, by whatever way, from `entry`."""
    frames, calls = graph(image)
    found, left = set(), [entry]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += calls.get(name, ()) if name in frames else library_frame(image, name)[1]
    return found - set(frames)
