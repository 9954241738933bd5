# SPDX-License-Identifier: MIT
"""Models of an STM32G4's digital side: clocks, pins, timer, console, watchdog and core peripherals.

Facts from the reference manual RM0440 and the ARMv7-M architecture manual. Time counts cycles of the
170 MHz clock. A model that has something to do at a time holds it in `due` and does it in fire().
"""

import collections
import zlib

import g4
from core import NEVER
from flash import Flash
from registers import Block, Register, WrongAccess, bit, need

CLOCK_HZ = 170e6
OSCILLATOR_HZ = 16e6


def cycles(seconds):
    return round(seconds * CLOCK_HZ)


# Data sheet DS12589 rev. 6, the longest each. Table 36 is of a change of range: that of the boost is assumed to be alike.
PLL_LOCK = cycles(40e-6)  # table 45
REGULATOR_SETTLING = cycles(40e-6)
HALF_SPEED = cycles(1e-6)  # RM0440 6.1.5: so long at half the speed
CRYSTAL_START = cycles(2e-3)  # characteristics of the HSE oscillator, typically: no longest time is given
# Neither manual nor data sheet says how soon a dead crystal is noticed. Assumed: some periods of the internal oscillator.
CRYSTAL_WATCH = cycles(2e-6)
HSION, HSIRDY, HSEON, HSERDY, CSSON, PLLON, PLLRDY = (1 << place for place in (8, 10, 16, 17, 19, 24, 25))  # of RCC_CR
OSCILLATOR_BITS, CRYSTAL_BITS, PLL_BITS = HSION | HSIRDY, HSEON | HSERDY | CSSON, PLLON | PLLRDY
CSSF = 1 << 8  # of RCC_CIFR
FROM_OSCILLATOR, FROM_CRYSTAL = 2, 3  # PLLSRC


class Awaited:
    """What takes its time, and tells by a flag that it is done: without a look at that flag one goes on by luck."""

    def __init__(self, chip, duration):
        self.chip = chip
        self.duration = duration
        self.end = NEVER
        self.seen = False

    def start(self):
        self.end = self.chip.now + self.duration
        self.seen = False

    def look(self):
        self.seen = self.seen or self.chip.now >= self.end
        return self.seen


class Backup(Block):
    """The backup registers: they keep their words through each reset. RM0440 6.1.6: locked until DBP."""

    COUNT = 16

    def __init__(self, power):
        super().__init__("TAMP", 0x40002400, {f"BKP{number}R": (0x100 + 4 * number, Register(on_write=self._writer(power, number)))
                                              for number in range(self.COUNT)},
                         lambda: bit(power.rcc["APB1ENR1"], 10))

    def _writer(self, power, number):
        def write(value):
            if bit(power.pwr["CR1"], 8):
                self[f"BKP{number}R"] = value
        return write

    @property
    def words(self):
        return [self[f"BKP{number}R"] for number in range(self.COUNT)]

    @words.setter
    def words(self, words):
        for number, word in enumerate(words):
            self[f"BKP{number}R"] = word


