# SPDX-License-Identifier: MIT
"""Basic blocks of Thumb code: how many instructions, of which classes."""

from dataclasses import dataclass

import capstone
from capstone import arm

from .image import BenchError

LOADS = {arm.ARM_INS_LDR, arm.ARM_INS_LDRB, arm.ARM_INS_LDRH, arm.ARM_INS_LDRSB,
         arm.ARM_INS_LDRSH}
STORES = {arm.ARM_INS_STR, arm.ARM_INS_STRB, arm.ARM_INS_STRH}
LISTS = {arm.ARM_INS_LDM, arm.ARM_INS_LDMDB, arm.ARM_INS_STM, arm.ARM_INS_STMDB,
         arm.ARM_INS_PUSH, arm.ARM_INS_POP}
CLASSES = {
    "multiply": {arm.ARM_INS_MUL},
    "multiply-add": {arm.ARM_INS_MLA, arm.ARM_INS_MLS},
    "long multiply": {arm.ARM_INS_SMULL, arm.ARM_INS_UMULL},
    "long multiply-add": {arm.ARM_INS_SMLAL, arm.ARM_INS_UMLAL},
    "divide": {arm.ARM_INS_SDIV, arm.ARM_INS_UDIV},
    "load": LOADS,
    "store": STORES,
    "pair": {arm.ARM_INS_LDRD, arm.ARM_INS_STRD},
    "branch": {arm.ARM_INS_B, arm.ARM_INS_BX, arm.ARM_INS_BLX, arm.ARM_INS_CBZ,
               arm.ARM_INS_CBNZ},
    "call": {arm.ARM_INS_BL},
    "table branch": {arm.ARM_INS_TBB, arm.ARM_INS_TBH},
    "if-then": {arm.ARM_INS_IT},
    "system": {arm.ARM_INS_MRS, arm.ARM_INS_MSR, arm.ARM_INS_CPS, arm.ARM_INS_DMB,
               arm.ARM_INS_DSB, arm.ARM_INS_ISB},
}
CLASS_OF = {number: name for name, numbers in CLASSES.items() for number in numbers}


@dataclass(frozen=True)
class Instruction:
    address: int
    kind: str       # a class of cycles.py
    registers: int  # of a list, else 0


@dataclass(frozen=True)
class Block:
    start: int
    instructions: tuple
    end: int


def kind_of(instruction):
    """Class and length of the register list."""
    if instruction.id in LISTS:
        base = 0 if instruction.id in (arm.ARM_INS_PUSH, arm.ARM_INS_POP) else 1
        registers = len(instruction.operands) - base
        to_pc = any(operand.type == arm.ARM_OP_REG and operand.reg == arm.ARM_REG_PC
                    for operand in instruction.operands)
        return ("return" if to_pc else "list"), registers
    return CLASS_OF.get(instruction.id, "data"), 0


class Decoder:
    """Blocks of a program's bytes, which begin at address 0; each is disassembled once."""

    def __init__(self, content):
        self._content = content
        self._engine = capstone.Cs(capstone.CS_ARCH_ARM,
                                   capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
        self._engine.detail = True
        self._blocks = {}

    def disassemble(self, address, size):
        return self._engine.disasm(self._content[address:address + size], address)

    def block(self, address, size):
        if address not in self._blocks:
            found = tuple(Instruction(one.address, *kind_of(one))
                          for one in self.disassemble(address, size))
            block = Block(address, found, address + size)
            self._check(address, size)
            self._blocks[address] = block
        return self._blocks[address]

    def _check(self, address, size):
        decoded = sum(one.size for one in self.disassemble(address, size))
        if decoded != size:
            raise BenchError(f"the code at {address:#x} cannot be disassembled: "
                             f"{decoded} of {size} bytes")
