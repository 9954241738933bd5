# SPDX-License-Identifier: MIT
"""Random board files for an STM32G4: what a pin can do is taken from tests/chips, what else a board has from two shipped files."""

import json
import re
import tomllib
from pathlib import Path

import pin_rules

BOARDS = Path(__file__).resolve().parents[2] / "host_sim/boards"
AMPLIFIED, EXTERNAL = "b_g431b_esc1", "g474_in_line"  # the chip's amplifiers; others
MOTORS = {AMPLIFIED: "outrunner_24v", EXTERNAL: "outrunner_48v"}
ENTRIES = 1024        # of the recorder: for the smallest RAM
TRIP_A = 76           # of EXTERNAL with comparators; within what its amplifiers show, and above the drive's limit
LOW_SIDE = ({"duty_margin_pct": 15}, {"current_position": "low_side", "adc_settling_ns": 700, "amplifier_gain": -20})
CRYSTALS = (0, 0, 4e6, 8e6, 10e6, 12e6, 16e6, 20e6, 24e6, 25e6, 48e6)
NO_CRYSTALS = (3.4e6, 9e6, 14745600, 26e6, 47e6)
NO_PINS = ("pa8", "PA16", "PH3", "PA", "P8", "PA08", "A8", "PG9", "PE15", "PD5")
LEVELS = ("active_high", "active_low")


class NoPin(Exception):
    """The draw has no pin left: draw anew."""


class Draw:
    """A board file in the making."""

    def __init__(self, random):
        self.random = random
        self.base = random.choice((AMPLIFIED, EXTERNAL))
        shipped = tomllib.loads((BOARDS / f"{self.base}.toml").read_text(encoding="utf-8"))
        self.stage = shipped["board"] | {"name": "drawn", "recorder_entries": ENTRIES}
        self.hal = {key: value for key, value in shipped["hal"].items()
                    if not re.search(r"_pins?$|_polarity$|crystal_hz|driver_wake_us", key)}
        self.hal |= {"chip": random.choice(pin_rules.CHIPS), "crystal_hz": random.choice(CRYSTALS), "break_polarity": random.choice(LEVELS)}
        self.has_line = random.random() < 0.5  # of a gate driver, in place of comparators
        self.signals = pin_rules.signals_of(self.hal["chip"])
        self.free = set(self.signals) - set(pin_rules.DEBUGGER_AND_RESET)
        if self.hal["crystal_hz"]:
            self.free -= {"PF0", "PF1"}

    def pin(self, *patterns):
        """A free one with a signal for each pattern, which is taken then."""
        able = sorted(pin for pin in self.free
                      if all(any(re.fullmatch(pattern, signal) for signal in self.signals[pin]) for pattern in patterns))
        if not able:
            raise NoPin
        return self.take(self.random.choice(able))

    def take(self, pin):
        self.free.remove(pin)
        return pin

    def any_pin(self):
        return self.take(self.random.choice(sorted(self.free)))

    def shunts(self):
        phases = self.stage["current_sensors"] = self.random.choice((2, 3, 3))
        watched = [] if self.has_line else [r"COMP[1-4]_INP\d"]
        if self.base == EXTERNAL:
            self.hal["shunt_pins"] = [self.pin("ADC[12]_IN.*", *watched) for _ in range(phases)]
            if self.random.random() < 0.5:
                self.stage |= LOW_SIDE[0]
                self.hal |= LOW_SIDE[1]
            return
        amplifiers = self.random.sample((1, 2, 3), phases)
        self.hal["shunt_pins"] = [self.pin(rf"OPAMP{number}_VINP\d", *watched) for number in amplifiers]
        self.hal["shunt_ground_pins"] = [self.pin(f"OPAMP{number}_VINM0") for number in amplifiers]

    def gates(self):
        channels = self.random.sample((1, 2, 3), 3)
        self.hal["gate_high_pins"] = [self.pin(f"TIM1_CH{channel}") for channel in channels]
        seconds = [self.pin(f"TIM1_CH{channel}N") for channel in channels]
        self.hal["gate_high_polarity"] = self.random.choice(LEVELS)
        if self.random.random() < 0.3:
            self.hal["gate_enable_pins"] = seconds
        else:
            self.hal |= {"gate_low_pins": seconds, "gate_low_polarity": self.random.choice(LEVELS)}

    def trip(self):
        if self.has_line:
            self.hal["break_pin"] = self.pin("TIM1_BKIN")
            self.stage.pop("trip_a", None)
            return
        self.stage.setdefault("trip_a", TRIP_A)
        if self.random.random() < 0.9:  # towards the short circuit
            self.hal["break_polarity"] = LEVELS[self.hal["amplifier_gain"] > 0]

    def rest(self):
        number = self.random.choice((1, 2, 3))
        self.hal["serial_pins"] = [self.pin(f"USART{number}_TX"), self.pin(f"USART{number}_RX")]
        self.hal["bus_pin"] = self.pin("ADC[12]_IN.*")
        self.hal["temperature_pin"] = self.pin("ADC[12]_IN.*")
        if self.random.random() < 0.7:
            self.hal |= {"led_pin": self.any_pin(), "led_polarity": self.random.choice(LEVELS)}
        for key in ("high_pins", "low_pins"):
            if count := self.random.choice((0, 0, 1, 2)):
                self.hal[key] = [self.any_pin() for _ in range(count)]
        self.hal["driver_wake_us"] = self.random.choice((0, 0, 50, 1000))


    def inputs(self):
        """Some of those that the pins that are left allow."""
        self.maybe("throttle_pin", lambda: self.pin("ADC[12]_IN.*"))
        self.maybe("pulse_pin", lambda: self.pin("TIM2_CH[1-4]"))
        self.maybe("button_pin", self.any_pin)
        self.hal["button_polarity"] = self.random.choice(LEVELS)
        timer, number = self.random.choice((3, 4)), self.random.choice((1, 2, 3))
        kind = self.random.choice(("", "hall", "encoder", "both", "absolute"))
        if kind in ("encoder", "both"):
            channels = self.random.choice((("1", "2"), ("1", "2", "[34]"), ("1", "2", "[34]")))
            self.maybe("encoder_pins", lambda: [self.pin(f"TIM{timer}_CH{channel}") for channel in channels], 1)
        if kind in ("hall", "both"):
            shared = self.hal.get("encoder_pins", []) if kind == "both" else []
            self.maybe("hall_pins", lambda: (shared + [self.any_pin() for _ in range(3)])[:3], 1)
        if kind == "absolute":
            self.maybe("spi_encoder_pins", lambda: [*(self.pin(f"SPI{number}_{signal}") for signal in ("SCK", "MISO", "MOSI")),
                                                    self.any_pin()], 1)

    def maybe(self, key, choose, share=0.5):
        """With this probability, and if there is a pin. Pins that it has taken in vain stay without a use."""
        try:
            if self.random.random() < share:
                self.hal[key] = choose()
        except NoPin:
            pass