class Power:
    """Regulator, flash and clock tree: the step to 170 MHz has to be done in the manual's order. `crystal_hz`: what the crystal
    swings with, 0 if there is none."""

    ALWAYS = {"AHB1ENR": 1 << 12, "APB1ENR1": 1 << 28 | 1 << 10}  # CRC unit, power, backup registers

    def __init__(self, chip, reset_flags, peripherals, crystal_hz):
        """`peripherals`: the names of those whose clock can be enabled."""
        self.chip = chip
        self.facts = chip.facts
        self.crystal_hz = crystal_hz
        self.cycle = self.chip.clock.cycle = round(CLOCK_HZ / OSCILLATOR_HZ)  # of the system clock, in cycles of 170 MHz
        self.system_hz = OSCILLATOR_HZ
        self.due = NEVER  # a dead crystal is noticed
        self.pll = Awaited(chip, PLL_LOCK)
        self.crystal = Awaited(chip, CRYSTAL_START)
        self.regulator = Awaited(chip, REGULATOR_SETTLING)
        self.halved = 0
        self.pwr = Block("PWR", 0x40007000, {
            "CR1": (0x00, Register(0x200, 0x100)),
            "CR2": (0x04, Register(0, 0xF)),
            "CR3": (0x08, Register(0x8000, 1 << 14)),
            "SR2": (0x14, Register(0, 0, lambda: self._settling() << 10)),
            "CR5": (0x80, Register(0x100, 0x100, on_write=self._set_range)),
        }, lambda: bit(self.rcc["APB1ENR1"], 28))
        self.flash = Flash(chip)
        enable = self._enable_bits(peripherals)
        self.rcc = Block("RCC", 0x40021000, {
            "CR": (0x00, Register(0x500, OSCILLATOR_BITS | CRYSTAL_BITS | PLL_BITS, self._control_read, self._control)),
            "CFGR": (0x08, Register(0x5, 0xFF, on_write=self._configure)),
            "PLLCFGR": (0x0C, Register(0x1000, 0x07007FF3, on_write=self._set_pll)),
            "CIFR": (0x1C, Register(0, 0)),
            "CICR": (0x20, Register(0, CSSF, on_write=self._clear_interrupts)),
            "AHB1ENR": (0x48, Register(0x100, enable["AHB1ENR"])),
            "AHB2ENR": (0x4C, Register(0, enable["AHB2ENR"])),
            "APB1ENR1": (0x58, Register(0, enable["APB1ENR1"])),
            "APB1ENR2": (0x5C, Register(0, enable["APB1ENR2"])),
            "APB2ENR": (0x60, Register(0, enable["APB2ENR"])),
            "CSR": (0x94, Register(reset_flags, 0x00800000, on_write=self._clear_flags)),
        })
        self.backup = Backup(self)
        self.blocks = [self.pwr, self.flash, self.flash.kept, self.rcc, self.backup]

    def _enable_bits(self, peripherals):
        found = dict.fromkeys(("AHB1ENR", "AHB2ENR", "APB1ENR1", "APB1ENR2", "APB2ENR"), 0) | self.ALWAYS
        for peripheral in peripherals:
            register, number = self.facts.enable(peripheral)
            found[register] |= 1 << number
        return found

    def enabled(self, peripheral):
        """A function that says whether a peripheral has its clock."""
        register, number = self.facts.enable(peripheral)
        return lambda: bit(self.rcc[register], number)

    def _settling(self):
        return self.regulator.end != NEVER and not self.regulator.look()

    def _set_range(self, value):
        if value != self.pwr["CR5"]:
            self.regulator.start()
        self.pwr["CR5"] = value

    def _control(self, value):
        old = self.rcc["CR"]
        set_now = value & ~old
        if set_now & HSEON:
            self.crystal.start()
        if set_now & PLLON:
            need(self._pll_source() == FROM_OSCILLATOR or self.crystal.seen,
                 "the PLL starts, and the crystal was not seen to be ready")
            self.pll.start()
        need(not old & CSSON or value & CSSON, "the watch of the crystal can only be switched off by a reset")
        need(value & HSEON or not (value & PLLON and self._pll_source() == FROM_CRYSTAL), "the PLL has lost its crystal")
        self.rcc["CR"] = value & (HSION | HSEON | CSSON | PLLON) | bit(value, 8) << 10

    def _control_read(self):
        value = self.rcc["CR"]
        value |= PLLRDY if value & PLLON and self.pll.look() else 0
        value |= HSERDY if value & HSEON and self.crystal_hz and self.crystal.look() else 0
        self.rcc["CR"] = value
        return value

    def _pll_source(self):
        return self.rcc["PLLCFGR"] & 3

    def _set_pll(self, value):
        need(not bit(self.rcc["CR"], 24), "PLLCFGR is written while the PLL runs")
        self.rcc["PLLCFGR"] = value

    def _pll_hz(self):
        value = self.rcc["PLLCFGR"]
        need(self._pll_source() in (FROM_OSCILLATOR, FROM_CRYSTAL) and bit(value, 24), "the PLL has no input or no output")
        source = OSCILLATOR_HZ if self._pll_source() == FROM_OSCILLATOR else self.crystal_hz
        divided = source / ((value >> 4 & 0xF) + 1)
        need(2.66e6 <= divided <= 16e6, f"the PLL's input cannot have {divided:g} Hz")
        vco = divided * (value >> 8 & 0x7F)
        need(96e6 <= vco <= 344e6, f"the PLL's oscillator cannot run at {vco:g} Hz")
        return vco / (2 * ((value >> 25 & 3) + 1))

    def _configure(self, value):
        prescaler = value >> 4 & 0xF
        if value & 3 == 3:
            need(self.pll.seen, "the clock is switched to a PLL that was not seen to be ready")
            need(self._pll_hz() == CLOCK_HZ, f"the clock is {self._pll_hz():g} Hz")
            need(not bit(self.pwr["CR5"], 8), "above 150 MHz without boost")
            need(self.regulator.seen, "the clock is switched, and the regulator was not seen to have settled")
            need(self.flash["ACR"] & 0xF >= 4, "170 MHz with too few wait states")
            self._step_up(prescaler)
        self.rcc["CFGR"] = value & ~0xC | (value & 3) << 2

    def _step_up(self, prescaler):
        """To full speed by way of half of it."""
        if prescaler == 8:
            self.halved = self.chip.now
        else:
            need(self.rcc["CFGR"] & 3 == 3 and self.chip.now >= self.halved + HALF_SPEED,
                 "no step of a microsecond at half of the speed")
        self._set_speed(CLOCK_HZ / 2 if prescaler == 8 else CLOCK_HZ)

    def _set_speed(self, system_hz):
        """What the chip's parts have begun goes on at the new speed."""
        before = self.cycle
        self.chip.settle()
        self.system_hz = system_hz
        self.cycle = self.chip.clock.cycle = round(CLOCK_HZ / system_hz)
        self.chip.stretch(self.cycle / before)

    def _clear_flags(self, value):
        if bit(value, 23):
            self.rcc["CSR"] = 0

    def _clear_interrupts(self, value):
        self.rcc["CIFR"] &= ~value

    def runs_at_full_speed(self):
        return self.rcc["CFGR"] & 0xFF == 0xF

    def crystal_32_hz(self):
        """What the timers can capture of it, 0 while it does not swing."""
        swings = self.rcc["CR"] & HSEON and self.chip.now >= self.crystal.end
        return self.crystal_hz / 32 if swings else 0

    def runs_on_crystal(self):
        return self.rcc["CFGR"] & 3 == 3 and self._pll_source() == FROM_CRYSTAL

    def asks_for_nmi(self):
        """RM0440 7.2, clock security system: until the flag is cleared."""
        return bool(self.rcc["CIFR"] & CSSF)

    def stop_crystal(self):
        """It dies. Until that is noticed the PLL keeps its speed: an assumption, see CRYSTAL_WATCH."""
        need(self.rcc["CR"] & CSSON or not self.runs_on_crystal(),
             "the crystal dies, and nobody watches it: the chip stands still")
        self.crystal_hz = 0
        if self.rcc["CR"] & CSSON:
            self.due = self.chip.now + CRYSTAL_WATCH

    def fire(self):
        """RM0440 7.2, clock security system: the timer's outputs open, and the clock becomes the internal oscillator, all by
        hardware."""
        self.due = NEVER
        self.rcc["CR"] &= ~CRYSTAL_BITS
        self.rcc["CIFR"] |= CSSF
        self.chip.timer.break_by_system()
        if self.runs_on_crystal():
            self.rcc["CR"] = self.rcc["CR"] & ~PLL_BITS | OSCILLATOR_BITS
            self.rcc["CFGR"] = self.rcc["CFGR"] & ~0xF | 5
            self._set_speed(OSCILLATOR_HZ)


