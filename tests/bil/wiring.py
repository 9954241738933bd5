# SPDX-License-Identifier: MIT
"""What is connected to the chip's pins, from the table [hal] of a board file."""

from dataclasses import dataclass

import g4
from g4 import Pin


@dataclass(frozen=True)
class Leg:
    """The two outputs of TIM1 that switch a phase. `second`: the low side's gate, or the enable of the phase's driver."""

    channel: int
    high: Pin
    second: Pin


def port_and_number(pin):
    """("A", 8) of "PA8"."""
    return pin[1], int(pin[2:])


class Wiring:
    """A board's pins by their use."""

    def __init__(self, hal):
        self.facts = g4.facts(hal["chip"])
        self.crystal_hz = hal.get("crystal_hz", 0)
        self.has_enables = "gate_enable_pins" in hal
        second_pins = hal["gate_enable_pins"] if self.has_enables else hal["gate_low_pins"]
        self.legs = [self._leg(*pins) for pins in zip(hal["gate_high_pins"], second_pins)]
        self.high_inverted = hal.get("gate_high_polarity") == "active_low"
        self.low_inverted = hal.get("gate_low_polarity") == "active_low"
        self.shunts = hal["shunt_pins"]
        self.is_amplified = hal["pga_gain"] > 1
        self.grounds = hal.get("shunt_ground_pins", [])
        self.bus, self.temperature = hal["bus_pin"], hal["temperature_pin"]
        self.serial = self.facts.serial_of(*hal["serial_pins"])
        self.serial_pins = [self._pin(*pair) for pair in zip(hal["serial_pins"], (f"{self.serial}_TX", f"{self.serial}_RX"))]
        self.led = hal.get("led_pin", "")
        self.held = dict.fromkeys(hal.get("high_pins", []), 1) | dict.fromkeys(hal.get("low_pins", []), 0)
        self.wake_s = hal.get("driver_wake_us", 0) * 1e-6
        self.throttle, self.button = hal.get("throttle_pin", ""), hal.get("button_pin", "")
        self.button_level = int(hal.get("button_polarity") == "active_high")  # while it is pressed
        self.pulse = self._pulse(hal.get("pulse_pin", ""))
        self.hall = hal.get("hall_pins", [])
        self.encoder_timer, self.encoder = self._encoder(hal.get("encoder_pins", []))
        self.index_channel = self.facts.channel_at(self.encoder_timer, self.encoder[2].name) if len(self.encoder) > 2 else None
        self.hall_timer, self.timed_hall = self._hall_timer(self.hall, hal.get("encoder_pins", []))
        self.spi, self.spi_pins, self.select = self._absolute(hal.get("spi_encoder_pins", []))
        self.break_line = self._break_line(hal.get("break_pin", ""))
        self.break_level = int(hal["break_polarity"] == "active_high")

    def _pin(self, name, signal):
        return Pin(name, self.facts.function(name, signal))

    def _leg(self, high, second):
        channel = self.facts.timer_channel(high)
        return Leg(channel, self._pin(high, f"TIM1_CH{channel}"), self._pin(second, f"TIM1_CH{channel}N"))

    def _pulse(self, name):
        return self._pin(name, f"TIM2_CH{self.facts.channel_at('TIM2', name)}") if name else None

    def _encoder(self, names):
        """(timer, pins A, B and Z) of an incremental encoder."""
        if not names:
            return None, []
        timer = next(timer for timer in ("TIM3", "TIM4") if self.facts.channel_at(timer, names[0]) == 1)
        return timer, [self._pin(name, f"{timer}_CH{self.facts.channel_at(timer, name)}") for name in names]

    def _hall_timer(self, names, encoder):
        """(timer, pins) that takes the time of Hall edges: they have its channels 1 to 3, and no encoder elsewhere has it."""
        for timer in ("TIM3", "TIM4"):
            free = timer != self.encoder_timer or set(encoder) <= set(names)
            if free and sorted(self.facts.channel_at(timer, name) or 0 for name in names) == [1, 2, 3]:
                return timer, [self._pin(name, f"{timer}_CH{self.facts.channel_at(timer, name)}") for name in names]
        return None, []

    def _absolute(self, names):
        """(interface, pins SCK, MISO and MOSI, chip select) of an absolute encoder."""
        if not names:
            return None, [], ""
        spi = self.facts.spi_of(names[:3])
        return spi, [self._pin(name, f"{spi}_{signal}") for name, signal in zip(names, ("SCK", "MISO", "MOSI"))], names[3]

    def _break_line(self, name):
        return self._pin(name, "TIM1_BKIN") if name else None

    @property
    def gates(self):
        """The high sides' pins first, as the phases follow each other."""
        return [leg.high for leg in self.legs] + [leg.second for leg in self.legs]

    @property
    def alternates(self):
        """All pins with an alternate function."""
        single = [pin for pin in (self.break_line, self.pulse) if pin]
        shaft = {pin.name: pin for pin in self.encoder + self.timed_hall}.values()
        return self.gates + self.serial_pins + single + [*shaft] + self.spi_pins

    @property
    def converted(self):
        """The pins that a converter can measure without an amplifier of the chip."""
        return [self.bus, self.temperature] + ([self.throttle] if self.throttle else []) + ([] if self.is_amplified else self.shunts)

    @property
    def comparators(self):
        """Their numbers, as the phases follow each other; without those that no comparator watches."""
        found = [self.facts.comparator_of(pin) for pin in self.shunts]
        return [comparator[0] for comparator in found if comparator]

    @property
    def amplifiers(self):
        """The numbers of those that can take a shunt as plus input."""
        return sorted({number for pin in self.shunts for number in self.facts.amplifiers_of(pin)})

    @property
    def levels(self):
        """The DACs that a comparator can compare with."""
        return sorted({dac for number in self.comparators for dac, _ in g4.MINUS[number].values() if self.facts.has(dac)})

    def level_of(self, phase):
        """(DAC, channel) that gives the trip level of a phase."""
        return g4.MINUS[self.comparators[phase]][g4.FAST_LEVEL]
