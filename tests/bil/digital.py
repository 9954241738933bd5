# SPDX-License-Identifier: MIT
"""Models of the STM32G431's digital side: clocks, pins, timer, console, watchdog and core peripherals.

Facts from the reference manual RM0440 and the ARMv7-M architecture manual. Time counts cycles of the
170 MHz clock. A model that has something to do at a time holds it in `due` and does it in fire().
"""

import collections
import zlib

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
    """Regulator, flash and clock tree: the step to 170 MHz has to be done in the manual's order."""

    def __init__(self, chip, reset_flags):
        self.chip = chip
        self.chip.clock.cycle = round(CLOCK_HZ / OSCILLATOR_HZ)
        self.pll = Awaited(chip, PLL_LOCK)
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
        self.rcc = Block("RCC", 0x40021000, {
            "CR": (0x00, Register(0x500, 0x01000500, self._control_read, self._control)),
            "CFGR": (0x08, Register(0x5, 0xFF, on_write=self._configure)),
            "PLLCFGR": (0x0C, Register(0x1000, 0x07007FF3, on_write=self._set_pll)),
            "AHB1ENR": (0x48, Register(0x100, 0x1000)),
            "AHB2ENR": (0x4C, Register(0, 0x00052007)),
            "APB1ENR1": (0x58, Register(0, 0x10020400)),
            "APB2ENR": (0x60, Register(0, 0x20801)),
            "CSR": (0x94, Register(reset_flags, 0x00800000, on_write=self._clear_flags)),
        })
        self.backup = Backup(self)
        self.blocks = [self.pwr, self.flash, self.flash.store, self.rcc, self.backup]

    def enabled(self, register, number):
        """A function that says whether a peripheral has its clock."""
        return lambda: bit(self.rcc[register], number)

    def _settling(self):
        return self.regulator.end != NEVER and not self.regulator.look()

    def _set_range(self, value):
        if value != self.pwr["CR5"]:
            self.regulator.start()
        self.pwr["CR5"] = value

    def _control(self, value):
        if bit(value, 24) and not bit(self.rcc["CR"], 24):
            self.pll.start()
        self.rcc["CR"] = value & 0x01000100 | bit(value, 8) << 10

    def _control_read(self):
        self.rcc["CR"] |= (bit(self.rcc["CR"], 24) and self.pll.look()) << 25
        return self.rcc.register("CR").value

    def _set_pll(self, value):
        need(not bit(self.rcc["CR"], 24), "PLLCFGR is written while the PLL runs")
        self.rcc["PLLCFGR"] = value

    def _pll_hz(self):
        value = self.rcc["PLLCFGR"]
        need(value & 3 == 2 and bit(value, 24), "the PLL does not take the internal oscillator")
        vco = 16e6 / ((value >> 4 & 0xF) + 1) * (value >> 8 & 0x7F)
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
        self.chip.clock.cycle = 2 if prescaler == 8 else 1

    def _clear_flags(self, value):
        if bit(value, 23):
            self.rcc["CSR"] = 0

    def runs_at_full_speed(self):
        return self.rcc["CFGR"] & 0xFF == 0xF


class Port(Block):
    """A port of pins."""

    def __init__(self, letter, base, modes, pulls, speeds, clocked):
        self.output = 0
        super().__init__(f"GPIO{letter}", base, {
            "MODER": (0x00, Register(modes)),
            "OSPEEDR": (0x08, Register(speeds)),
            "PUPDR": (0x0C, Register(pulls)),
            "BSRR": (0x18, Register(on_write=self._set)),
            "AFRL": (0x20, Register()),
            "AFRH": (0x24, Register()),
        }, clocked)

    def _set(self, value):
        self.output = self.output & ~(value >> 16) | value & 0xFFFF

    def mode(self, pin):
        return self["MODER"] >> 2 * pin & 3

    def function(self, pin):
        return self["AFRH" if pin > 7 else "AFRL"] >> 4 * (pin % 8) & 0xF


# Cycles of the timer that BKF lets pass: samples that have to be equal, times what the sampling clock is divided by.
BREAK_FILTER = (0, 2, 4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 128, 160, 192, 256)


