# SPDX-License-Identifier: MIT
"""Cycles of a core from the classes of its instructions: a model, whose assumptions are below.

From Arm's technical reference manuals, "Instruction set summary", all for zero wait states: Cortex-M0+
DDI 0484C table 3-1, Cortex-M3 DDI 0337I table 3-1, Cortex-M4 100166 table 3-1. Where a manual gives a
range (a refill of the pipeline takes 1 to 3 cycles, two loads in a row overlap), so does the model. The
M0+ comes with either of two multipliers, of 1 and of 32 cycles ("slow MULS").
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Cost:
    """Cycles of a class: at best, at worst, and for each register of a list."""

    low: int
    high: int
    each: int = 0


@dataclass(frozen=True)
class Model:
    core: str
    title: str
    costs: dict
    refill: Cost  # more, where the next instruction is not the one behind


ONE, TWO = Cost(1, 1), Cost(2, 2)
NO = Cost(0, 0)  # the core has no such instruction
LIST = Cost(1, 1, 1)

M0PLUS = {
    "data": ONE, "multiply": ONE, "multiply-add": NO, "long multiply": NO,
    "long multiply-add": NO, "divide": NO, "load": TWO, "store": TWO, "pair": NO, "list": LIST,
    "return": Cost(2, 2, 1), "branch": ONE, "call": TWO, "table branch": NO, "if-then": NO,
    "system": Cost(1, 3),
}
M0PLUS_SMALL = M0PLUS | {"multiply": Cost(32, 32)}
M4 = {
    "data": ONE, "multiply": ONE, "multiply-add": ONE, "long multiply": ONE,
    "long multiply-add": ONE, "divide": Cost(2, 12), "load": Cost(1, 2), "store": Cost(1, 2),
    "pair": Cost(3, 3), "list": LIST, "return": LIST, "branch": ONE, "call": ONE,
    "table branch": TWO, "if-then": Cost(0, 1), "system": Cost(1, 2),
}
M3 = M4 | {"multiply-add": TWO, "long multiply": Cost(3, 5), "long multiply-add": Cost(4, 7)}

MODELS = (
    Model("cortex-m0plus", "M0+", M0PLUS, ONE),
    Model("cortex-m0plus", "M0+ slow MULS", M0PLUS_SMALL, ONE),
    Model("cortex-m3", "M3", M3, Cost(1, 3)),
    Model("cortex-m4", "M4", M4, Cost(1, 3)),
)
MEANING = {
    "data": "arithmetic, logic, moves, shifts, saturation",
    "multiply": "32 × 32 → 32",
    "multiply-add": "MLA, MLS",
    "long multiply": "UMULL, SMULL",
    "long multiply-add": "UMLAL, SMLAL",
    "divide": "UDIV, SDIV: by the values",
    "load": "one register; 1 behind another load",
    "store": "one register; 1 if the write buffer is free",
    "pair": "LDRD, STRD",
    "list": "PUSH, POP, LDM, STM, of n registers",
    "return": "POP or LDM with PC",
    "branch": "B, Bcc, BX, BLX, CBZ",
    "call": "BL",
    "table branch": "TBB, TBH",
    "if-then": "IT: 0 if folded into the instruction before",
    "system": "MRS, MSR, CPS, barriers",
}
NOTES = (
    "Zero wait states: a flash that is slower adds its own, unless it has a cache or a prefetch.",
    "The exception's entry (15 cycles on M0+, 12 on M3 and M4) and its return come on top.",
    "What an IT block skips counts as if executed.",
)


def block_cycles(model, block):
    """(low, high) of a block without what follows from where it goes on."""
    costs = [(model.costs[one.kind], one.registers) for one in block.instructions]
    return (sum(cost.low + cost.each * n for cost, n in costs),
            sum(cost.high + cost.each * n for cost, n in costs))


class Clock:
    """The cycles of a core; each block is summed up once."""

    def __init__(self, model):
        self._model = model
        self._blocks = {}

    def cycles(self, blocks, back):
        """(low, high) of a way through blocks that returns to the address `back`."""
        low = high = jumps = 0
        following = [block.start for block in blocks[1:]] + [back]
        for block, then in zip(blocks, following):
            if block.start not in self._blocks:
                self._blocks[block.start] = block_cycles(self._model, block)
            jumps += then != block.end
            low += self._blocks[block.start][0]
            high += self._blocks[block.start][1]
        return low + jumps * self._model.refill.low, high + jumps * self._model.refill.high


def as_text(cost):
    """1, 2–12, or 1 + n."""
    span = f"{cost.low}" if cost.low == cost.high else f"{cost.low}–{cost.high}"
    return "–" if cost == NO else span + (" + n" if cost.each else "")
