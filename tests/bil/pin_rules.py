# SPDX-License-Identifier: MIT
"""Whether an STM32G4 can be wired as a board file says: from the facts of tests/chips alone, without nfconfig.

A search over all assignments, where nfconfig has an order of its own.
"""

import itertools
import json
import re
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "chips"
CHIPS = sorted(path.stem for path in FOLDER.glob("stm32*.json"))
# RM0440 21.4: (converter, channel) that measures an amplifier inside of the chip.
INSIDE = {1: (1, 13), 2: (2, 16), 3: (2, 18)}
DEBUGGER_AND_RESET = ("PA13", "PA14", "PG10")
PIN_KEYS = ("bus_pin", "temperature_pin", "break_pin", "led_pin", "throttle_pin", "pulse_pin", "button_pin")
LIST_KEYS = ("gate_high_pins", "gate_low_pins", "gate_enable_pins", "shunt_pins", "shunt_ground_pins", "high_pins", "low_pins",
             "serial_pins", "hall_pins", "encoder_pins", "spi_encoder_pins")
GATE_KEYS = ("gate_high_pins", "gate_low_pins", "gate_enable_pins")
CRYSTAL_HZ = (4e6, 48e6)  # data sheet, as the next two
PLL_IN_HZ = (2.66e6, 16e6)
CLOCK_HZ = 170e6


def signals_of(chip):
    """{pin: {signal: alternate function or None}}"""
    return json.loads((FOLDER / f"{chip}.json").read_text(encoding="utf-8"))["pins"]


@dataclass(frozen=True)
class Problem:
    """One reason to refuse the file, and the keys that may be named for it."""

    keys: tuple
    says: str


def pins_of(hal):
    """(key, pin) of each pin that the file names."""
    found = [(key, pin) for key in LIST_KEYS for pin in hal.get(key, [])]
    return found + [(key, hal[key]) for key in PIN_KEYS if hal.get(key)]


def has_clock(hz):
    """Whether the PLL makes exactly 170 MHz of it. 0: the oscillator in the chip."""
    if not hz:
        return True
    in_range = CRYSTAL_HZ[0] <= hz <= CRYSTAL_HZ[1]
    return in_range and any(PLL_IN_HZ[0] <= hz / m <= PLL_IN_HZ[1] and hz * n == 2 * CLOCK_HZ * m
                            for m in range(1, 17) for n in range(8, 128))


