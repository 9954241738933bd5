# SPDX-License-Identifier: MIT
"""Levels at the pins of a board, and models of what an STM32G4 makes of them: timers 2 to 4, DMA, SPI.

Facts from the reference manual RM0440. Time counts cycles of the 170 MHz clock.
"""

import heapq
import itertools

from core import NEVER
from registers import Block, Register, bit, need

# Cycles that a level has to last to pass a timer's input, by ICF: samples, times what the sampling clock is divided by. RM0440
# 29.5.7. fDTS is the timer's clock.
INPUT_FILTER = (0, 2, 4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 128, 160, 192, 256)
CAPTURE, PARTNER = 1, 2  # CCS: the channel's own input, or that of its pair
ENCODER_3 = 3            # SMS: each edge of both inputs counts
RESET_BY_EDGES = 0x44    # TS and SMS: each edge of input 1 sets the counter to 0
ORDER = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}  # of the levels of inputs 1 and 2, as the counter goes up


class Signals:
    """What others drive at the pins. A pin that nobody drives has the level of its resistor."""

    def __init__(self, chip):
        self.chip = chip
        self.levels = {}
        self.listeners = []
        self._waiting = []
        self._order = itertools.count()  # of what comes at one time
        self.due = NEVER

    def set(self, pin, level):
        """0, 1, or None: an open wire."""
        self.levels[pin] = level
        for listener in self.listeners:
            listener.look()

    def play(self, pin, edges):
        """(time, level) of each edge, at times to come."""
        for time, level in edges:
            need(time >= self.chip.now, "a signal of the past")
            heapq.heappush(self._waiting, (time, next(self._order), pin, level))
        self.due = self._waiting[0][0] if self._waiting else NEVER

    def fire(self):
        _, _, pin, level = heapq.heappop(self._waiting)
        self.due = self._waiting[0][0] if self._waiting else NEVER
        self.set(pin, level)


class Input:
    """An input of a timer, behind its filter."""

    def __init__(self, pins):
        self.pins = pins  # of this signal, each with its alternate function
        self.raw = self.level = 0
        self.due = NEVER


