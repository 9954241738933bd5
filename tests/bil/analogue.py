# SPDX-License-Identifier: MIT
"""Models of the STM32G431's analogue side: amplifiers, converters, comparators and their level.

Facts from the reference manual RM0440 and the data sheet. Voltages are in counts of the converters,
4096 for the reference.
"""

import random

from core import NEVER
from digital import Awaited, bit, cycles, need
from registers import Block, Register, WrongAccess

SHUNT_PINS = {1: "PA1", 2: "PA7", 3: "PB0"}       # of the amplifiers' plus inputs
COMPARATORS = {1: ("PA1", 1), 2: ("PA7", 2), 4: ("PB0", 2)}  # plus input, DAC3 channel at the minus
HALF_CYCLES = (5, 13, 25, 49, 95, 185, 495, 1281)  # of sampling, by the code in SMPR
CONVERSION_HALF_CYCLES = 25
HALF_CYCLE = 2                                     # at a quarter of 170 MHz
CALIBRATION_CYCLES = 116 * 4                       # data sheet DS12589 rev. 6, table 60
FLOATING = 4095                                    # what a pin that nobody drives may convert to
READY_CYCLES = (5 + 25) * HALF_CYCLE               # the same table: a conversion at least; no longest one is given

# Data sheet DS12589 rev. 6, the longest each.
REGULATOR_START = cycles(20e-6)  # table 60
AMPLIFIER_START = cycles(6e-6)   # table 74, high-speed mode
LEVEL_START = cycles(3.5e-6)     # table 70: DAC3 is one of 15 MSPS
COMPARATOR_START = cycles(5e-6)  # table 73

# The same: the least, the ideal one, the most.
COUNTS_PER_MV = 4096 / 3300
COMPARATOR_OFFSET_MV = (-9, 0, 3)  # table 73
AMPLIFIER_OFFSET_MV = (-3, 0, 3)   # table 74
AMPLIFIER_GAIN = (0.98, 1, 1.02)   # table 74: 1 % for gains up to 16; the other one is assumed for resistors around
BIAS = (0.98, 1, 1.02)             # of a pin without current: a divider of resistors of 1 %


class Parts:
    """What the comparators and amplifiers of one chip of many do, and the resistors before them. `choose` takes a value
    out of a tolerance: ideal, least, most or drawn()."""

    def __init__(self, choose):
        def of(tolerance, scale=1):
            return {number: choose(tolerance) * scale for number in (1, 2, 3, 4)}

        self.comparator = of(COMPARATOR_OFFSET_MV, COUNTS_PER_MV)  # most: it trips early
        self.amplifier = of(AMPLIFIER_OFFSET_MV, COUNTS_PER_MV)
        self.gain = of(AMPLIFIER_GAIN)
        self.bias = of(BIAS)


def least(tolerance):
    return tolerance[0]


def ideal(tolerance):
    return tolerance[1]


def most(tolerance):
    return tolerance[2]


def drawn(seed):
    source = random.Random(seed)
    return lambda tolerance: source.uniform(tolerance[0], tolerance[2])


class Amplifiers(Block):
    """Three programmable amplifiers."""

    def __init__(self, chip, parts, clocked):
        self.chip = chip
        self.parts = parts
        self.ready = dict.fromkeys(SHUNT_PINS, NEVER)
        super().__init__("OPAMP", 0x40010300, {
            f"{number}_CSR": (4 * (number - 1), Register(0, 0x0007C1ED, on_write=self._write(number)))
            for number in SHUNT_PINS
        }, clocked)

    def _write(self, number):
        def write(value):
            if bit(value, 0) and not bit(self[f"{number}_CSR"], 0):
                self.ready[number] = self.chip.now + AMPLIFIER_START
            self[f"{number}_CSR"] = value
        return write

    def output(self, number, inside):
        """At the output pin, or inside of the chip."""
        value = self[f"{number}_CSR"]
        need(bool(bit(value, 8)) == inside, f"amplifier {number} drives another output")
        if self.chip.now < self.ready[number]:
            return 0
        return (self.chip.pins[SHUNT_PINS[number]] + self.parts.amplifier[number]) * self._gain(number, value)

    def _gain(self, number, value):
        if value & 0x6D == 0x61:  # its output is its minus input
            return 1
        need(value & 0x6D == 0x41, f"amplifier {number} does not amplify its pin")
        need(value >> 17 & 3 == 1, f"amplifier {number} does not refer to its minus pin")
        return (2 << (value >> 14 & 7)) * self.parts.gain[number]