class Timer(Block):
    """TIM1 as a centre-aligned PWM generator with break. `trigger` is called at each TRGO2."""

    def __init__(self, chip, clocked):
        self.chip = chip
        self.due = NEVER      # the next end of the ramp
        self.active = (0, 0, 0)  # compare values behind the preload registers
        self.repeats = 0
        self.rising = True
        self.trigger = None
        self.broken = False   # level of the break input
        super().__init__("TIM1", 0x40012C00, {
            "CR1": (0x00, Register(0, 0xA1, self._control_read, self._control)),
            "CR2": (0x04, Register(0, 0xF << 20)),
            "SR": (0x10, Register(0, on_write=self._acknowledge)),
            "EGR": (0x14, Register(0, 1, on_write=self._generate)),
            "CCMR1": (0x18, Register(0, 0x7878)),
            "CCMR2": (0x1C, Register(0, 0x7878)),
            "CCER": (0x20, Register(0, 0x555)),
            "CNT": (0x24, Register(0, 0, self.count)),
            "PSC": (0x28, Register(0, 0)),
            "ARR": (0x2C, Register(0xFFFF, 0xFFFF)),
            "RCR": (0x30, Register(0, 0xFFFF)),
            "CCR1": (0x34, Register(0, 0xFFFF)),
            "CCR2": (0x38, Register(0, 0xFFFF)),
            "CCR3": (0x3C, Register(0, 0xFFFF)),
            "BDTR": (0x44, Register(0, 0x000FBFFF, on_write=self._set_break)),
            "AF1": (0x60, Register(1, 0x3C1E, on_write=self._select_break)),
        }, clocked)

    def preloaded(self):
        return self["CCR1"], self["CCR2"], self["CCR3"]

    def next_update(self):
        """When the next update event comes."""
        return self.due + self.repeats * self["ARR"]

    def filter_cycles(self):
        """What is shorter does not pass the break input's filter, RM0440 28.6.20 (BKF)."""
        code = self["BDTR"] >> 16 & 0xF
        return BREAK_FILTER[code]

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
        left = self.due - self.chip.now if bit(self["CR1"], 0) else self["ARR"]
        return self["ARR"] - left if self.rising else left

    def set_break_input(self, active):
        self.broken = active and bool(bit(self["BDTR"], 12))
        if self.broken:
            self["BDTR"] &= ~(1 << 15)
            self["SR"] |= 1 << 7

    def break_by_system(self):
        """RM0440 28.6.5, SBIF."""
        self["SR"] |= 1 << 13
        self["BDTR"] &= ~(1 << 15)

    def fire(self):
        self.due += self["ARR"]
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
            need(self["CCER"] == 0x555, "not all six outputs are on and active high")
            need(self["AF1"] & 0x16 == 0x16, "a comparator does not reach the break input")
            self.due = self.chip.now + self["ARR"]
        self["CR1"] = value & ~0x10

    def _acknowledge(self, value):
        self["SR"] &= value
        self.chip.comparators_changed()

    def _generate(self, value):
        if bit(value, 0):
            self._update()

    def _set_break(self, value):
        old = self["BDTR"]
        locked = 0x000F3CFF if old >> 8 & 3 else 0  # what level 1 keeps, and more: nobody changes it
        need((old ^ value) & locked == 0, "BDTR is locked")
        if bit(value, 15) and not bit(value, 12):
            raise WrongAccess("gates are enabled without a break input")
        self["BDTR"] = value & ~(1 << 15) if self.broken else value
        self.chip.comparators_changed()

    def _select_break(self, value):
        self["AF1"] = value
        self.chip.comparators_changed()