class GeneralTimer(Block):
    """Timer 2, 3 or 4: captures, the counter of an incremental encoder, the time since an edge of Hall signals. `request` is called
    with the number of a DMA request."""

    def __init__(self, chip, name, clocked, request):
        self.chip = chip
        self.request = request
        self.requests = chip.facts.requests(name)
        self.bits = 0xFFFFFFFF if name == "TIM2" else 0xFFFF
        self.inputs = [Input(chip.facts.pins_of(f"{name}_CH{channel}")) for channel in range(1, 5)]
        self.due = NEVER
        self.divider = 1                # behind the preload of the prescaler
        self.since, self.counted = 0, 0  # the count at a time, from which it goes on
        self.held = None                 # the count that a test has set instead
        super().__init__(name, chip.facts.base(name), {
            "CR1": (0x00, Register(0, 1, on_write=self._start)),
            "CR2": (0x04, Register(0, 1 << 7, on_write=self._stopped("CR2"))),
            "SMCR": (0x08, Register(0, 0x77, on_write=self._stopped("SMCR"))),
            "DIER": (0x0C, Register(0, 0x1E00)),
            "SR": (0x10, Register(on_write=self._acknowledge)),
            "EGR": (0x14, Register(0, 1, on_write=self._generate)),
            "CCMR1": (0x18, Register(0, 0xF3F3, on_write=self._stopped("CCMR1"))),
            "CCMR2": (0x1C, Register(0, 0xF3F3, on_write=self._stopped("CCMR2"))),
            "CCER": (0x20, Register(0, 0xBBBB)),
            "CNT": (0x24, Register(0, 0, self.count)),
            "PSC": (0x28, Register(0, 0xFFFF)),
            "ARR": (0x2C, Register(self.bits, self.bits)),
            **{f"CCR{channel}": (0x30 + 4 * channel, Register(0, 0, self._taker(channel))) for channel in range(1, 5)},
        }, clocked)

    def _stopped(self, key):
        def write(value):
            need(not bit(self["CR1"], 0), f"{self.name}_{key} is written while the timer runs")
            self[key] = value
        return write

    def _start(self, value):
        self.settle()
        self["CR1"] = value
        self.look()

    def _generate(self, value):
        if bit(value, 0):
            self.divider = self["PSC"] + 1
            self.since, self.counted = self.chip.now, 0
            self["SR"] |= 1

    def _acknowledge(self, value):
        self["SR"] &= value

    def is_encoder(self):
        return self["SMCR"] == ENCODER_3

    def is_reset_by_edges(self):
        return self["SMCR"] == RESET_BY_EDGES

    def count(self):
        if self.held is not None:
            return self.held
        passed = 0 if self.is_encoder() or not bit(self["CR1"], 0) else \
            (self.chip.now - self.since) // (self.divider * self.chip.power.cycle)
        return (self.counted + passed) % (self["ARR"] + 1)

    def settle(self):
        """Before the clock gets another speed."""
        self.counted, self.since = self.count(), self.chip.now

    def _taker(self, channel):
        def take():
            self["SR"] &= ~(1 << channel)
            return self.register(f"CCR{channel}").value
        return take

    def _mode(self, channel):
        """CCS and ICF of a channel."""
        code = self["CCMR1" if channel < 3 else "CCMR2"] >> 8 * (1 - channel % 2)
        return code & 3, code >> 4 & 0xF

    def _level(self, pins):
        return any(self.chip.signal_level(pin.name) for pin in pins if self.chip.has_function(pin))

    def look(self):
        """A pin may have another level or another function."""
        levels = [int(self._level(source.pins)) for source in self.inputs]
        if bit(self["CR2"], 7):
            levels[0] ^= levels[1] ^ levels[2]
        for number, (source, raw) in enumerate(zip(self.inputs, levels), start=1):
            if raw != source.raw:
                source.raw = raw
                wait = INPUT_FILTER[self._mode(number)[1]] * self.chip.power.cycle
                source.due = NEVER if raw == source.level else self.chip.now + wait
        self.due = min(source.due for source in self.inputs)
        if self.due <= self.chip.now:
            self.fire()

    def fire(self):
        for number, source in enumerate(self.inputs, start=1):
            if source.due <= self.chip.now:
                source.due = NEVER
                self._pass(number, source)
        self.due = min(source.due for source in self.inputs)

    def _pass(self, number, source):
        """A level has passed the filter of its input."""
        before = (self.inputs[0].level, self.inputs[1].level)
        source.level = source.raw
        if not self.clocked() or not bit(self["CR1"], 0):
            return
        if number < 3 and self.is_encoder():
            self._turn(before, (self.inputs[0].level, self.inputs[1].level))
        if number == 1 and self.is_reset_by_edges():
            need(self._mode(1)[0] == CAPTURE, f"{self.name} has no filter at its input")
            self.since, self.counted = self.chip.now, 0
        partner = number + 1 if number % 2 else number - 1
        for channel, chosen in ((number, CAPTURE), (partner, PARTNER)):
            self._capture(channel, chosen, source.level)

    def _turn(self, before, levels):
        need(all(self._mode(channel)[0] == CAPTURE for channel in (1, 2)), f"{self.name} counts what is not its inputs")
        need(self["CCER"] & 0xAA == 0, f"{self.name} counts inverted inputs")
        step = 1 if (ORDER[levels] - ORDER[before]) % 4 == 1 else -1
        self.counted = (self.counted + step) % (self["ARR"] + 1)

    def _capture(self, channel, chosen, level):
        enable = self["CCER"] >> 4 * (channel - 1)
        if not bit(enable, 0) or self._mode(channel)[0] != chosen:
            return
        inverted, both = bit(enable, 1), bit(enable, 1) and bit(enable, 3)
        if not both and level == inverted:
            return
        if bit(self["SR"], channel):
            self["SR"] |= 1 << 8 + channel
        self[f"CCR{channel}"] = self.count()
        self["SR"] |= 1 << channel
        if bit(self["DIER"], 8 + channel):
            self.request(self.requests[f"CH{channel}"])


