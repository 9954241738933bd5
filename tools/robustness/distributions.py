# SPDX-License-Identifier: MIT
"""What a campaign varies: distributions, and the values of a run as texts for `--set`.

A value depends on the campaign's seed, the number of the run and the parameter's name alone. So any
run can be made again by itself, on any machine, and one more parameter leaves the others as they
were.
"""

import json
import math
import zlib
from dataclasses import dataclass

import numpy as np

# Rounded to what every machine's logarithm agrees on; a motor's parameters are known to far less.
DIGITS = 7


class DistributionError(Exception):
    """What was found and what is allowed; the reader adds file and key."""


def shown(value):
    """A value of a campaign file for messages; dates, which it has no use for, are in it too."""
    return json.dumps(value, ensure_ascii=False, default=str)


def text_of(value):
    """A value of a campaign file as the text that `--set KEY=` takes."""
    return value if isinstance(value, str) else shown(value)


def is_number(value):
    return type(value) in (int, float) and math.isfinite(value)


@dataclass(frozen=True)
class Range:
    """Numbers from `low` to `high`; `kind` says how they spread between."""

    kind: str
    low: float
    high: float

    @property
    def log(self):
        return self.kind == "log_uniform"

    def value(self, share):
        """The text at a share, 0 up to but not including 1, of the distribution."""
        if self.kind == "integer":
            return str(self.low + math.floor(share * (self.high - self.low + 1)))
        if self.log:
            return f"{self.low * (self.high / self.low) ** share:.{DIGITS}g}"
        return f"{self.low + (self.high - self.low) * share:.{DIGITS}g}"

    def corner(self, number):
        """Ends of the range in turn."""
        return text_of(self.high if number % 2 else self.low)

    def place(self, text):
        """Where a value lies, 0 to 1."""
        value, low, high = float(text), self.low, self.high
        if self.log:
            value, low, high = math.log(value), math.log(low), math.log(high)
        return (value - low) / (high - low)

    @property
    def corners(self):
        return 2

    def __str__(self):
        return f"{self.kind} {self.low} to {self.high}"


@dataclass(frozen=True)
class Choice:
    """One of several values, each as likely as the others."""

    options: tuple  # texts

    def value(self, share):
        return self.options[math.floor(share * len(self.options))]

    def corner(self, number):
        return self.options[number % len(self.options)]

    def place(self, text):
        return (self.options.index(text) + 0.5) / len(self.options)

    @property
    def corners(self):
        return len(self.options)

    def __str__(self):
        return f"choice of {', '.join(self.options)}"


def read_range(kind, value):
    allowed = {"uniform": "[low, high], two numbers that rise",
               "log_uniform": "[low, high], two numbers above 0 that rise",
               "integer": "[low, high], two whole numbers that rise"}[kind]
    good = isinstance(value, list) and len(value) == 2 and all(map(is_number, value))
    good = good and value[0] < value[1] and (kind != "log_uniform" or value[0] > 0)
    if not good or (kind == "integer" and not all(type(end) is int for end in value)):
        raise DistributionError(f"is {shown(value)}; allowed: {allowed}")
    return Range(kind, *value)


def read_choice(_, value):
    texts = [text_of(option) for option in value] if isinstance(value, list) else []
    if len(texts) < 2 or len(set(texts)) < len(texts):
        raise DistributionError(f"is {shown(value)}; allowed: a list of two or more values, "
                                "each once")
    return Choice(tuple(texts))


READERS = {"uniform": read_range, "log_uniform": read_range, "integer": read_range,
           "choice": read_choice}


def read(kind, value):
    return READERS[kind](kind, value)


def share(seed, run, key):
    """The random number of a parameter in a run, 0 up to but not including 1."""
    sequence = np.random.SeedSequence(seed, spawn_key=(run, zlib.crc32(key.encode())))
    return np.random.Generator(np.random.PCG64(sequence)).random()


def values(vary, seed, run):
    """The texts of all parameters of a run, by key."""
    return {key: distribution.value(share(seed, run, key)) for key, distribution in vary.items()}
