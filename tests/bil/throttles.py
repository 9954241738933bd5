# SPDX-License-Identifier: MIT
"""What moves the throttle of an emulated board.

A throttle stands at `wanted`, 0 to 1. `lost` is how its line has died, one of its LOSSES, or None. feed() comes before each
control tick, and disturb() in its place draws what a sound line bears and a bad one does.
"""

import random

import digital
from probed import ONE, ZERO, dshot_frame

LOW, HIGH = 0.05, 0.95  # of the converter's full scale, input.voltage_low_pct and _high_pct
FULL_COUNT = 4096


class Throttle:
    def __init__(self, board, ticks_per_s):
        self.board, self.ticks_per_s = board, ticks_per_s
        self.wanted, self.lost = 0.0, None
        self.draw = random.Random(1)


class Potentiometer(Throttle):
    kind = "voltage"
    LOSSES = ("open", "shorted")
    REASONS = ("its voltage is below its range", "its voltage is above its range")
    STEPS = (HIGH - LOW) * FULL_COUNT  # of the way from no to full throttle
    SPIKE_TICKS, SPIKES_APART = 200, 2400  # a wiper that jumps: 10 ms long, 120 ms apart at least

    spike = 0  # ticks since the last one began

    def feed(self):
        share = LOW + (HIGH - LOW) * self.wanted
        counts = {None: round(share * FULL_COUNT), "open": 0, "shorted": FULL_COUNT - 1}
        self._set(counts[self.lost])

    def _set(self, count):
        self.board.chip.set_pins(**{self.board.wiring.throttle: min(max(count, 0), FULL_COUNT - 1)})

    def disturb(self):
        """Noise of 10 counts, and the wiper jumps."""
        self.feed()
        if self.lost is None:
            self._set(self.board.chip.pins[self.board.wiring.throttle] + self.draw.randrange(-10, 11))
        self.spike += 1
        if self.spike > self.SPIKES_APART and self.draw.random() < 0.001:
            self.spike, self.jump = 0, self.draw.randrange(FULL_COUNT)
        if self.lost is None and 0 < self.spike <= self.SPIKE_TICKS and hasattr(self, "jump"):
            self._set(self.jump)


class Pulses(Throttle):
    next = 0  # ticks to the next command

    def send(self, pulses):
        """(start, width) in seconds from now."""
        now = self.board.chip.now
        self.board.chip.signals.play(self.board.wiring.pulse.name, [
            (now + round(at * digital.CLOCK_HZ), level) for start, width in pulses for at, level in ((start, 1), (start + width, 0))])

    def feed(self):
        self._feed(self.command)

    def disturb(self):
        self._feed(self.disturbed)

    def _feed(self, command):
        self.next -= 1
        if self.next < 0:
            self.next += round(self.ticks_per_s / self.rate_hz)
            if self.lost is None:
                self.send(command())
            elif self.lost == "wrong":
                self.send(self.wrong())
        elif self.lost == "noise" and self.draw.random() < 0.3:
            self.send([(self.draw.uniform(1e-6, 20e-6), self.draw.uniform(1e-6, 25e-6))])
        if self.lost == "high" and self.next < self.ticks_per_s / self.rate_hz / 2:  # the last command has ended
            self.board.chip.signals.set(self.board.wiring.pulse.name, 1)


class Receiver(Pulses):
    """A servo tester: 1 to 2 ms, 50 Hz."""

    kind = "rc_pulse"
    LOSSES = ("off", "high", "noise", "wrong")
    REASONS = ("no signal", "its pulses have wrong widths or periods")
    STEPS = 1e-3 * 1e7  # of HAL_PULSE_HZ
    rate_hz = 50
    START_S = 1e-4

    def command(self):
        return [(self.START_S, 1e-3 + 1e-3 * self.wanted)]

    def wrong(self):
        """Pulses that are no servo pulses."""
        return [(self.START_S, self.draw.choice((0.5e-3, 2.5e-3)))]

    def disturbed(self):
        """2 µs of jitter; now and then a pulse is missing, torn in two, or has another width."""
        (start, width), = self.command()
        start, width = start + self.draw.uniform(0, 2e-6), width + self.draw.uniform(-2e-6, 2e-6)
        what = self.draw.randrange(20)
        torn = [(start, 0.3 * width), (start + 0.5 * width, 0.5 * width)]
        return {0: [], 1: torn, 2: [(start, self.draw.uniform(0.8e-3, 2.2e-3))]}.get(what, [(start, width)])


class FlightController(Pulses):
    """DShot300."""

    kind = "dshot"
    LOSSES = ("off", "high", "noise", "wrong")
    REASONS = ("no signal", "its pulses have wrong widths or periods", "its checksums are wrong",
               "it is inverted, as bidirectional DShot, which is not supported")
    STEPS = 2000
    rate_hz = 1000
    BIT_S = 1 / 300e3

    def frame(self):
        return dshot_frame(47 + max(1, round(self.STEPS * self.wanted)) if self.wanted else 0)

    def pulses(self, frame, jitter=0.0):
        """`jitter`: of each edge, of a bit's time."""
        def moved():
            return self.draw.uniform(-jitter, jitter) * self.BIT_S if jitter else 0.0
        return [(1e-5 + k * self.BIT_S + moved(), (ONE if frame >> 15 - k & 1 else ZERO) * self.BIT_S + moved()) for k in range(16)]

    def command(self):
        return self.pulses(self.frame())

    def wrong(self):
        """A checksum that differs in one bit."""
        return self.pulses(self.frame() ^ 1)

    def disturbed(self):
        """A jitter of 5 %; now and then a frame is missing, cut off, or has some other bits."""
        what = self.draw.randrange(200)
        frame = self.frame() ^ (self.draw.randrange(1 << 16) if what == 2 else 0)
        pulses = self.pulses(frame, jitter=0.05)
        return {0: [], 1: pulses[:self.draw.randrange(16)]}.get(what, pulses)


ALL = (Potentiometer, Receiver, FlightController)