class Port(Block):
    """A port of pins. `changed` is called when one may drive another level, or have another function; `level_of` says the level
    of a pin."""

    def __init__(self, letter, base, clocked, changed, level_of):
        self.letter = letter
        self.output = 0
        self.changed = changed
        self.level_of = level_of
        modes, pulls, speeds = g4.PORT_RESETS.get(letter, g4.OTHER_PORTS_RESET)
        super().__init__(f"GPIO{letter}", base, {
            "MODER": (0x00, Register(modes, on_write=self._set_modes)),
            "OSPEEDR": (0x08, Register(speeds)),
            "PUPDR": (0x0C, Register(pulls)),
            "IDR": (0x10, Register(0, 0, self._levels)),
            "BSRR": (0x18, Register(on_write=self._set)),
            "AFRL": (0x20, Register()),
            "AFRH": (0x24, Register()),
        }, clocked)

    def _levels(self):
        """Of an analogue pin 0: its digital input is off."""
        return sum(bool(self.level_of(f"P{self.letter}{pin}")) << pin for pin in range(16) if self.mode(pin) != 3)

    def _set(self, value):
        self.output = self.output & ~(value >> 16) | value & 0xFFFF
        self.changed()

    def _set_modes(self, value):
        self["MODER"] = value
        self.changed()

    def mode(self, pin):
        return self["MODER"] >> 2 * pin & 3

    def level(self, pin):
        """What it drives as an output, or None."""
        return self.output >> pin & 1 if self.mode(pin) == 1 else None

    def function(self, pin):
        return self["AFRH" if pin > 7 else "AFRL"] >> 4 * (pin % 8) & 0xF


# Cycles of the timer that BKF lets pass: samples that have to be equal, times what the sampling clock is divided by.
BREAK_FILTER = (0, 2, 4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 128, 160, 192, 256)