class Converter(Block):
    """One of the two converters. `inputs` gives the voltage of a channel."""

    def __init__(self, chip, name, base, inputs, clocked):
        self.chip = chip
        self.inputs = inputs
        self.due = NEVER       # end of the injected sequence
        self.regulated = NEVER
        self.calibrated = NEVER
        self.converted = 0     # end of the regular conversion
        self.converting = False  # regular, not yet told by its flag
        self.ready = Awaited(chip, READY_CYCLES)
        self.fresh = False     # enabled, and nothing was converted since
        self.results = []
        super().__init__(name, base, {
            "ISR": (0x00, Register(0, 0x7FF, self._flags, self._acknowledge)),
            "IER": (0x04, Register(0, 0x40)),
            "CR": (0x08, Register(0x20000000, 0x9000000D, self._control_read, self._control)),
            "CFGR": (0x0C, Register(0x80000000, 0x1000, on_write=self._stopped("CFGR"))),
            "SMPR1": (0x14, Register(0, 0x3FFFFFFF, on_write=self._stopped("SMPR1"))),
            "SMPR2": (0x18, Register(0, 0x07FFFFFF, on_write=self._stopped("SMPR2"))),
            "SQR1": (0x30, Register(0, 0x7CF)),
            "DR": (0x40, Register(0, 0, self._read_regular)),
            "JSQR": (0x4C, Register(0, 0x007FFFFF, on_write=self._stopped("JSQR"))),
            "JDR1": (0x80, Register(0, 0)),
            "JDR2": (0x84, Register(0, 0)),
        }, clocked)

    def trigger(self):
        """TIM1's TRGO2 has risen: both inputs of the sequence are taken, the first one now."""
        sequence = self["JSQR"]
        if not bit(self["CR"], 3):
            return
        need(sequence & 0x1FF == 0xA1, f"{self.name}: not two conversions on the edge of TRGO2")
        need(self.due == NEVER, f"{self.name} is triggered while it converts")
        need(not self.fresh, f"{self.name}: the first conversion behind its enabling is one that counts")
        need(self.chip.now >= self.converted, f"{self.name} is triggered in a regular conversion")
        channels = (sequence >> 9 & 0x1F, sequence >> 15 & 0x1F)
        self.results = [self._convert(channel) for channel in channels]
        self.due = self.chip.now + sum(map(self._duration, channels))

    def fire(self):
        self.due = NEVER
        self["JDR1"], self["JDR2"] = self.results
        self["ISR"] |= 0x60

    def wants_interrupt(self):
        return bool(self["ISR"] & self["IER"])

    def _sampling(self, channel):
        register, place = ("SMPR1", channel) if channel < 10 else ("SMPR2", channel - 10)
        return HALF_CYCLES[self[register] >> 3 * place & 7]

    def _duration(self, channel):
        return HALF_CYCLE * (self._sampling(channel) + CONVERSION_HALF_CYCLES)

    def _convert(self, channel):
        """ES0431 2.5.8: the first conversion behind the enabling may be one of channel 0."""
        if self.fresh:
            self.fresh = False
            return FLOATING
        if channel not in self.inputs:
            raise WrongAccess(f"{self.name} converts channel {channel}, where nothing is connected")
        return min(max(round(self.inputs[channel]()), 0), 4095)

    def _stopped(self, key):
        def write(value):
            need(not bit(self["CR"], 3), f"{self.name}_{key} is written while triggers are awaited")
            self[key] = value
        return write

    def _flags(self):
        if not self.ready.seen and self.ready.look():
            self["ISR"] |= 1
        if self.converting and self.chip.now >= self.converted:
            self.converting = False
            self["ISR"] |= 4
        return self.register("ISR").value

    def _acknowledge(self, value):
        self["ISR"] &= ~value

    def _control_read(self):
        value = self.register("CR").value
        if bit(value, 31) and self.chip.now >= self.calibrated:
            value &= ~(1 << 31)
            self["CR"] = value
        return value

    def _control(self, value):
        now = self.chip.now
        if not bit(self["CR"], 28) and bit(value, 28):
            need(not bit(self["CR"], 29), f"{self.name} is in deep power-down")
            self.regulated = now + REGULATOR_START
        if bit(value, 31):
            need(now >= self.regulated, f"{self.name} is calibrated before its regulator is up")
            self.calibrated = now + CALIBRATION_CYCLES
        if bit(value, 0) and not bit(self["CR"], 0):
            need(now >= self.calibrated + 4 * 4, f"{self.name} is enabled before it is calibrated")
            self.ready.start()
            self.fresh = True
        if value & 0xC:
            need(self.ready.seen, f"{self.name} is started, and was not seen to be ready")
        if bit(value, 2):
            need(self.due == NEVER, f"{self.name} is started within its injected sequence")
            channel = self["SQR1"] >> 6 & 0x1F
            self["DR"] = self._convert(channel)
            self.converting = True
            self.converted = self.chip.now + self._duration(channel)
        sticky = self["CR"] & 0x80000009  # these are not cleared by writing 0
        self["CR"] = value & 0xB0000009 | sticky

    def _read_regular(self):
        need(self.chip.now >= self.converted, f"{self.name}_DR is read in a conversion")
        self["ISR"] &= ~4
        return self.register("DR").value