class Usart(Block):
    """USART2 with its FIFOs, at the speed of its line. `instant`: bytes to the PC take no time, where it is not the line
    that is tested: a dump takes some 5 s of it."""

    FIFO = 8
    BITS = 10
    PAUSE = cycles(300e-6)  # silence: the background has come by twice and more

    def __init__(self, chip, baud, clocked):
        self.chip = chip
        self.baud = baud
        self.instant = False
        self.starts = collections.deque()  # when each byte that still waits to be sent leaves the FIFO
        self.silent = -self.PAUSE          # when the last byte will have been sent
        self.said = bytearray()
        self.arriving = collections.deque()  # (when, byte)
        self.received = collections.deque()
        self.broken = set()  # bytes that arrive with a wrong stop bit: the how many-th of all
        self.taken = 0
        self.acknowledged = -1
        self.overrun = False
        super().__init__("USART2", 0x40004400, {
            "CR1": (0x00, Register(0, 0x2000000D, on_write=self._enable)),
            "BRR": (0x0C, Register(0, 0xFFFF)),
            "ISR": (0x1C, Register(on_read=self._status)),
            "ICR": (0x20, Register(0, 0xF, on_write=self._clear)),
            "RDR": (0x24, Register(0, 0, self._take)),
            "TDR": (0x28, Register(0, 0xFF, on_write=self._send)),
        }, clocked)

    def byte_cycles(self):
        return self.BITS * self["BRR"]

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
    """SysTick, interrupt controller and system control of the core."""

    SYSTICK = 15
    ADC1_2 = 16 + 18

    def __init__(self, chip):
        self.chip = chip
        self.due = NEVER
        self.pending = False
        super().__init__("SYSTEM", 0xE000E000, {
            "SYST_CSR": (0x010, Register(0, 7, self._read_status, self._start)),
            "SYST_RVR": (0x014, Register(0, 0xFFFFFF)),
            "SYST_CVR": (0x018, Register(0, on_write=self._restart)),
            "NVIC_ISER0": (0x100, Register(on_write=self._enable)),
            "NVIC_ICER0": (0x180, Register(on_read=lambda: self["NVIC_ISER0"], on_write=self._disable)),
            "NVIC_ICPR0": (0x280, Register(on_write=self._forget)),
            "NVIC_IPR4": (0x410, Register(0, 0xF0F0F0F0)),
            "SCB_VTOR": (0xD08, Register(0, 0xFFFFFF80)),
            "SCB_SHPR3": (0xD20, Register(0, 0xF0F00000)),
        })

    def _enable(self, value):
        self["NVIC_ISER0"] |= value

    def _disable(self, value):
        self["NVIC_ISER0"] &= ~value

    def _forget(self, value):
        """The converters' request is a level, and stays until it is acknowledged there."""
        need(value == 1 << 18, "another interrupt than the converters' is forgotten")

    def fire(self):
        self.due += self._period()
        self["SYST_CSR"] |= 1 << 16
        if bit(self["SYST_CSR"], 1):
            self.pending = True

    def priority(self, exception):
        """The lower, the more urgent."""
        if exception == self.SYSTICK:
            return self["SCB_SHPR3"] >> 24
        return self["NVIC_IPR4"] >> 16 & 0xFF if exception == self.ADC1_2 else 0

    def first(self, above):
        """The exception that interrupts what has the priority `above`, or None."""
        waiting = [self.SYSTICK] if self.pending else []
        if bit(self["NVIC_ISER0"], 18) and self.chip.converters_want_interrupt():
            waiting.append(self.ADC1_2)
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
    """TIM16, which captures each eighth edge of the watchdog's oscillator. Its frequency is that at the speed that the clock should have:
    a clock that is too fast sees it slower."""

    def __init__(self, chip, clocked):
        self.chip = chip
        self.oscillator_hz = 32e3  # 0: it stands still
        self.last = 0              # the time of the last capture
        self.captured = self.missed = False
        super().__init__("TIM16", 0x40014400, {
            "CR1": (0x00, Register(0, 1, on_write=self._start)),
            "SR": (0x10, Register(0, on_read=self._status, on_write=self._acknowledge)),
            "CCMR1": (0x18, Register(0, 0xFF)),
            "CCER": (0x20, Register(0, 1)),
            "CCR1": (0x34, Register(0, 0, self._take)),
            "TISEL": (0x5C, Register(0, 0xF)),
        }, clocked)

    def _start(self, value):
        need((self["TISEL"], self["CCMR1"], self["CCER"]) == (6, 0xD, 1), "TIM16 does not capture each eighth edge of the LSI")
        self["CR1"] = value
        self.last = self.chip.now

    def _pass(self):
        period = 8 * CLOCK_HZ / self.oscillator_hz if self.oscillator_hz and self["CR1"] else NEVER
        while self.last + period <= self.chip.now:
            self.last += period
            self.missed = self.missed or self.captured
            self.captured = True

    def _status(self):
        self._pass()
        return self.captured << 1 | self.missed << 9

    def _acknowledge(self, value):
        self.missed = self.missed and bool(bit(value, 9))

    def _take(self):
        self._pass()
        self.captured = False
        return round(self.last) & 0xFFFF


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