class Timer(Block):
    """TIM1 as a centre-aligned PWM generator with break, for the legs of a board (wiring.py). `trigger` is called at each
    TRGO2."""

    IDLE_LEVELS = 0x3F00  # of CR2: OIS1 to OIS3N

    def __init__(self, chip, wiring, clocked):
        self.chip = chip
        self.wiring = wiring
        self.due = NEVER      # the next end of the ramp
        self.active = (0, 0, 0)  # compare values behind the preload registers
        self.repeats = 0
        self.rising = True
        self.trigger = None
        self.broken = False   # level of the break input
        self.opened = 0       # when the main output went off
        super().__init__("TIM1", chip.facts.base("TIM1"), {
            "CR1": (0x00, Register(0, 0xA1, self._control_read, self._control)),
            "CR2": (0x04, Register(0, 0xF << 20 | self._idle_levels(), on_write=self._set_idle_levels)),
            "SR": (0x10, Register(0, on_write=self._acknowledge)),
            "EGR": (0x14, Register(0, 1, on_write=self._generate)),
            "CCMR1": (0x18, Register(0, 0x7878)),
            "CCMR2": (0x1C, Register(0, 0x7878)),
            "CCER": (0x20, Register(0, self._outputs())),
            "CNT": (0x24, Register(0, 0, self.count)),
            "PSC": (0x28, Register(0, 0)),
            "ARR": (0x2C, Register(0xFFFF, 0xFFFF)),
            "RCR": (0x30, Register(0, 0xFFFF)),
            "CCR1": (0x34, Register(0, 0xFFFF)),
            "CCR2": (0x38, Register(0, 0xFFFF)),
            "CCR3": (0x3C, Register(0, 0xFFFF)),
            "BDTR": (0x44, Register(0, 0x000FBFFF, on_write=self._set_break)),
            "AF1": (0x60, Register(1, self._break_sources(), on_write=self._select_break)),
        }, clocked)

    def _break_sources(self):
        """The bits of AF1 that this board can use: its comparators and the pin, with their polarities."""
        numbers = self.wiring.comparators
        bits = [0, 9, *numbers, *(g4.polarity_bit(number) for number in numbers)]
        return sum(1 << number for number in set(bits) - {None})

    def preloaded(self):
        """The compare values of phases a, b, c."""
        return tuple(self[f"CCR{leg.channel}"] for leg in self.wiring.legs)

    def ramp(self):
        """How long it takes, in cycles of 170 MHz."""
        return self["ARR"] * self.chip.power.cycle

    def next_update(self):
        """When the next update event comes."""
        return self.due + self.repeats * self.ramp()

    def stretch(self, factor):
        """Another speed of the clock."""
        if self.due != NEVER:
            self.due = self.chip.now + round((self.due - self.chip.now) * factor)

    def filter_cycles(self):
        """What is shorter does not pass the break input's filter, RM0440 28.6.20 (BKF)."""
        code = self["BDTR"] >> 16 & 0xF
        return BREAK_FILTER[code]

    def output(self, channel, is_second):
        """0, 1, "pwm", or None if the timer does not drive it: RM0440 28.6 (CCER), table "Output control bits for
        complementary channels with break feature"."""
        bits = self["CCER"] >> 4 * (channel - 1)
        enabled, inactive = bit(bits, 2 * is_second), bit(bits, 2 * is_second + 1)
        main, idle_is_driven, off_is_driven = (bit(self["BDTR"], place) for place in (15, 10, 11))
        if main and enabled:
            return "pwm"
        if not bits & 5 or not (off_is_driven if main else idle_is_driven):
            return None
        if main or self.chip.now < self.opened + self.dead_time() * self.chip.power.cycle:
            return inactive
        return bit(self["CR2"], 8 + 2 * (channel - 1) + is_second)

    def enables(self):
        """The levels at the drivers' enable pins, phases a, b, c."""
        return tuple(self.output(leg.channel, True) for leg in self.wiring.legs)

    def gates_on(self):
        """The main output is on, and outputs of channels are connected to it."""
        return bool(bit(self["BDTR"], 15)) and self["CCER"] != 0

    def dead_time(self):
        """In cycles, RM0440 28.6.20."""
        code = self["BDTR"] & 0xFF
        if code < 0x80:
            return code
        if code < 0xC0:
            return (64 + (code & 0x3F)) * 2
        return (32 + (code & 0x1F)) * (16 if code >= 0xE0 else 8)

    def count(self):
        left = (self.due - self.chip.now) // self.chip.power.cycle if bit(self["CR1"], 0) else self["ARR"]
        return self["ARR"] - left if self.rising else left

    def set_break_input(self, active):
        self.broken = active and bool(bit(self["BDTR"], 12))
        if self.broken:
            self._open()
            self["SR"] |= 1 << 7

    def break_by_system(self):
        """RM0440 28.6.5, SBIF."""
        if bit(self["BDTR"], 12):
            self["SR"] |= 1 << 13
            self._open()

    def _open(self):
        if bit(self["BDTR"], 15):
            self.opened = self.chip.now
        self["BDTR"] &= ~(1 << 15)

    def fire(self):
        self.due += self.ramp()
        self.rising = not self.rising
        if self.repeats:
            self.repeats -= 1
        else:
            self._update()

    def _update(self):
        self.repeats = self["RCR"]
        self.active = self.preloaded()
        self["SR"] |= 1
        if self["CR2"] >> 20 & 0xF == 2 and self.trigger:
            self.trigger()

    def _control_read(self):
        return self.register("CR1").value | (not self.rising) << 4

    def _control(self, value):
        if bit(value, 0) and not bit(self["CR1"], 0):
            need(value & 0x60 == 0x20, "TIM1 starts, and is not centre aligned")
            need((self["CCMR1"], self["CCMR2"]) == (0x6868, 0x68), "not PWM mode 1 with preload")
            need(self["CCER"] == self._outputs(), "not all outputs are on, with the polarity of the board")
            need(self["CR2"] & self.IDLE_LEVELS == self._idle_levels(), "an output has an idle level that does not open its gate")
            need(self["AF1"] & self._needed_sources() == self._needed_sources(),
                 "a comparator or the break pin does not reach the break input")
            self.due = self.chip.now + self.ramp()
        self["CR1"] = value & ~0x10

    def _outputs(self):
        """CCER: both outputs of each leg. The second one is off if it is an enable, and its polarity makes its inactive level the
        high one."""
        second = 8 if self.wiring.has_enables else 4 | self.wiring.low_inverted << 3
        return sum((1 | self.wiring.high_inverted << 1 | second) << 4 * (leg.channel - 1) for leg in self.wiring.legs)

    def _idle_levels(self):
        """Of CR2: a closed gate has its inactive level, an enable is low."""
        low = self.wiring.low_inverted and not self.wiring.has_enables
        return sum((self.wiring.high_inverted | low << 1) << 8 + 2 * (leg.channel - 1) for leg in self.wiring.legs)

    def _needed_sources(self):
        return 1 if self.wiring.break_line else sum(1 << number for number in self.wiring.comparators)

    def _set_idle_levels(self, value):
        need((self["CR2"] ^ value) & self.IDLE_LEVELS == 0 or self["BDTR"] >> 8 & 3 == 0, "the idle levels are locked")
        self["CR2"] = value

    def _acknowledge(self, value):
        self["SR"] &= value
        self.chip.break_changed()

    def _generate(self, value):
        if bit(value, 0):
            self._update()

    def _set_break(self, value):
        old = self["BDTR"]
        locked = 0x000F3CFF if old >> 8 & 3 else 0  # what level 1 keeps, and more: nobody changes it
        need((old ^ value) & locked == 0, "BDTR is locked")
        if bit(value, 15) and not bit(value, 12):
            raise WrongAccess("gates are enabled without a break input")
        if not bit(value, 15):
            self._open()
        self["BDTR"] = value & ~(1 << 15) if self.broken else value
        self.chip.break_changed()

    def _select_break(self, value):
        self["AF1"] = value
        self.chip.break_changed()


