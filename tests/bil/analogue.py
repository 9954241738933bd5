# SPDX-License-Identifier: MIT
"""Models of an STM32G4's analogue side: amplifiers, converters, comparators and their level.

Facts from the reference manual RM0440 and the data sheet. Voltages are in counts of the converters,
4096 for the reference.
"""

import random

import g4
from core import NEVER
from digital import Awaited, bit, cycles, need
from registers import Block, Register

HALF_CYCLES = (5, 13, 25, 49, 95, 185, 495, 1281)  # of sampling, by the code in SMPR
CONVERSION_HALF_CYCLES = 25
HALF_CYCLE = 2                                     # at a quarter of 170 MHz
CALIBRATION_CYCLES = 116 * 4                       # data sheet DS12589 rev. 6, table 60
FLOATING = 4095                                    # what a pin that nobody drives may convert to
READY_CYCLES = (5 + 25) * HALF_CYCLE               # the same table: a conversion at least; no longest one is given

# Data sheet DS12589 rev. 6, the longest each.
REGULATOR_START = cycles(20e-6)  # table 60
AMPLIFIER_START = cycles(6e-6)   # table 74, high-speed mode
# Table 70 for DACs of 15 MSPS, inside the chip only; table 69 for those of 1 MSPS, whose buffer is off.
LEVEL_START = {"DAC1": cycles(5e-6), "DAC2": cycles(5e-6), "DAC3": cycles(3.5e-6), "DAC4": cycles(3.5e-6)}
COMPARATOR_START = cycles(5e-6)  # table 73

# The same: the least, the ideal one, the most.
COUNTS_PER_MV = 4096 / 3300
COMPARATOR_OFFSET_MV = (-9, 0, 3)  # table 73
AMPLIFIER_OFFSET_MV = (-3, 0, 3)   # table 74
AMPLIFIER_GAIN = (0.98, 1, 1.02)   # table 74: 1 % for gains up to 16; the other one is assumed for resistors around
BIAS = (0.98, 1, 1.02)             # of a pin without current: a divider of resistors of 1 %


class Parts:
    """What the comparator and amplifier of each phase do in one board of many, and the resistors before them. `choose` takes a
    value out of a tolerance: ideal, least, most or drawn()."""

    def __init__(self, choose):
        def of(tolerance, scale=1):
            return [choose(tolerance) * scale for _ in range(3)]

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
    """The programmable amplifiers that can have a shunt of the board at their plus input."""

    def __init__(self, chip, wiring, parts, clocked):
        self.chip = chip
        self.wiring = wiring
        self.parts = parts
        self.ready = dict.fromkeys(wiring.amplifiers, NEVER)
        base = chip.facts.base("OPAMP1")
        super().__init__("OPAMP", base, {
            f"{number}_CSR": (chip.facts.base(f"OPAMP{number}") - base, Register(0, 0x0007C1ED, on_write=self._write(number)))
            for number in wiring.amplifiers
        }, clocked)

    def _write(self, number):
        def write(value):
            if bit(value, 0) and not bit(self[f"{number}_CSR"], 0):
                self.ready[number] = self.chip.now + AMPLIFIER_START
            self[f"{number}_CSR"] = value
        return write

    def output(self, number, inside):
        """At the output pin, or inside of the chip."""
        need(number in self.ready, f"amplifier {number} is converted, and no shunt can be at its input")
        value = self[f"{number}_CSR"]
        need(bool(bit(value, 8)) == inside, f"amplifier {number} drives another output")
        phase = self._phase(number, value)
        if self.chip.now < self.ready[number]:
            return 0
        return (self.chip.pins[self.wiring.shunts[phase]] + self.parts.amplifier[phase]) * self._gain(number, value, phase)

    def drives(self, pin):
        number = self.chip.facts.amplifier_at(pin)
        return number in self.ready and self[f"{number}_CSR"] & 0x101 == 1

    def _phase(self, number, value):
        """Of the shunt at its plus input."""
        code = value >> 2 & 3  # VP_SEL
        pin = self.chip.facts.pin_of(f"OPAMP{number}_VINP{code}")
        need(bit(value, 0) and pin in self.wiring.shunts, f"amplifier {number} does not amplify a shunt's pin")
        return self.wiring.shunts.index(pin)

    def _gain(self, number, value, phase):
        if value & 0x61 == 0x61:  # its output is its minus input
            return 1
        need(value & 0x61 == 0x41, f"amplifier {number} does not amplify its pin")
        need(value >> 17 & 3 == 1, f"amplifier {number} does not refer to its minus pin")
        ground = self.chip.facts.pin_of(f"OPAMP{number}_VINM0")
        need(ground == self.wiring.grounds[phase],
             f"amplifier {number} refers to {ground}, and the shunt's ground is at another pin")
        return (2 << (value >> 14 & 7)) * self.parts.gain[phase]