class Level(Block):
    """DAC3, whose two channels go to the comparators."""

    def __init__(self, chip, clocked):
        self.chip = chip
        self.ready = {1: NEVER, 2: NEVER}
        super().__init__("DAC3", 0x50001000, {
            "CR": (0x00, Register(0, 0x10001, on_write=self._enable)),
            "DHR12R1": (0x08, Register(0, 0xFFF, on_write=self._write("DHR12R1"))),
            "DHR12R2": (0x14, Register(0, 0xFFF, on_write=self._write("DHR12R2"))),
            "SR": (0x34, Register(0, 0, self._status)),
            "MCR": (0x3C, Register(0, 0x0007C007)),
        }, clocked)

    def _write(self, key):
        def write(value):
            self[key] = value
            self.chip.comparators_changed()
        return write

    def _enable(self, value):
        for channel in self.ready:
            place = 16 * (channel - 1)
            if bit(value, place) and not bit(self["CR"], place):
                self.ready[channel] = self.chip.now + LEVEL_START
        self._write("CR")(value)

    def _status(self):
        return sum((self.chip.now >= ready) << 11 + 16 * (channel - 1) for channel, ready in self.ready.items())

    def voltage(self, channel):
        """Of an output, or None: that is anything."""
        mode = self["MCR"] >> 16 * (channel - 1) & 7
        need(bit(self["CR"], 16 * (channel - 1)) and mode == 3, f"DAC3 channel {channel} is off")
        need(self["MCR"] >> 14 & 3 == 2, "DAC3 is not set for this bus clock")
        return self[f"DHR12R{channel}"] if self.chip.now >= self.ready[channel] else None


class Comparators(Block):
    """Three comparators of the shunts with the level."""

    def __init__(self, chip, parts, clocked):
        self.chip = chip
        self.parts = parts
        self.due = NEVER  # all that were enabled have started
        self.ready = dict.fromkeys(COMPARATORS, NEVER)
        super().__init__("COMP", 0x40010200, {
            f"{number}_CSR": (4 * (number - 1), Register(0, 0x80070071, on_write=self._write(number)))
            for number in COMPARATORS
        }, clocked)

    def _write(self, number):
        key = f"{number}_CSR"

        def write(value):
            need(not bit(self[key], 31), f"COMP{number} is locked")
            if bit(value, 0) and not bit(self[key], 0):
                self.ready[number] = self.due = self.chip.now + COMPARATOR_START
            self[key] = value
            self.chip.comparators_changed()
        return write

    def fire(self):
        self.due = NEVER
        self.chip.comparators_changed()

    def output(self, number):
        """High or low, or None: that is anything."""
        value = self[f"{number}_CSR"]
        if not bit(value, 0):
            return False
        need(value >> 4 & 7 == 4, f"comparator {number} does not look at DAC3")
        pin, channel = COMPARATORS[number]
        level = self.chip.level.voltage(channel)
        if level is None or self.chip.now < self.ready[number]:
            return None
        return self.chip.pins[pin] + self.parts.comparator[number] > level