class Usart(Block):
    """The serial interface with its FIFOs, at the speed of its line. `instant`: bytes to the PC take no time, where it is not the
    line that is tested: a dump takes some 5 s of it."""

    FIFO = 8
    BITS = 10
    PAUSE = cycles(300e-6)  # silence: the background has come by twice and more

    def __init__(self, chip, name, baud, clocked):
        self.chip = chip
        self.baud = baud
        self.instant = False
        self.starts = collections.deque()  # when each byte that still waits to be sent leaves the FIFO
        self.silent = -self.PAUSE          # when the last byte will have been sent
        self.said = bytearray()
        self.unreadable = 0  # bytes that were sent at another speed of the clock: a PC does not understand them
        self.arriving = collections.deque()  # (when, byte)
        self.received = collections.deque()
        self.broken = set()  # bytes that arrive with a wrong stop bit: the how many-th of all
        self.taken = 0
        self.acknowledged = -1
        self.overrun = False
        super().__init__(name, chip.facts.base(name), {
            "CR1": (0x00, Register(0, 0x2000000D, on_write=self._enable)),
            "BRR": (0x0C, Register(0, 0xFFFF)),
            "ISR": (0x1C, Register(on_read=self._status)),
            "ICR": (0x20, Register(0, 0xF, on_write=self._clear)),
            "RDR": (0x24, Register(0, 0, self._take)),
            "TDR": (0x28, Register(0, 0xFF, on_write=self._send)),
        }, clocked)

    def byte_cycles(self):
        return self.BITS * self["BRR"] * self.chip.power.cycle

    def receive(self, line):
        """Bytes that follow each other as closely as they can, whether someone takes them or not."""
        start = max(self.chip.now, self.arriving[-1][0] if self.arriving else 0)
        self.arriving.extend((start + (k + 1) * self.byte_cycles(), byte) for k, byte in enumerate(line))

    def receive_broken(self, byte):
        """A byte that arrives with a wrong stop bit, behind those that are on their way."""
        self.broken.add(self.taken + len(self.received) + len(self.arriving))
        self.receive(bytes([byte]))

    def receive_at_once(self, line):
        """As many as there is room for. Their number."""
        taken = line[:self.FIFO - len(self.received)]
        self.received.extend(taken)
        return len(taken)

    def sending_s(self):
        """How long until all is said, and nothing follows."""
        return 0 if self.instant else (self.silent + self.PAUSE - self.chip.now) / CLOCK_HZ

    def heard(self):
        said = self.said.decode()
        self.said.clear()
        return said

    def _enable(self, value):
        baud = CLOCK_HZ / self["BRR"]
        need(abs(baud / self.baud - 1) < 0.01, f"the console has {baud:g} baud")
        self["CR1"] = value

    def _has_room(self):
        while self.starts and self.starts[0] <= self.chip.now:
            self.starts.popleft()
        return len(self.starts) < self.FIFO

    def _arrive(self):
        """An overrun loses bytes until it is cleared."""
        while self.arriving and self.arriving[0][0] <= self.chip.now:
            byte = self.arriving.popleft()[1]
            self.overrun = self.overrun or len(self.received) == self.FIFO
            if not self.overrun:
                self.received.append(byte)

    def _status(self):
        """The framing error is that of the byte that is read next."""
        self._arrive()
        framing = bool(self.received) and self.taken in self.broken and self.acknowledged != self.taken
        return self._has_room() << 7 | bool(self.received) << 5 | self.overrun << 3 | framing << 1

    def _clear(self, value):
        self._arrive()
        self.overrun = self.overrun and not bit(value, 3)
        self.acknowledged = self.taken if bit(value, 1) else self.acknowledged

    def _take(self):
        self._arrive()
        self.taken += bool(self.received)
        return self.received.popleft() if self.received else 0

    def _send(self, value):
        need(self["CR1"] & 9 == 9, "a byte is sent while the transmitter is off")
        need(self._has_room(), "a byte is sent while there is no room")
        self.said.append(value)
        self.unreadable += self.chip.power.system_hz != CLOCK_HZ
        if not self.instant:
            start = max(self.chip.now, self.silent)
            self.starts.append(start)
            self.silent = start + self.byte_cycles()


