# SPDX-License-Identifier: MIT
"""The image of probe.c on its board, which writes down what the binding measures; and what one can send to its command pin."""

import random
import struct

import board
import digital
import rig

KEPT = 512         # pulses that the image keeps, probe.c
WORDS = 8          # before them
PULSE_HZ = 10e6    # HAL_PULSE_HZ
UNIT = digital.CLOCK_HZ / PULSE_HZ  # cycles
NO_THROTTLE = 0xFFFF


class Probe(board.Board):
    """Booted, with its command pin low."""

    def __init__(self, level=0):
        super().__init__(rig.IMAGE, rig.BOARD, rig.CLOCK)
        self.set_inputs(rig.MIDDLE, rig.MIDDLE, rig.BUS)
        self.address = rig.address_of("probe")
        self.pin = self.wiring.pulse.name
        self.taken = 0
        self.chip.signals.set(self.pin, level)
        self.boot()
        why, = struct.unpack("<I", self.core.uc.mem_read(self.address + 4 * WORDS + 8 * KEPT, 4))
        assert not why, bytes(self.core.uc.mem_read(why, 64)).partition(b"\0")[0].decode()

    def word(self, name):
        names = ("ticks", "readings", "indexes", "inputs", "temperature", "now", "paused", "pulses")
        return struct.unpack("<I", self.core.uc.mem_read(self.address + 4 * names.index(name), 4))[0]

    def pause(self, paused):
        """Whether the background fetches no pulses."""
        self.core.uc.mem_write(self.address + 4 * 6, struct.pack("<I", paused))

    @property
    def throttle(self):
        return self.word("inputs") & 0xFFFF

    @property
    def button(self):
        return bool(self.word("inputs") >> 16 & 1)

    @property
    def conversions(self):
        return self.word("inputs") >> 24

    def pulses(self):
        """(start, width) of those that were fetched since the last look, in units."""
        count = self.word("pulses")
        assert count - self.taken <= KEPT, "the image has kept less than it has fetched"
        found = [struct.unpack("<2I", self.core.uc.mem_read(self.address + 4 * WORDS + 8 * (k % KEPT), 8))
                 for k in range(self.taken, count)]
        self.taken = count
        return found

    def play(self, edges):
        """(seconds from now, level) at the command pin; goes on until all have come and the image has fetched what it could."""
        start = self.chip.now
        edges = [(start + round(seconds * digital.CLOCK_HZ), level) for seconds, level in edges]
        self.chip.signals.play(self.pin, edges)
        self.go_on((edges[-1][0] - start) / digital.CLOCK_HZ + 2 / rig.STAGE["pwm_frequency_hz"])
        return edges

    def send(self, pulses):
        """The pulses (start, width), in seconds from now, as they have to be measured: (start, width) in units."""
        zero = self.word_time()
        edges = self.play([edge for start, width in pulses for edge in ((start, 1), (start + width, 0))])
        return [(zero + (rise[0] - self.zero) / UNIT, (fall[0] - rise[0]) / UNIT) for rise, fall in zip(edges[::2], edges[1::2])]

    def word_time(self):
        """What the timer shows now."""
        self.zero = self.chip.now
        return self.chip.capture.count()


def servo(count, width_s, rate_hz, jitter_s=0.0, seed=1):
    """A servo tester: pulses of one width."""
    draw = random.Random(seed).uniform
    return [(0.001 + k / rate_hz, width_s + draw(-jitter_s, jitter_s)) for k in range(count)]


# DShot, as AM32's description has it: a bit of a 1 is high for 3/4 of its time, that of a 0 for 3/8.
ONE, ZERO = 0.75, 0.375


def dshot_frame(value, telemetry=False):
    """16 bits: 11 of the value, telemetry, and the sum of their three groups of four."""
    data = value << 1 | telemetry
    return data << 4 | (data ^ data >> 4 ^ data >> 8) & 0xF


def dshot(frames, kilobaud, gap_s, jitter=0.0, seed=1):
    """Pulses of frames, with a gap between two. `jitter`: of each edge, of a bit's time."""
    draw = random.Random(seed).uniform
    bit_s = 1e-3 / kilobaud
    found, at = [], 0.0002
    for frame in frames:
        for place in range(15, -1, -1):
            width = (ONE if frame >> place & 1 else ZERO) * bit_s
            found.append((at + draw(-jitter, jitter) * bit_s, width + draw(-jitter, jitter) * bit_s))
            at += bit_s
        at += gap_s
    return found


def decoded(pulses, kilobaud):
    """The frames of pulses: a bit is a 1 if it is high for longer than between both."""
    limit = (ONE + ZERO) / 2 * 1e-3 / kilobaud * PULSE_HZ
    bits = [width > limit for _, width in pulses]
    return [sum(bit << 15 - k for k, bit in enumerate(bits[at:at + 16])) for at in range(0, len(bits), 16)]
