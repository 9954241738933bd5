# SPDX-License-Identifier: MIT
"""Facts of an STM32G4 chip: which pin belongs to which peripheral, base addresses, clock enable bits and memories.

They come from tests/chips/NAME.json. The tables here hold what those files do not have; each names its section of RM0440.
"""

import functools
import json
import re
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "chips"
FLASH, RAM = 0x08000000, 0x20000000

# RM0440 21.4: (converter, channel) that measures an amplifier inside the chip.
INSIDE = {("ADC1", 13): 1, ("ADC2", 16): 2, ("ADC2", 18): 3, ("ADC3", 13): 3, ("ADC5", 5): 4, ("ADC5", 3): 5, ("ADC4", 17): 6}
# RM0440 24.3.2: the DAC channel at a comparator's minus input, by INMSEL.
MINUS = {
    1: {4: ("DAC3", 1), 5: ("DAC1", 1)},
    2: {4: ("DAC3", 2), 5: ("DAC1", 2)},
    3: {4: ("DAC3", 1), 5: ("DAC1", 1)},
    4: {4: ("DAC3", 2), 5: ("DAC1", 1)},
    5: {4: ("DAC4", 1), 5: ("DAC1", 2)},
    6: {4: ("DAC4", 2), 5: ("DAC2", 1)},
    7: {4: ("DAC4", 1), 5: ("DAC2", 1)},
}
FAST_LEVEL = 4      # INMSEL of the DACs that are inside the chip only
DAC_CHANNELS = {"DAC1": (1, 2), "DAC2": (1,), "DAC3": (1, 2), "DAC4": (1, 2)}  # RM0440 22.3
HSE_32, LSI = 3, 6  # RM0440 30.6, TISEL of TIM16 and TIM17
# RM0440 9.4: MODER, PUPDR and OSPEEDR after reset. Ports A and B have the debug pins.
PORT_RESETS = {"A": (0xABFFFFFF, 0x64000000, 0x0C000000), "B": (0xFFFFFEBF, 0x00000100, 0)}
OTHER_PORTS_RESET = (0xFFFFFFFF, 0, 0)


@dataclass(frozen=True)
class Pin:
    """One that a peripheral drives or reads, with its alternate function."""

    name: str
    function: int


def polarity_bit(comparator):
    """RM0440 28.6, TIM1_AF1: the bit that inverts a comparator's output, or None. Comparators 5 to 7 have none."""
    return 9 + comparator if comparator <= 4 else None


@functools.cache
def facts(name):
    return Facts(name)