class Rules:
    """The rules for one board file: its tables [board] and [hal]."""

    def __init__(self, stage, hal):
        self.stage, self.hal = stage, hal
        self.signals = signals_of(hal["chip"]) if hal["chip"] in CHIPS else None
        self.amplified = hal["pga_gain"] > 1
        self.shunts = hal.get("shunt_pins", [])
        self.grounds = hal.get("shunt_ground_pins", [])

    def problems(self):
        if self.signals is None:
            return [Problem(("chip",), "no such chip")]
        found = [*self._crystal(), *self._uses(), *self._gates(), *self._trip(), *self._serial(), *self._counts(), *self._inputs(),
                 *self._commands(), *self._shaft()]
        return found or [*self._sampling()]

    def _has(self, pin, signal):
        return signal in self.signals.get(pin, {})

    def _numbers(self, pin, pattern):
        matches = (re.fullmatch(pattern, signal) for signal in self.signals.get(pin, {}))
        return [tuple(map(int, match.groups())) for match in matches if match]

    def _crystal(self):
        if not has_clock(self.hal.get("crystal_hz", 0)):
            yield Problem(("crystal_hz",), "no 170 MHz")

    def _uses(self):
        """Each pin is one of the package and has one use."""
        users = {pin: ["the chip"] for pin in DEBUGGER_AND_RESET}
        if self.hal.get("crystal_hz"):
            users |= {pin: ["crystal_hz"] for pin, signals in self.signals.items() if {"RCC_OSC_IN", "RCC_OSC_OUT"} & signals.keys()}
        for key, pin in pins_of(self.hal):
            if not self._is_shared(key, pin):
                users.setdefault(pin, []).append(key)
            if pin not in self.signals:
                yield Problem((key,), f"{pin} is no pin")
        for pin, keys in users.items():
            if len(keys) > 1:
                yield Problem(tuple(keys), f"{pin} has {len(keys)} uses")

    def _is_shared(self, key, pin):
        """One connector may be for Hall sensors or an encoder."""
        return key == "hall_pins" and pin in self.hal.get("encoder_pins", []) and self.hal[key].count(pin) == 1

    def _commands(self):
        throttle, pulses = self.hal.get("throttle_pin"), self.hal.get("pulse_pin")
        if throttle and not self._converters(throttle):
            yield Problem(("throttle_pin",), "no input of a converter")
        if pulses and not self._numbers(pulses, r"TIM2_CH([1-4])"):
            yield Problem(("pulse_pin",), "no channel of timer 2")

    def _shaft(self):
        hall, encoder, absolute = (self.hal.get(key, []) for key in ("hall_pins", "encoder_pins", "spi_encoder_pins"))
        if len(hall) not in (0, 3):
            yield Problem(("hall_pins",), "not three sensors")
        if encoder and not any(self._is_encoder(encoder, timer) for timer in (3, 4)):
            yield Problem(("encoder_pins",), "not A, B and perhaps Z of one timer")
        if absolute and not (len(absolute) == 4 and any(self._is_spi(absolute, number) for number in (1, 2, 3))):
            yield Problem(("spi_encoder_pins",), "not one SPI and a select")

    def _is_encoder(self, pins, timer):
        channels = ("1", "2", "[34]")[:len(pins)]
        return len(pins) in (2, 3) and all(self._numbers(pin, rf"TIM{timer}_CH({channel})") for pin, channel in zip(pins, channels))

    def _is_spi(self, pins, number):
        return all(self._has(pin, f"SPI{number}_{signal}") for pin, signal in zip(pins, ("SCK", "MISO", "MOSI")))

    def _gates(self):
        hal = self.hal
        lows, enables = hal.get("gate_low_pins", []), hal.get("gate_enable_pins", [])
        key = "gate_enable_pins" if enables else "gate_low_pins"
        if lows and enables:
            yield Problem(GATE_KEYS, "low gates and enables")
        if enables and hal.get("gate_low_polarity") == "active_low":
            yield Problem(("gate_low_polarity",), "enables that are active low")
        seconds, highs = enables or lows, hal.get("gate_high_pins", [])
        if len(highs) != 3 or len(seconds) != 3:
            yield Problem(GATE_KEYS, "not three gates")
            return
        channels = [next((number for number, in self._numbers(pin, r"TIM1_CH([123])")), None) for pin in highs]
        if None in channels or len(set(channels)) != 3:
            yield Problem(("gate_high_pins",), "not three channels")
        for pin, channel in zip(seconds, channels):
            if channel and not self._has(pin, f"TIM1_CH{channel}N"):
                yield Problem((key,), f"{pin} does not belong to channel {channel}")

    def _trip(self):
        line = self.hal.get("break_pin")
        if line and not self._has(line, "TIM1_BKIN"):
            yield Problem(("break_pin",), f"{line} is no break input")
        if line and self.stage.get("trip_a"):
            yield Problem(("trip_a", "break_pin"), "two limits")
        comparators = [[number for number, _ in self._numbers(pin, r"COMP([1-4])_INP(\d)")] for pin in self.shunts]
        if not line and not any(len(set(chosen)) == len(chosen) for chosen in itertools.product(*comparators)):
            yield Problem(("shunt_pins",), "not a comparator each")
        rises = self.hal["amplifier_gain"] < 0  # with a current from the phase to ground
        above = self.hal["break_polarity"] == "active_high"
        if not line and self.hal.get("current_position", "low_side") == "low_side" and rises != above:
            yield Problem(("break_polarity",), "comparators that look away from a short circuit")

    def _serial(self):
        pins = self.hal.get("serial_pins", [])
        if len(pins) != 2 or not any(self._has(pins[0], f"USART{number}_TX") and self._has(pins[1], f"USART{number}_RX")
                                     for number in (1, 2, 3)):
            yield Problem(("serial_pins",), "not TX and RX of one interface")

    def _counts(self):
        phases = self.stage["current_sensors"]
        if len(self.shunts) != phases:
            yield Problem(("shunt_pins",), "not a shunt for each sensor")
        if len(self.grounds) != (phases if self.amplified else 0):
            yield Problem(("shunt_ground_pins",), "not a ground for each amplifier")

    def _converters(self, pin):
        return self._numbers(pin, r"ADC([12])_IN(\d+)")

    def _inputs(self):
        for key in ("bus_pin", "temperature_pin"):
            if not self._converters(self.hal[key]):
                yield Problem((key,), "no input of a converter")
        if not self.amplified:
            if not all(map(self._converters, self.shunts)):
                yield Problem(("shunt_pins",), "no input of a converter")
        elif not self._amplifiers():
            yield Problem(("shunt_pins", "shunt_ground_pins"), "not an amplifier each")

    def _amplifiers(self):
        """Each choice of an amplifier for each shunt."""
        fitting = [[number for number in INSIDE if self._has(ground, f"OPAMP{number}_VINM0") and
                    any(amplifier == number for amplifier, _ in self._numbers(plus, r"OPAMP(\d)_VINP(\d)"))]
                   for plus, ground in zip(self.shunts, self.grounds)]
        return [chosen for chosen in itertools.product(*fitting) if len(set(chosen)) == len(chosen)]

    def _outputs(self, number):
        """Where an amplifier can be measured: inside, and at its output pin unless the board uses that for something else."""
        used = {pin for _, pin in pins_of(self.hal)}
        pins = [pin for pin in self.signals if self._has(pin, f"OPAMP{number}_VOUT") and pin not in used]
        crystal = self.hal.get("crystal_hz") and {"RCC_OSC_IN", "RCC_OSC_OUT"}
        pins = [pin for pin in pins if not (crystal and crystal & self.signals[pin].keys())]
        return [INSIDE[number], *(place for pin in pins for place in self._converters(pin))]

    def _sampling(self):
        """Phases a and b on two converters, and then bus and phase c on two."""
        choices = [list(map(self._outputs, chosen)) for chosen in self._amplifiers()] if self.amplified else \
            [list(map(self._converters, self.shunts))]
        bus = self._converters(self.hal["bus_pin"])
        for places in choices:
            for chosen in itertools.product(*places, bus):
                on = [converter for converter, _ in chosen]
                if on[0] != on[1] and (len(places) == 2 or on[2] != on[3]):
                    return
        yield Problem(("shunt_pins", "bus_pin"), "the converters cannot sample this")