def anything(random):
    """A board whose pins can each do what they are named for; whether together, nobody has looked."""
    while True:
        draw = Draw(random)
        try:
            for part in (draw.shunts, draw.gates, draw.trip, draw.rest, draw.inputs):
                part()
            return draw
        except NoPin:
            continue


def possible(random):
    """A board that the rules accept."""
    while True:
        draw = anything(random)
        if not pin_rules.Rules(draw.stage, draw.hal).problems():
            return draw


# ---- spoilt ones ----

def _named(draw):
    """(list or table, place in it) of each pin that the file names."""
    places = [(draw.hal[key], place) for key in pin_rules.LIST_KEYS for place in range(len(draw.hal.get(key, [])))]
    return places + [(draw.hal, key) for key in pin_rules.PIN_KEYS if draw.hal.get(key)]


def other_pin(draw):
    where, place = draw.random.choice(_named(draw))
    where[place] = draw.random.choice(sorted(draw.signals))


def pin_of_another_use(draw):
    (where, place), (there, other) = draw.random.sample(_named(draw), 2)
    where[place] = there[other]


def swapped(draw):
    (where, place), (there, other) = draw.random.sample(_named(draw), 2)
    where[place], there[other] = there[other], where[place]


def no_pin(draw):
    where, place = draw.random.choice(_named(draw))
    where[place] = draw.random.choice(NO_PINS)


def count(draw):
    key = draw.random.choice([key for key in pin_rules.LIST_KEYS if draw.hal.get(key)])
    draw.hal[key] = draw.random.choice((draw.hal[key][:-1], draw.hal[key] + [draw.any_pin()], []))


def sensors(draw):
    draw.stage["current_sensors"] ^= 1


def crystal(draw):
    draw.hal["crystal_hz"] = draw.random.choice(NO_CRYSTALS + CRYSTALS)


def chip(draw):
    draw.hal["chip"] = draw.random.choice(pin_rules.CHIPS + ["stm32g431kb"])


def gates_and_enables(draw):
    lacking = "gate_low_pins" if "gate_enable_pins" in draw.hal else "gate_enable_pins"
    draw.hal[lacking] = [draw.any_pin() for _ in range(3)]


def inverted_enables(draw):
    draw.hal["gate_low_polarity"] = "active_low"


def two_limits(draw):
    draw.stage["trip_a"] = draw.stage.get("trip_a", TRIP_A)
    draw.hal["break_pin"] = draw.hal.get("break_pin") or draw.any_pin()


def grounds(draw):
    draw.hal["shunt_ground_pins"] = [draw.any_pin() for _ in draw.hal["shunt_pins"]]


SPOILERS = (other_pin, other_pin, pin_of_another_use, pin_of_another_use, swapped, no_pin, count, sensors, crystal, chip,
            gates_and_enables, inverted_enables, two_limits, grounds)


def spoilt(random):
    """A board that may be wrong, in one or two ways."""
    draw = possible(random) if random.random() < 0.7 else anything(random)
    for spoil in random.sample(SPOILERS, random.choice((0, 1, 1, 1, 2))):
        spoil(draw)
    return draw


def text(draw):
    """The board file."""
    lines = []
    for table, values in (("board", draw.stage), ("hal", draw.hal)):
        lines += [f"[{table}]", *(f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in values.items()), ""]
    return "\n".join(lines)
