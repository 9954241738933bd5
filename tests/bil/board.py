# SPDX-License-Identifier: MIT
"""A board with an STM32G4: an image on an emulated Cortex-M4 with models of all that it touches. The board file says which chip
it is, and what is at its pins.

The models keep the time, in cycles of the 170 MHz clock: instructions (core.py) and accesses to registers take theirs, and
the rest goes by while the core sleeps.
"""

import tomllib

import analogue
import digital
import g4
import signals
from core import NEVER, THREAD, Clock, Core
from registers import Block, Register, WrongAccess, bit, need
from wiring import Wiring, port_and_number

SLOW_TICKS = 10  # of every tuning
TAKING_TICK = 6  # of a slow period: its seventh tick reads the command, see schedule.h
WATCHDOG_FLAG = 1 << 29
SOFTWARE_FLAG = 1 << 28
SUPPLY_FLAG = 1 << 27
PIN_FLAG = 1 << 26
COLD_ROOM_COUNT = 4096 * 4.7 / (4.7 + 10)  # 25 °C: an NTC of 10 kΩ above 4.7 kΩ


class Chip:
    """All that the core sees beside its memories. `parts` are what this one of many has for tolerances."""

    def __init__(self, wiring, reset_flags, parts, baud, crystal_hz):
        self.wiring = wiring
        self.facts = wiring.facts
        self.clock = Clock()
        self.held = NEVER  # what is due then or later has to wait
        self.pins = dict.fromkeys(wiring.shunts, 0.0) | {wiring.bus: 0.0, wiring.temperature: COLD_ROOM_COUNT, wiring.throttle: 0.0}
        self.bus = self.memory = None  # of the core
        self.hold = lambda address, value, until=NEVER: None  # without one, each look is made
        self.look_again = lambda: None  # at what is due next
        self.fault_line = 1 - wiring.break_level  # at the break pin, once the gate driver is awake
        self.awake_at = NEVER
        names = [f"ADC{number}" for number in self.facts.numbered("ADC")]
        self.power = digital.Power(self, reset_flags, self._clocked_names(names), crystal_hz)
        self._make_digital(baud, names)
        self._make_analogue(parts)
        self._make_inputs()
        self.timer.trigger = self._trigger
        self.timed = [self.power, self.timer, self.watchdog, self.system, self.comparators, *self.converters,
                      *self.inputs]
        self.blocks = [*self.power.blocks, *self.ports.values(), self.timer, self.usart, self.watchdog,
                       self.system, *self.levels.values(), self.comparators, self.amplifiers,
                       *self.converters, *self._common_blocks(), self.configuration, self.pace,
                       digital.Crc(lambda: bit(self.power.rcc["AHB1ENR"], 12)),
                       digital.debug_block(), *(block for block in self.inputs if isinstance(block, Block)),
                       *([self.dma, self.dma.multiplexer] if self.dma else [])]

    def _clocked_names(self, converters):
        """The peripherals whose clock the image may enable: those with a model."""
        return [*(f"GPIO{letter}" for letter in self.facts.ports()), *converters, *self.wiring.levels, self.wiring.serial,
                "SYSCFG", "TIM1", "TIM16", *self._input_names()]

    def _input_names(self):
        """Of the peripherals behind inputs and sensors of the shaft."""
        pulses = ["TIM2", "DMA1", "DMAMUX1"] if self.wiring.pulse else []
        timers = dict.fromkeys((self.wiring.encoder_timer, self.wiring.hall_timer))
        return pulses + [name for name in (*timers, self.wiring.spi) if name]

    def _make_digital(self, baud, converters):
        facts, enabled = self.facts, self.power.enabled
        self.ports = {letter: digital.Port(letter, facts.base(f"GPIO{letter}"), enabled(f"GPIO{letter}"), self._pins_changed,
                                           self.signal_level)
                      for letter in facts.ports()}
        self.timer = digital.Timer(self, self.wiring, enabled("TIM1"))
        self.usart = digital.Usart(self, self.wiring.serial, baud, enabled(self.wiring.serial))
        self.watchdog = digital.Watchdog(self)
        self.pace = digital.Pace(self)
        self.configuration = digital.Configuration(self, enabled("SYSCFG"))
        lengths = (2,) if len(self.wiring.shunts) == 3 else (1, 2)
        self.converters = [analogue.Converter(self, name, lengths, enabled(name)) for name in converters]
        self.system = digital.System(self, self._conversions())

    def _conversions(self):
        found = {}
        for converter in self.converters:
            found.setdefault(digital.System.DEVICE + self.facts.interrupt(converter.name), []).append(converter)
        return found

    def _make_analogue(self, parts):
        enabled = self.power.enabled
        self.levels = {name: analogue.Level(self, name, enabled(name)) for name in self.wiring.levels}
        self.comparators = analogue.Comparators(self, self.wiring, parts, enabled("SYSCFG"))
        self.amplifiers = analogue.Amplifiers(self, self.wiring, parts, enabled("SYSCFG"))

    def _make_inputs(self):
        """What reads pins; and what the pins are connected to."""
        wiring, enabled = self.wiring, self.power.enabled
        self.signals = signals.Signals(self)
        self.dma = signals.Dma(self, enabled("DMA1"), enabled("DMAMUX1")) if wiring.pulse else None
        self.capture = signals.GeneralTimer(self, "TIM2", enabled("TIM2"), self.dma.request) if wiring.pulse else None
        self.encoder = self.hall = self.absolute = self.spi = None
        if wiring.encoder:
            self.encoder = signals.GeneralTimer(self, wiring.encoder_timer, enabled(wiring.encoder_timer), None)
        if wiring.hall_timer == wiring.encoder_timer:
            self.hall = self.encoder
        elif wiring.hall_timer:
            self.hall = signals.GeneralTimer(self, wiring.hall_timer, enabled(wiring.hall_timer), None)
        if wiring.spi:
            self.absolute = signals.AbsoluteEncoder(self, wiring.select, wiring.spi_pins[1].name)
            self.spi = signals.Spi(self, wiring.spi, self.absolute, enabled(wiring.spi))
        self.signals.listeners = [*dict.fromkeys(timer for timer in (self.capture, self.encoder, self.hall) if timer)]
        self.inputs = [self.signals, *self.signals.listeners, *([self.spi] if self.spi else [])]

    def _pins_changed(self):
        self.driver_is_awake()
        if self.absolute:
            self.absolute.look()
        for timer in self.signals.listeners:
            timer.look()

    def _common_blocks(self):
        """What several converters share."""
        for name, base in (("ADC12", 0x50000300), ("ADC345", 0x50000700)):
            first = f"ADC{name[3]}"
            if self.facts.has(first):
                yield Block(name, base, {"CCR": (0x08, Register(0, 3 << 16))}, self.power.enabled(first))

    @property
    def now(self):
        return self.clock.now

    def _trigger(self):
        for converter in self.converters:
            converter.trigger()

    def input(self, converter, channel):
        """The voltage there, of a pin or of an amplifier."""
        if amplifier := g4.INSIDE.get((converter, channel)):
            return self.amplifiers.output(amplifier, inside=True)
        pin = self.facts.pin_of(f"{converter}_IN{channel}")
        if pin in self.wiring.converted:
            need(not self.amplifiers.drives(pin), f"an amplifier drives {pin}, where the board has a signal")
            return self.pins[pin]
        if amplifier := self.facts.amplifier_at(pin):
            return self.amplifiers.output(amplifier, inside=False)
        raise WrongAccess(f"{converter} converts channel {channel}, where nothing is connected")

    def break_changed(self):
        """The sources of the timer's break input, each by its enable and polarity."""
        selected = self.timer["AF1"]
        active = False
        for number in self.comparators.numbers:
            if bit(selected, number):
                output, inverting = self.comparators.output(number), g4.polarity_bit(number)
                active |= output is None or output != (inverting is not None and bool(bit(selected, inverting)))
        if bit(selected, 0):
            active |= self._break_pin_level() != bit(selected, 9)
        self.timer.set_break_input(active == bool(bit(self.timer["BDTR"], 13)))

    def _break_pin_level(self):
        """Low as long as the pin does not have this function."""
        line = self.wiring.break_line
        if not line or not self.has_function(line):
            return 0
        return self.fault_line if self.driver_is_awake() else self.wiring.break_level

    def driver_is_awake(self):
        """The gate driver: it tells of a fault until its pins have had their levels for as long as it takes to wake up."""
        if any(self.pin_level(pin) != level for pin, level in self.wiring.held.items()):
            self.awake_at = NEVER
        elif self.awake_at == NEVER:
            self.awake_at = self.now + digital.cycles(self.wiring.wake_s)
        return self.now >= self.awake_at

    def has_function(self, pin):
        """Whether a pin of the wiring has its alternate function."""
        letter, number = port_and_number(pin.name)
        return self.ports[letter].mode(number) == 2 and self.ports[letter].function(number) == pin.function

    def pin_level(self, name):
        """What the image makes of an output, or None."""
        letter, number = port_and_number(name)
        return self.ports[letter].level(number)

    def resistor(self, name):
        """The level to which the chip pulls a pin, or None."""
        letter, number = port_and_number(name)
        return {1: 1, 2: 0}.get(self.ports[letter]["PUPDR"] >> 2 * number & 3)

    def signal_level(self, name):
        """Of a pin that the chip or somebody else drives, or that a resistor pulls. An open one floats: 0 here."""
        for level in (self.pin_level(name), self.signals.levels.get(name), self.resistor(name)):
            if level is not None:
                return level
        return 0

    def write_memory(self, address, word):
        """By the DMA."""
        self.memory(address, word)

    def set_fault_line(self, level):
        """The break pin, from outside."""
        self.fault_line = level
        self.break_changed()

    def set_pins(self, **volts):
        self.pins.update(volts)
        self.break_changed()

    def settle(self):
        """Before the clock gets another speed."""
        self.pace.settle()
        for timer in self.signals.listeners:
            timer.settle()

    def stretch(self, factor):
        """Behind that, for what counts the clock and has begun."""
        for model in (self.timer, self.system, *self.converters):
            model.stretch(factor)

    def spike(self, pin, count, seconds):
        """A pin goes to `count` for a time that nothing but the break's filter is short enough to see."""
        if seconds * digital.CLOCK_HZ > self.timer.filter_cycles():
            before = self.pins[pin]
            self.set_pins(**{pin: count})
            self.set_pins(**{pin: before})

    def next_due(self):
        return min([model.due for model in self.timed])

    def advance(self, cycles=0):
        """All that is due up to now, and in so many cycles more."""
        end = self.now + cycles
        while (due := self.next_due()) <= end and due < self.held:
            self._fire(due)
        self.clock.now = end

    def pass_until(self, end):
        """What is due before that."""
        self.held = end
        self.advance(max(end - self.now, 0))
        self.held = NEVER

    def stand_still(self, duration):
        """The core does, and the rest of the chip goes on; also beyond what would have to wait for the core."""
        held, self.held = self.held, NEVER
        self.advance(duration)
        self.held = held

    def wait_for_exception(self):
        while self.system.first(THREAD) is None:
            self.wait()

    def wait(self, until=NEVER):
        """Until the next thing happens, or so long."""
        due = self.next_due()
        if due == NEVER == until:
            raise WrongAccess("the core sleeps, and nothing will ever wake it")
        if due <= until:
            self._fire(due)
        else:
            self.clock.now = until

    def _fire(self, due):
        self.clock.now, self.clock.held = due, 0
        next(model for model in self.timed if model.due == due).fire()