class Converter(Block):
    """One of the converters. `lengths`: how many conversions its injected sequence may have on this board."""

    def __init__(self, chip, name, lengths, clocked):
        self.chip = chip
        self.lengths = lengths
        self.trigger_code = chip.facts.injected_trigger(name)
        self.due = NEVER       # end of the injected sequence
        self.regulated = NEVER
        self.calibrated = NEVER
        self.converted = 0     # end of the regular conversion
        self.converting = False  # regular, not yet told by its flag
        self.ready = Awaited(chip, READY_CYCLES)
        self.fresh = False     # enabled, and nothing was converted since
        self.results = []
        super().__init__(name, chip.facts.base(name), {
            "ISR": (0x00, Register(0, 0x7FF, self._flags, self._acknowledge)),
            "IER": (0x04, Register(0, 0x40)),
            "CR": (0x08, Register(0x20000000, 0x9000000D, self._control_read, self._control)),
            "CFGR": (0x0C, Register(0x80000000, 0x1000, on_write=self._stopped("CFGR"))),
            "SMPR1": (0x14, Register(0, 0x3FFFFFFF, on_write=self._stopped("SMPR1"))),
            "SMPR2": (0x18, Register(0, 0x07FFFFFF, on_write=self._stopped("SMPR2"))),
            "SQR1": (0x30, Register(0, 0x7CF)),
            "DR": (0x40, Register(0, 0, self._read_regular)),
            "JSQR": (0x4C, Register(0, 0x000FBFFF, on_write=self._stopped("JSQR"))),
            "JDR1": (0x80, Register(0, 0)),
            "JDR2": (0x84, Register(0, 0)),
        }, clocked)

    def trigger(self):
        """TIM1's TRGO2 has risen: the inputs of the sequence are taken, the first one now."""
        sequence = self["JSQR"]
        if not bit(self["CR"], 3):
            return
        length = (sequence & 3) + 1
        need(sequence >> 2 & 0x7F == 1 << 5 | self.trigger_code and length in self.lengths,
             f"{self.name}: not {self.lengths} conversions on the edge of TRGO2")
        need(self.due == NEVER, f"{self.name} is triggered while it converts")
        need(not self.fresh, f"{self.name}: the first conversion behind its enabling is one that counts")
        need(self.chip.now >= self.converted, f"{self.name} is triggered in a regular conversion")
        channels = (sequence >> 9 & 0x1F, sequence >> 15 & 0x1F)[:length]
        self.results = [self._convert(channel) for channel in channels]
        self.due = self.chip.now + sum(map(self._duration, channels))

    def fire(self):
        self.due = NEVER
        for rank, result in enumerate(self.results, start=1):
            self[f"JDR{rank}"] = result
        self["ISR"] |= 0x60

    def wants_interrupt(self):
        return bool(self["ISR"] & self["IER"])

    def _sampling(self, channel):
        register, place = ("SMPR1", channel) if channel < 10 else ("SMPR2", channel - 10)
        return HALF_CYCLES[self[register] >> 3 * place & 7]

    def _duration(self, channel):
        return HALF_CYCLE * (self._sampling(channel) + CONVERSION_HALF_CYCLES) * self.chip.power.cycle

    def stretch(self, factor):
        """Another speed of the clock."""
        now = self.chip.now
        self.due = self.due if self.due == NEVER else now + round((self.due - now) * factor)
        self.converted = now + round((self.converted - now) * factor) if self.converted > now else self.converted

    def _convert(self, channel):
        """ES0431 2.5.8: the first conversion behind the enabling may be one of channel 0."""
        if self.fresh:
            self.fresh = False
            return FLOATING
        return min(max(round(self.chip.input(self.name, channel)), 0), 4095)

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
    """A DAC whose channels go to the comparators."""

    def __init__(self, chip, name, clocked):
        self.chip = chip
        self.channels = g4.DAC_CHANNELS[name]
        self.ready = dict.fromkeys(self.channels, NEVER)
        super().__init__(name, chip.facts.base(name), {
            "CR": (0x00, Register(0, self._of_each(1), on_write=self._enable)),
            **{key: (offset, Register(0, 0xFFF, on_write=self._write(key)))
               for key, offset, channel in (("DHR12R1", 0x08, 1), ("DHR12R2", 0x14, 2)) if channel in self.channels},
            "SR": (0x34, Register(0, 0, self._status)),
            "MCR": (0x3C, Register(0, self._of_each(7) | 3 << 14)),
        }, clocked)

    def _of_each(self, bits):
        return sum(bits << 16 * (channel - 1) for channel in self.channels)

    def _write(self, key):
        def write(value):
            self[key] = value
            self.chip.break_changed()
        return write

    def _enable(self, value):
        for channel in self.channels:
            place = 16 * (channel - 1)
            if bit(value, place) and not bit(self["CR"], place):
                self.ready[channel] = self.chip.now + LEVEL_START[self.name]
        self._write("CR")(value)

    def _status(self):
        return sum((self.chip.now >= ready) << 11 + 16 * (channel - 1) for channel, ready in self.ready.items())

    def voltage(self, channel):
        """Of an output, or None: that is anything."""
        mode = self["MCR"] >> 16 * (channel - 1) & 7
        need(bit(self["CR"], 16 * (channel - 1)) and mode == 3, f"{self.name} channel {channel} is off")
        need(self["MCR"] >> 14 & 3 == 2, f"{self.name} is not set for this bus clock")
        return self[f"DHR12R{channel}"] if self.chip.now >= self.ready[channel] else None