class Multiplexer(Block):
    """DMAMUX1: which request a channel of DMA1 obeys. Its channels count from 0."""

    def __init__(self, chip, channels, clocked):
        super().__init__("DMAMUX1", chip.facts.base("DMAMUX1"),
                         {f"C{channel}CR": (4 * channel, Register(0, 0x7F)) for channel in range(channels)}, clocked)


class Dma(Block):
    """DMA1: words from a register into memory. A request is obeyed at once, or when it no longer stands still."""

    CHANNELS = 2
    RING = 1 << 0 | 1 << 5 | 1 << 7 | 2 << 8 | 2 << 10  # enabled, circular, the next word in memory; words both ways

    def __init__(self, chip, clocked, multiplexer_clocked):
        self.chip = chip
        self.stands = False
        self.waiting = set()  # requests
        self.multiplexer = Multiplexer(chip, self.CHANNELS, multiplexer_clocked)
        self.sizes = [0] * self.CHANNELS
        registers = {}
        for number in range(1, self.CHANNELS + 1):
            at = 0x14 * (number - 1)
            registers |= {f"CCR{number}": (0x08 + at, Register(0, 0x7FFF, on_write=self._enabler(number))),
                          f"CNDTR{number}": (0x0C + at, Register(0, 0xFFFF, on_write=self._closed("CNDTR", number))),
                          f"CPAR{number}": (0x10 + at, Register(on_write=self._closed("CPAR", number))),
                          f"CMAR{number}": (0x14 + at, Register(on_write=self._closed("CMAR", number)))}
        super().__init__("DMA1", chip.facts.base("DMA1"), registers, clocked)

    def _closed(self, key, number):
        def write(value):
            need(not bit(self[f"CCR{number}"], 0), f"DMA1_{key}{number} is written while the channel is enabled")
            self[f"{key}{number}"] = value
        return write

    def _enabler(self, number):
        def write(value):
            if bit(value, 0):
                need(value == self.RING, f"channel {number} of DMA1 does not fill a ring of words")
                need(self[f"CNDTR{number}"] > 0, f"channel {number} of DMA1 is enabled for no transfers")
                self.sizes[number - 1] = self[f"CNDTR{number}"]
            self[f"CCR{number}"] = value
        return write

    def stand(self, stands):
        """It does not get the bus, or gets it again."""
        self.stands = stands
        waiting, self.waiting = self.waiting, set()
        for request in sorted(waiting):
            self.request(request)

    def request(self, request):
        if self.stands:
            self.waiting.add(request)
            return
        for number in range(1, self.CHANNELS + 1):
            obeys = self.clocked() and self.multiplexer.clocked() and self.multiplexer[f"C{number - 1}CR"] == request
            if obeys and bit(self[f"CCR{number}"], 0):
                self._transfer(number)

    def _transfer(self, number):
        left, size = self[f"CNDTR{number}"], self.sizes[number - 1]
        word = self.chip.bus.read(self[f"CPAR{number}"], 4)
        self.chip.write_memory(self[f"CMAR{number}"] + 4 * (size - left), word)
        self[f"CNDTR{number}"] = left - 1 or size