class Facts:
    """One chip. Peripherals have the manual's names; a pin is "PA1"."""

    def __init__(self, name):
        data = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
        self.name = name
        self._pins = data["pins"]  # {pin: {signal: its alternate function, None if it is analogue}}
        self._peripherals = data["peripherals"]
        self._interrupts = data["interrupts"]
        self._clocks = data["registers"][self._peripherals["RCC"]["registers"]]
        memories = [self._regions(memory) for memory in data["memories"].values()]
        self._set_flash(max(([region for region in memory if region[0] == "Flash"] for memory in memories), key=len))
        self.ram_bytes = self._ram(memories[0])

    @staticmethod
    def _regions(memory):
        """(kind, address, size, bytes of a page), by address."""
        return sorted(((kind, int(address, 0), int(size, 0), page) for kind, address, size, page in memory.values()),
                      key=lambda region: region[1])

    def _set_flash(self, banks):
        """Two banks, if the factory's option bytes make two."""
        self.dual_bank = len(banks) == 2
        _, _, self.bank_bytes, self.page_bytes = banks[0]
        self.flash_bytes = sum(size for _, _, size, _ in banks)

    @staticmethod
    def _ram(regions):
        """RM0440 2.4: the blocks of RAM follow each other, the CCM RAM last."""
        end = RAM
        for _, address, size, _ in regions:
            end += size if address == end else 0
        return end - RAM

    def has(self, peripheral):
        return peripheral in self._peripherals

    def numbered(self, kind):
        """The numbers of the peripherals KIND1, KIND2, ... that the chip has."""
        return [number for number in range(1, 10) if self.has(f"{kind}{number}")]

    def base(self, peripheral):
        return int(self._peripherals[peripheral]["base"], 0)

    def enable(self, peripheral):
        """(register of RCC, bit) of its clock."""
        register, field = self._peripherals[peripheral]["enable"].split(".")
        return register, int(self._clocks[register][2][field], 0).bit_length() - 1

    def ports(self):
        """The letters of those that have a pin on this package."""
        return sorted({pin[1] for pin in self._pins})

    def function(self, pin, signal):
        """The alternate function of a signal that the pin has."""
        return self._pins[pin][signal]

    def signals(self, pin):
        return self._pins.get(pin, {})

    @functools.cache
    def pin_of(self, signal):
        """The only pin with this analogue signal; None if the package has none."""
        return next((pin for pin, signals in self._pins.items() if signal in signals), None)

    @functools.cache
    def _numbers(self, pin, pattern):
        """The numbers in those of its signals that match."""
        matches = (re.fullmatch(pattern, signal) for signal in self.signals(pin))
        return [tuple(map(int, match.groups())) for match in matches if match]

    def channel_of(self, converter, pin):
        return next((channel for channel, in self._numbers(pin, rf"{converter}_IN(\d+)")), None)

    def amplifiers_of(self, plus):
        """The amplifiers that can take this pin as plus input, {number: VP_SEL}."""
        return dict(self._numbers(plus, r"OPAMP(\d)_VINP(\d)"))

    def amplifier_at(self, output):
        return next((number for number, in self._numbers(output, r"OPAMP(\d)_VOUT")), None)

    def comparator_of(self, plus):
        """(number, INPSEL) of the comparator whose plus input is this pin, or None: there is one at most."""
        return next(iter(self._numbers(plus, r"COMP(\d)_INP(\d)")), None)

    def timer_channel(self, pin):
        """The channel of TIM1 whose output is there."""
        return next(channel for channel, in self._numbers(pin, r"TIM1_CH([123])"))

    def serial_of(self, sender, receiver):
        """The serial interface with these pins."""
        for signal in self.signals(sender):
            name = signal.removesuffix("_TX")
            if re.fullmatch(r"USART[1-3]", name) and f"{name}_RX" in self.signals(receiver):
                return name
        raise ValueError(f"no serial interface of {self.name} has TX at {sender} and RX at {receiver}")

    def requests(self, peripheral):
        """{signal: number of its request at the DMA's multiplexer}"""
        return self._peripherals[peripheral]["requests"]

    @functools.cache
    def pins_of(self, signal):
        """All pins with a digital signal, each with its alternate function."""
        return [Pin(pin, signals[signal]) for pin, signals in self._pins.items() if signal in signals]

    def channel_at(self, timer, pin):
        """The channel of a timer at a pin, or None."""
        return next((channel for channel, in self._numbers(pin, rf"{timer}_CH(\d)")), None)

    def spi_of(self, pins):
        """The interface with SCK, MISO and MOSI at these pins."""
        return next(f"SPI{number}" for number in (1, 2, 3)
                    if all(f"SPI{number}_{signal}" in self.signals(pin) for signal, pin in zip(("SCK", "MISO", "MOSI"), pins)))

    def interrupt(self, converter):
        return self._interrupts[self._peripherals[converter]["interrupts"]["GLOBAL"]]

    def injected_trigger(self, converter):
        """JEXTSEL of TIM1's second trigger output."""
        triggers = self._peripherals[converter]["triggers"].items()
        return next(int(match[1]) for signal, source in triggers
                    if source == "TIM1_TRGO2" and (match := re.fullmatch(r"ADC_JEXT_TRG(\d+)", signal)))