class Comparators(Block):
    """The comparators at the shunts' pins, each with a level."""

    INVERTED = 15  # POLARITY

    def __init__(self, chip, wiring, parts, clocked):
        self.chip = chip
        self.wiring = wiring
        self.parts = parts
        self.numbers = wiring.comparators
        at_pins = {pin: chip.facts.comparator_of(pin) for pin in wiring.shunts}
        self._phases = {found[0]: phase for phase, found in enumerate(at_pins.values()) if found}
        self._plus = {number: select << 8 for number, select in filter(None, at_pins.values())}  # INPSEL for the shunt's pin
        self.due = NEVER  # all that were enabled have started
        self.ready = dict.fromkeys(self.numbers, NEVER)
        super().__init__("COMP", chip.facts.base("COMP1"), {
            f"{number}_CSR": (4 * (number - 1), Register(0, 0x80070071 | self._polarity(number) | self._plus[number],
                                                         on_write=self._write(number)))
            for number in self.numbers
        }, clocked)

    def _polarity(self, number):
        """Where the timer cannot invert, the comparator can."""
        return 1 << self.INVERTED if g4.polarity_bit(number) is None else 0

    def _write(self, number):
        key = f"{number}_CSR"

        def write(value):
            need(not bit(self[key], 31), f"COMP{number} is locked")
            if bit(value, 0) and not bit(self[key], 0):
                self.ready[number] = self.due = self.chip.now + COMPARATOR_START
            self[key] = value
            self.chip.break_changed()
        return write

    def fire(self):
        self.due = NEVER
        self.chip.break_changed()

    def output(self, number):
        """High or low, or None: that is anything."""
        value = self[f"{number}_CSR"]
        if not bit(value, 0):
            return bool(bit(value, self.INVERTED))
        need(value & 1 << 8 == self._plus[number], f"comparator {number} does not look at the shunt's pin")
        level = self._level(number, value >> 4 & 7)
        if level is None or self.chip.now < self.ready[number]:
            return None
        phase = self._phases[number]
        is_above = self.chip.pins[self.wiring.shunts[phase]] + self.parts.comparator[phase] > level
        return is_above != bool(bit(value, self.INVERTED))

    def _level(self, number, select):
        dac, channel = g4.MINUS[number].get(select, (None, None))
        need(dac in self.chip.levels, f"comparator {number} does not look at a DAC")
        return self.chip.levels[dac].voltage(channel)