class Board:
    """The image from its reset vector on. Analogue values are set in counts as the drive takes them.

    `clock_library` is core_clock.c. `choose` takes the parts out of their tolerances (analogue.Parts). With ideal ones a
    count is measured as it was set. `flashed`: (address, bytes) that are in the flash beside the image.
    `kept`: words of the backup registers, as a board has them whose supply stayed. `crystal_hz`: another crystal than the board
    file names; 0: it is missing.
    """

    def __init__(self, image, board_file, clock_library, reset_flags=PIN_FLAG, choose=analogue.ideal, flashed=(), kept=(),
                 crystal_hz=None):
        board = tomllib.loads(board_file.read_text(encoding="utf-8"))
        hal = board["hal"]
        self.zero = round(hal["amplifier_zero_v"] / hal["adc_reference_v"] * 4096)
        self.sign = -1 if hal["amplifier_gain"] < 0 else 1
        self.gain = hal["pga_gain"]
        self.pwm_hz = round(board["board"]["pwm_frequency_hz"])
        self.trip_a = board["board"].get("trip_a")  # None: a gate driver has a limit of its own
        self.parts = analogue.Parts(choose)
        self.wiring = Wiring(hal)
        crystal_hz = self.wiring.crystal_hz if crystal_hz is None else crystal_hz
        self.chip = Chip(self.wiring, reset_flags, self.parts, board["board"]["baud"], crystal_hz)
        self.chip.power.backup.words = kept
        self.core = Core(image, self.chip, clock_library, flashed)
        self._stays = False  # the background, where it is

    def level_of(self, phase):
        """(DAC, channel) of a phase's trip level."""
        name, channel = self.wiring.level_of(phase)
        return self.chip.levels[name], channel

    def boot(self):
        """To the first sleep."""
        self.core.run()

    def set_inputs(self, phase_a, phase_b, bus, temperature=COLD_ROOM_COUNT):
        """What flows into phases a and b comes back out of phase c."""
        phases = (phase_a, phase_b, 3 * 2048 - phase_a - phase_b)
        volts = {pin: (self.zero * bias + self.sign * (count - 2048)) / self.gain
                 for pin, bias, count in zip(self.wiring.shunts, self.parts.bias, phases)}
        self.chip.set_pins(**volts | {self.wiring.bus: bus, self.wiring.temperature: temperature})

    def sensor_errors(self):
        """(offset, gain) of phases a and b: a count c is measured as 2048 + offset + gain · (c − 2048)."""
        return [self._sensor_error(phase) for phase in (0, 1)]

    def _sensor_error(self, phase):
        gain = self.parts.gain[phase] if self.gain > 1 else 1
        offset = self.parts.amplifier[phase] if self.chip.facts.amplifiers_of(self.wiring.shunts[phase]) else 0
        rest = gain * (self.zero * self.parts.bias[phase] + offset * self.gain)
        return self.sign * (rest - self.zero), gain

    def set_measured(self, phase_a, phase_b, bus, temperature):
        """Currents that are measured so."""
        currents = [2048 + (count - 2048 - offset) / gain
                    for count, (offset, gain) in zip((phase_a, phase_b), self.sensor_errors())]
        self.set_inputs(*currents, bus, temperature)

    @property
    def ticks(self):
        """Control ticks since reset."""
        return sum(self.core.taken.get(exception, 0) for exception in self.chip.system.conversions)

    def _awake(self, until=NEVER):
        """Whether an exception ends the sleep before that time."""
        while self.core.asleep and self.chip.now < until:
            self.chip.wait(until)
            self.core.asleep = self.chip.system.first(THREAD) is None
        return not self.core.asleep

    def handle_next(self):
        """Goes on until an exception has come, and to its end. Its number."""
        exception = None
        while exception is None:
            self._awake()
            exception = self.core.run(once=True)
        return exception

    def go_on(self, seconds):
        """For so long, with whatever comes."""
        end = self.chip.now + round(seconds * digital.CLOCK_HZ)
        while self.chip.now < end:
            if self._awake(end):
                self.core.run(end)

    def tick(self, ticks=1, background=0):
        """So many control ticks, and each time the background to its sleep, to the next conversion at most; or, if given,
        for so many instructions at most: there the next exception comes upon it."""
        for _ in range(ticks):
            if self._stays:
                self.chip.wait_for_exception()
            while self.handle_next() not in self.chip.system.conversions:
                pass
            self._stays = background > 0
            if background:
                self.core.step(background)
                self.chip.pass_until(self.chip.timer.next_update())
            else:
                self.core.run(self.chip.timer.next_update())

    def tick_to_take(self):
        """To where the next tick takes a command: one in each slow period does."""
        self.tick((TAKING_TICK - self.ticks) % SLOW_TICKS)

    def take(self):
        """A command that has been typed is in force then, and answered by one tick."""
        self.tick_to_take()
        self.tick()

    def tick_to_search(self):
        """To where the next tick asks for the gates, after `run`: the search for a turning rotor waits until its own compare values act."""
        self.take()

    def type(self, line):
        """A line at the console."""
        self.send(f"{line}\r".encode())

    def send(self, left):
        """Bytes as fast as the receiver takes them: a sleep ends for any reason, here for these."""
        if not self.core.asleep:
            self.core.run()  # to the end of the pass that is under way
        while left:
            left = self.send_at_once(left)

    def send_at_once(self, left, until=NEVER):
        """As much as the receiver takes: to the end of the pass for that, or to the time `until`. What is left."""
        left = left[self.chip.usart.receive_at_once(left):]
        self.core.asleep = False
        self.core.run(until)
        return left

    def said(self):
        """What the console has said since the last look, once it is silent."""
        while (rest := self.chip.usart.sending_s()) > 0:
            self.go_on(rest)
        if self.chip.usart.instant and not self.core.asleep:
            self.core.run()  # to the end of the pass that is under way
        return self.chip.usart.heard()
