# SPDX-License-Identifier: MIT
"""What the runs of a campaign can be sorted by: a parameter that varies, or a number that a run has."""

import bisect
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    distribution: object            # of distributions.py, or Ranked
    value: Callable[[dict], object]  # of a row, as the distribution takes it

    def place(self, row):
        """Where a row lies, 0 to 1."""
        return self.distribution.place(self.value(row))


@dataclass(frozen=True)
class Ranked:
    """Numbers by rank: each part of the axis holds as many runs as any other of its length."""

    ordered: tuple

    def place(self, value):
        # In the middle of those that are equal.
        rank = bisect.bisect_left(self.ordered, value) + bisect.bisect_right(self.ordered, value)
        return rank / 2 / len(self.ordered)

    def at(self, place):
        """The number at a place, 0 to 1."""
        return self.ordered[min(int(place * len(self.ordered)), len(self.ordered) - 1)]

    def __str__(self):
        return f"{self.ordered[0]:.3g} to {self.ordered[-1]:.3g}"