class Watchdog(Block):
    """The independent watchdog, with the slowest oscillator that the data sheet allows."""

    CYCLES = round(CLOCK_HZ / 29.5e3)  # data sheet, table 44, over all temperatures and supplies; typically 32 kHz
    SETTLING = 5                         # of its cycles, until a new length is taken
    UNCERTAIN = 1                        # table 79: such a cycle more, by the phase of the two clocks

    def __init__(self, chip):
        self.chip = chip
        self.due = NEVER
        self.unlocked = False
        self.settled = 0
        self.settling = self.SETTLING
        super().__init__("IWDG", 0x40003000, {
            "KR": (0x00, Register(0, 0xFFFF, on_write=self._key)),
            "PR": (0x04, Register(0, 7, on_write=lambda value: self._set("PR", value))),
            "RLR": (0x08, Register(0xFFF, 0xFFF, on_write=lambda value: self._set("RLR", value))),
            "SR": (0x0C, Register(0, 0, lambda: 3 if self.chip.now < self.settled else 0)),
        })

    def fire(self):
        raise WatchdogBites

    def _key(self, value):
        need(value in (0xAAAA, 0x5555, 0xCCCC), f"{value:#x} is no key of the watchdog")
        self.unlocked = value == 0x5555
        if value == 0xCCCC or (value == 0xAAAA and self.due != NEVER):
            self.due = self.chip.now + ((self["RLR"] + 1) * (4 << self["PR"]) + self.UNCERTAIN) * self.CYCLES

    def _set(self, key, value):
        need(self.unlocked, f"IWDG_{key} is written while it is locked")
        self.settled = self.chip.now + self.settling * self.CYCLES
        self[key] = value


class WatchdogBites(Exception):
    """The chip is reset."""