class Spi(Block):
    """A master without a pin for the choice of its slave, and a slave. Frames of 16 bits."""

    WIDTH = 16
    ROOM = 2  # frames that were received
    MODE_1 = 1
    MASTER = 1 << 2 | 1 << 8 | 1 << 9  # MSTR, SSI, SSM
    ON = 1 << 6

    def __init__(self, chip, name, slave, clocked):
        self.chip = chip
        self.slave = slave
        self.due = NEVER
        self.sending = 0
        self.received = []
        self.overrun = False
        super().__init__(name, chip.facts.base(name), {
            "CR1": (0x00, Register(0, 0xFFFF, on_write=self._set)),
            "CR2": (0x04, Register(0x700, 0x7FFF)),
            "SR": (0x08, Register(2, 0, self._status)),
            "DR": (0x0C, Register(0, 0xFFFF, self._take, self._send)),
        }, clocked)

    def _set(self, value):
        if value & self.ON:
            need(value & ~(7 << 3) == self.MASTER | self.ON | self.MODE_1, f"{self.name} is no master in mode 1")
            need(self["CR2"] == 0xF00, f"{self.name} has no frames of 16 bits")
        self["CR1"] = value

    def cycles(self):
        """Of a bit."""
        return (2 << (self["CR1"] >> 3 & 7)) * self.chip.power.cycle

    def _send(self, value):
        need(self["CR1"] & self.ON, f"{self.name} sends and is off")
        need(self.due == NEVER, f"{self.name} sends while it sends")
        self.sending = value
        self.slave.start(self.cycles())
        self.due = self.chip.now + self.WIDTH * self.cycles()

    def fire(self):
        self.due = NEVER
        answer = self.slave.answer(self.sending)
        self.overrun = self.overrun or len(self.received) == self.ROOM
        if not self.overrun:
            self.received.append(answer)

    def _status(self):
        return bool(self.received) | 2 | self.overrun << 6 | (self.due != NEVER) << 7

    def _take(self):
        return self.received.pop(0) if self.received else 0


class AbsoluteEncoder:
    """An AS5047D: it samples at the rising edge of its chip select, and sends that in the next frame. Data sheet, SPI."""

    SELECT_CYCLES = round(350e-9 * 170e6)  # high between two frames, and low before the clock
    PERIOD_CYCLES = round(100e-9 * 170e6)  # of the clock, at least
    READ, ANGLE, ERRORS = 1 << 14, 0x3FFF, 0x0001
    DEAD, STUCK = "dead", "stuck"

    def __init__(self, chip, select, miso):
        self.chip = chip
        self.select, self.miso = select, miso
        self.angle = 0       # of 16384
        self.state = None    # DEAD: it drives nothing; STUCK: it pulls MISO low
        self.flip = 0        # bits that the wires turn over
        self.level = None
        self.changed = -NEVER
        self.response = 0    # to what was asked last
        self.asked = None
        self.error = False
        self.frames = []     # that it has sent, with the time at which the angle was sampled
        self.sampled = 0
        self.sending = False

    def look(self):
        """Its chip select may have another level."""
        level = self.chip.pin_level(self.select)
        if level == self.level:
            return
        need(not self.sending, "the chip select of the encoder rises within a frame")
        if level == 1 and self.asked is not None:
            self._obey()
        if level == 0:
            need(self.level is None or self.chip.now - self.changed >= self.SELECT_CYCLES,
                 f"the chip select of the encoder is high for {self.chip.now - self.changed} cycles only")
        self.level, self.changed = level, self.chip.now

    def _obey(self):
        command, self.asked = self.asked, None
        wrong = command.bit_count() % 2 or not command & self.READ or command & 0x3FFF not in (self.ANGLE, self.ERRORS)
        if command & 0x3FFF == self.ERRORS and not wrong:
            value, self.error = int(self.error), False
        else:
            value = 0 if wrong else self.angle
        self.error = self.error or bool(wrong)
        frame = value | self.error << 14
        self.response = frame | (frame.bit_count() % 2) << 15
        self.sampled = self.chip.now

    def start(self, cycles):
        need(self.level == 0 and self.chip.now - self.changed >= self.SELECT_CYCLES,
             "the clock of the encoder starts too early behind its chip select")
        need(cycles >= self.PERIOD_CYCLES, f"the clock of the encoder has {cycles} cycles")
        need(self.asked is None, "a frame of the encoder follows another without its chip select")
        self.sending = True

    def answer(self, command):
        self.sending = False
        self.asked = command
        if self.state is None:
            self.frames.append((self.response, self.sampled))
            return self.response ^ self.flip
        pulled_up = self.chip.resistor(self.miso) == 1
        return 0 if self.state == self.STUCK or not pulled_up else 0xFFFF
