# SPDX-License-Identifier: MIT
"""Where the axes of a figure lie: rows below each other, all in inches."""

from dataclasses import dataclass

LEFT = 0.68             # room for the y axis
RIGHT = 0.2
RIGHT_OF_PERCENT = 0.58  # room for a second y axis
LABEL = 0.54            # from the axes to the name of their y axis
BETWEEN = 0.16          # columns
MARGIN = 0.06


@dataclass(frozen=True)
class Row:
    """A row of axes: its height, the room above for a title and below for a time axis."""

    height: float
    above: float
    below: float
    columns: int = 1


class Frame:
    """Rows from top to bottom under a head of `head` inches."""

    def __init__(self, width, head, rows, percent):
        self.rows, self.head, self.width = rows, head, width
        self.height = head + sum(row.above + row.height + row.below for row in rows) + MARGIN
        self.inner = width - LEFT - (RIGHT_OF_PERCENT if percent else RIGHT)

    def boxes(self):
        """For each axes, row by row: (left, bottom, width, height) as shares of the figure."""
        top = self.height - self.head
        for row in self.rows:
            top -= row.above + row.height
            width = (self.inner - BETWEEN * (row.columns - 1)) / row.columns
            for column in range(row.columns):
                left = LEFT + column * (width + BETWEEN)
                yield (left / self.width, top / self.height,
                       width / self.width, row.height / self.height)
            top -= row.below

    def label_place(self, columns=1):
        """The x of a y axis' name, as a share of the width of its axes."""
        return -LABEL * columns / (self.inner - BETWEEN * (columns - 1))
