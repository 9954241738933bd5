# SPDX-License-Identifier: MIT
"""The B-G431B-ESC1: an image on an emulated Cortex-M4 with models of all that it touches.

The models keep the time, in cycles of the 170 MHz clock: instructions (core.py) and accesses to registers take theirs, and
the rest goes by while the core sleeps.
"""

import tomllib

import analogue
import digital
from core import NEVER, THREAD, Clock, Core
from registers import Block, Register, WrongAccess

SLOW_TICKS = 10  # of every tuning
TAKING_TICK = 6  # of a slow period: its seventh tick reads the command, see schedule.h
WATCHDOG_FLAG = 1 << 29
PIN_FLAG = 1 << 26
COLD_ROOM_COUNT = 4096 * 4.7 / (4.7 + 10)  # 25 °C: an NTC of 10 kΩ above 4.7 kΩ


class Chip:
    """All that the core sees beside its memories. `parts` are what this one of many has for tolerances."""

    def __init__(self, reset_flags, parts, baud):
        self.clock = Clock()
        self.held = NEVER  # what is due then or later has to wait
        self.pins = {"PA1": 0.0, "PA7": 0.0, "PB0": 0.0, "PA0": 0.0, "PB14": COLD_ROOM_COUNT}
        self.power = power = digital.Power(self, reset_flags)
        system_clock = power.enabled("APB2ENR", 0)
        converter_clock = power.enabled("AHB2ENR", 13)
        self.ports = {
            "A": digital.Port("A", 0x48000000, 0xABFFFFFF, 0x64000000, 0x0C000000,
                              power.enabled("AHB2ENR", 0)),
            "B": digital.Port("B", 0x48000400, 0xFFFFFEBF, 0x00000100, 0,
                              power.enabled("AHB2ENR", 1)),
            "C": digital.Port("C", 0x48000800, 0xFFFFFFFF, 0, 0, power.enabled("AHB2ENR", 2)),
        }
        self.timer = digital.Timer(self, power.enabled("APB2ENR", 11))
        self.usart = digital.Usart(self, baud, power.enabled("APB1ENR1", 17))
        self.watchdog = digital.Watchdog(self)
        self.system = digital.System(self)
        self.pace = digital.Pace(self, power.enabled("APB2ENR", 17))
        self.configuration = digital.Configuration(self, system_clock)
        self.level = analogue.Level(self, power.enabled("AHB2ENR", 18))
        self.comparators = analogue.Comparators(self, parts, system_clock)
        self.amplifiers = analogue.Amplifiers(self, parts, system_clock)
        amplifier = self.amplifiers.output
        self.converters = [
            analogue.Converter(self, "ADC1", 0x50000000, {
                1: lambda: self.pins["PA0"], 3: lambda: amplifier(1, inside=False),
                5: lambda: self.pins["PB14"]}, converter_clock),
            analogue.Converter(self, "ADC2", 0x50000100, {
                3: lambda: amplifier(2, inside=False), 18: lambda: amplifier(3, inside=True)},
                converter_clock),
        ]
        common = Block("ADC12", 0x50000300, {"CCR": (0x08, Register(0, 3 << 16))}, converter_clock)
        self.timer.trigger = self._trigger
        self.timed = [self.timer, self.watchdog, self.system, self.comparators, *self.converters]
        self.blocks = [*power.blocks, *self.ports.values(), self.timer, self.usart, self.watchdog,
                       self.system, self.level, self.comparators, self.amplifiers,
                       *self.converters, common, self.configuration, self.pace,
                       digital.Crc(power.enabled("AHB1ENR", 12)),
                       digital.debug_block()]

    @property
    def now(self):
        return self.clock.now

    def _trigger(self):
        for converter in self.converters:
            converter.trigger()

    def converters_want_interrupt(self):
        return any(converter.wants_interrupt() for converter in self.converters)

    def comparators_changed(self):
        """Outputs to the timer's break input, each by its enable and polarity."""
        selected = self.timer["AF1"]
        active = False
        for number in analogue.COMPARATORS:
            if digital.bit(selected, number):
                output = self.comparators.output(number)
                inverted = bool(digital.bit(selected, 9 + number))
                active |= output is None or output != inverted
        self.timer.set_break_input(active == bool(digital.bit(self.timer["BDTR"], 13)))

    def set_pins(self, **volts):
        self.pins.update(volts)
        self.comparators_changed()

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
        self.clock.now = due
        next(model for model in self.timed if model.due == due).fire()


class Board:
    """The image from its reset vector on. Analogue values are set in counts as the drive takes them.

    `clock_library` is core_clock.c. `choose` takes the parts out of their tolerances (analogue.Parts). With ideal ones a
    count is measured as it was set. `flashed`: (address, bytes) that are in the flash beside the image.
    `kept`: words of the backup registers, as a board has them whose supply stayed.
    """

    def __init__(self, image, board_file, clock_library, reset_flags=PIN_FLAG, choose=analogue.ideal, flashed=(), kept=()):
        board = tomllib.loads(board_file.read_text(encoding="utf-8"))
        hal = board["hal"]
        self.zero = round(hal["amplifier_zero_v"] / hal["adc_reference_v"] * 4096)
        self.sign = -1 if hal["amplifier_gain"] < 0 else 1
        self.gain = hal["pga_gain"]
        self.trip_a = board["board"]["trip_a"]
        self.parts = analogue.Parts(choose)
        self.chip = Chip(reset_flags, self.parts, board["board"]["baud"])
        self.chip.power.backup.words = kept
        self.core = Core(image, self.chip, clock_library, flashed)
        self._stays = False  # the background, where it is

    def boot(self):
        """To the first sleep."""
        self.core.run()

    def set_inputs(self, phase_a, phase_b, bus, temperature=COLD_ROOM_COUNT):
        """What flows into phases a and b comes back out of phase c."""
        phases = (phase_a, phase_b, 3 * 2048 - phase_a - phase_b)
        volts = [(self.zero * self.parts.bias[number] + self.sign * (count - 2048)) / self.gain
                 for number, count in zip(analogue.SHUNT_PINS, phases)]
        self.chip.set_pins(**dict(zip(analogue.SHUNT_PINS.values(), volts)), PA0=bus,
                           PB14=temperature)

    def sensor_errors(self):
        """(offset, gain) of phases a and b: a count c is measured as 2048 + offset + gain · (c − 2048)."""
        return [self._sensor_error(number) for number in (1, 2)]

    def _sensor_error(self, number):
        gain = self.parts.gain[number] if self.gain > 1 else 1
        rest = gain * (self.zero * self.parts.bias[number] + self.parts.amplifier[number] * self.gain)
        return self.sign * (rest - self.zero), gain

    def set_measured(self, phase_a, phase_b, bus, temperature):
        """Currents that are measured so."""
        currents = [2048 + (count - 2048 - offset) / gain
                    for count, (offset, gain) in zip((phase_a, phase_b), self.sensor_errors())]
        self.set_inputs(*currents, bus, temperature)

    @property
    def ticks(self):
        """Control ticks since reset."""
        return self.core.taken.get(digital.System.ADC1_2, 0)

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
            while self.handle_next() != digital.System.ADC1_2:
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
            left = left[self.chip.usart.receive_at_once(left):]
            self.core.asleep = False
            self.core.run()

    def said(self):
        """What the console has said since the last look, once it is silent."""
        while (rest := self.chip.usart.sending_s()) > 0:
            self.go_on(rest)
        if self.chip.usart.instant and not self.core.asleep:
            self.core.run()  # to the end of the pass that is under way
        return self.chip.usart.heard()