class System(Block):
    """SysTick, interrupt controller and system control of the core. `conversions`: {exception: the converters that ask for
    it}."""

    NMI = 2
    SYSTICK = 15
    DEVICE = 16  # the exception of interrupt 0

    def __init__(self, chip, conversions):
        self.chip = chip
        self.conversions = conversions
        self.due = NEVER
        self.fired = 0  # when it was due last
        self.pending = False
        self.handled = 0  # the exception whose handler runs; set by core.py
        interrupts = [exception - self.DEVICE for exception in conversions]
        super().__init__("SYSTEM", 0xE000E000, {
            "SYST_CSR": (0x010, Register(0, 7, self._read_status, self._start)),
            "SYST_RVR": (0x014, Register(0, 0xFFFFFF)),
            "SYST_CVR": (0x018, Register(0, on_write=self._restart)),
            **self._controller(sorted({interrupt // 32 for interrupt in interrupts})),
            **{f"NVIC_IPR{interrupt // 4}": (0x400 + 4 * (interrupt // 4), Register(0, 0xF0F0F0F0)) for interrupt in interrupts},
            "SCB_ICSR": (0xD04, Register(0, 0, lambda: self.handled)),
            "SCB_VTOR": (0xD08, Register(0, 0xFFFFFF80)),
            "SCB_SHPR3": (0xD20, Register(0, 0xF0F00000)),
        })

    def _controller(self, words):
        """Of 32 interrupts each."""
        found = {}
        for word in words:
            found[f"NVIC_ISER{word}"] = (0x100 + 4 * word, Register(on_write=self._enabler(word)))
            found[f"NVIC_ICER{word}"] = (0x180 + 4 * word, Register(on_read=lambda word=word: self[f"NVIC_ISER{word}"],
                                                                   on_write=self._disabler(word)))
            found[f"NVIC_ICPR{word}"] = (0x280 + 4 * word, Register(on_write=self._forgetter(word)))
        return found

    def _enabler(self, word):
        def enable(value):
            self[f"NVIC_ISER{word}"] |= value
        return enable

    def _disabler(self, word):
        def disable(value):
            self[f"NVIC_ISER{word}"] &= ~value
        return disable

    def _forgetter(self, word):
        """A converter's request is a level, and stays until it is acknowledged there."""
        allowed = [1 << exception - self.DEVICE - 32 * word for exception in self.conversions
                   if (exception - self.DEVICE) // 32 == word]

        def forget(value):
            need(value in allowed, "another interrupt than a converter's is forgotten")
        return forget

    def fire(self):
        """Without its interrupt nothing happens again until the flag has been read."""
        self["SYST_CSR"] |= 1 << 16
        if bit(self["SYST_CSR"], 1):
            self.pending = True
            self.due += self._period()
        else:
            self.fired, self.due = self.due, NEVER

    def priority(self, exception):
        """The lower, the more urgent."""
        if exception == self.SYSTICK:
            return self["SCB_SHPR3"] >> 24
        if exception == self.NMI:
            return -2
        interrupt = exception - self.DEVICE
        return self[f"NVIC_IPR{interrupt // 4}"] >> 8 * (interrupt % 4) & 0xFF if exception in self.conversions else 0

    def _asks(self, exception):
        """Whether a converter's interrupt is enabled and wanted."""
        interrupt = exception - self.DEVICE
        return bit(self[f"NVIC_ISER{interrupt // 32}"], interrupt % 32) and any(
            converter.wants_interrupt() for converter in self.conversions[exception])

    def stretch(self, factor):
        """Another speed of the clock."""
        if self.due != NEVER:
            self.due = self.chip.now + round((self.due - self.chip.now) * factor)

    def first(self, above):
        """The exception that interrupts what has the priority `above`, or None."""
        waiting = [exception for exception in self.conversions if self._asks(exception)]
        waiting += [self.SYSTICK] if self.pending else []
        waiting += [self.NMI] if self.chip.power.asks_for_nmi() else []
        most = min(waiting, key=self.priority, default=None)
        return most if most is not None and self.priority(most) < above else None

    def take(self, above):
        """The same, which is no longer pending."""
        exception = self.first(above)
        if exception == self.SYSTICK:
            self.pending = False
        return exception

    def _start(self, value):
        need(not bit(value, 0) or bit(value, 2), "SysTick counts another clock")
        self["SYST_CSR"] = value
        self.due = self.chip.now + self._period() if bit(value, 0) else NEVER

    def _period(self):
        return (self["SYST_RVR"] + 1) * self.chip.clock.cycle

    def _restart(self, _):
        self["SYST_CSR"] &= ~(1 << 16)
        if bit(self["SYST_CSR"], 0):
            self.due = self.chip.now + self._period()

    def _read_status(self):
        value = self.register("SYST_CSR").value
        self["SYST_CSR"] &= ~(1 << 16)
        if bit(value, 0) and self.due == NEVER:
            self.due = self.fired + self._period() * ((self.chip.now - self.fired) // self._period() + 1)
            self.chip.look_again()
        return value


class Configuration(Block):
    """System configuration: what else is a break of the timers. RM0440 10.2.8: what is set there stays until reset."""

    CORE, PARITY, SUPPLY = 1 << 0, 1 << 1, 1 << 2
    PARITY_FLAG = 1 << 8

    def __init__(self, chip, clocked):
        self.chip = chip
        super().__init__("SYSCFG", 0x40010000, {"CFGR2": (0x1C, Register(0, 0x107, on_write=self._write))}, clocked)

    def _write(self, value):
        flag = self["CFGR2"] & ~value & self.PARITY_FLAG
        self["CFGR2"] = (self["CFGR2"] | value) & 7 | flag

    def fail(self, source):
        """The RAM's parity is wrong, or the supply sinks; a wrong parity is an NMI, too, and leaves a flag."""
        if source == self.PARITY:
            self["CFGR2"] |= self.PARITY_FLAG
        if self["CFGR2"] & source:
            self.chip.timer.break_by_system()


class Pace(Block):
    """TIM16, which captures each eighth edge of the crystal's clock divided by 32, or of the watchdog's oscillator. The
    frequency of the latter is that at the speed that the clock should have: a clock that is too fast sees it slower."""

    CAPTURE = 0xD  # CCMR1: input 1, each eighth edge

    def __init__(self, chip):
        self.chip = chip
        self.oscillator_hz = 32e3  # 0: it stands still
        self.sources = {g4.HSE_32: chip.power.crystal_32_hz, g4.LSI: lambda: self.oscillator_hz}
        self.last = 0  # the time of the last capture
        self.captured = self.missed = False
        self.latched = 0               # the count at the last capture
        self.since, self.counted = 0, 0  # the count at a time, from which it goes on at the present speed
        super().__init__("TIM16", chip.facts.base("TIM16"), {
            "CR1": (0x00, Register(0, 1, on_write=self._start)),
            "SR": (0x10, Register(0, on_read=self._status, on_write=self._acknowledge)),
            "CCMR1": (0x18, Register(0, 0xFF)),
            "CCER": (0x20, Register(0, 1)),
            "CCR1": (0x34, Register(0, 0, self._take)),
            "TISEL": (0x5C, Register(0, 0xF)),
        }, chip.power.enabled("TIM16"))

    def source_hz(self):
        return self.sources[self["TISEL"]]()

    def _start(self, value):
        if value and not self["CR1"]:
            need(self["TISEL"] in self.sources and (self["CCMR1"], self["CCER"]) == (self.CAPTURE, 1),
                 "TIM16 does not capture each eighth edge of an oscillator")
            self.last = self.since = self.chip.now
        self["CR1"] = value

    def _count(self, time):
        return self.counted + (time - self.since) * self.chip.power.system_hz / CLOCK_HZ

    def settle(self):
        """Before the clock gets another speed."""
        self._pass()
        self.counted, self.since = self._count(self.chip.now), self.chip.now

    def _pass(self):
        hz = self.source_hz() if self["CR1"] else 0
        if not hz:
            self.last = self.chip.now
            return
        period = 8 * CLOCK_HZ / hz
        while self.last + period <= self.chip.now:
            self.last += period
            self.missed = self.missed or self.captured
            self.captured = True
            self.latched = self._count(self.last)

    def _status(self):
        self._pass()
        return self.captured << 1 | self.missed << 9

    def _acknowledge(self, value):
        self.missed = self.missed and bool(bit(value, 9))

    def _take(self):
        self._pass()
        self.captured = False
        return round(self.latched) & 0xFFFF


class Crc(Block):
    """The CRC unit with its polynomial of reset, in the order that makes it zlib's: RM0440 16.4."""

    def __init__(self, clocked):
        self.fed = bytearray()
        super().__init__("CRC", 0x40023000, {
            "DR": (0x00, Register(on_read=self._result, on_write=self._feed)),
            "CR": (0x08, Register(0, 0xF9, on_write=self._control)),
        }, clocked)

    def _feed(self, value):
        self.fed += value.to_bytes(4, "little")

    def _result(self):
        need(self["CR"] == 0xE0, "the CRC unit has another order of bits")
        return zlib.crc32(self.fed) ^ 0xFFFFFFFF

    def _control(self, value):
        if bit(value, 0):
            self.fed.clear()
        self["CR"] = value & ~1


def debug_block():
    """What stops while a debugger holds the core."""
    return Block("DBGMCU", 0xE0042000, {
        "APB1FZR1": (0x08, Register(0, 1 << 12)),
        "APB2FZ": (0x10, Register(0, 1 << 11)),
    })
