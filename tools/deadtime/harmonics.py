# SPDX-License-Identifier: MIT
"""The orders of a current: its harmonics over whole turns of the rotor's electrical angle.

Orders are counted against the angle and not the time, so a speed that sways spreads no fundamental over its
neighbours. They come from a least-squares fit, which asks for no whole number of samples in a turn.
"""

from dataclasses import dataclass

import numpy as np

ORDERS = 25     # of the fit; at 900 rpm and two pole pairs order 25 has 13 samples a period


@dataclass(frozen=True)
class Orders:
    """Amplitudes of order 0 (the mean) to ORDERS, and of a sine of the power of all but orders 0 and 1."""

    amplitudes: np.ndarray
    distortion: float

    @property
    def fundamental(self):
        return float(self.amplitudes[1])

    @property
    def shares_pct(self):
        """Of each order, in per cent of the fundamental."""
        return 100.0 * self.amplitudes / self.fundamental

    @property
    def thd_pct(self):
        """√(Σ of the squares of orders 2 to ORDERS) in per cent of the fundamental."""
        return float(np.sqrt(np.square(self.shares_pct[2:]).sum()))

    @property
    def distortion_pct(self):
        """As thd_pct, and what lies between the orders, as where a drive sways, and beyond them."""
        return 100.0 * self.distortion / self.fundamental


def whole_turns(angle_deg):
    """The samples from where the angle wraps first to where it does last, and the turns between."""
    wraps = np.flatnonzero(np.abs(np.diff(angle_deg)) > 180.0) + 1
    turns = abs(round(np.ptp(np.unwrap(angle_deg, period=360.0)[wraps]) / 360.0)) if len(wraps) else 0
    if turns == 0:
        raise ValueError("the rotor makes no whole electrical turn; expected at least one")
    return slice(int(wraps[0]), int(wraps[-1])), turns


def orders(angle_deg, current):
    """The Orders of a current over the angle."""
    steps = np.outer(np.radians(angle_deg), np.arange(1, ORDERS + 1))
    basis = np.hstack([np.ones((len(steps), 1)), np.cos(steps), np.sin(steps)])
    fitted = np.linalg.lstsq(basis, current, rcond=None)[0]
    mean, cosines, sines = fitted[0], fitted[1:ORDERS + 1], fitted[ORDERS + 1:]
    low = [0, 1, ORDERS + 1]
    rest = current - basis[:, low] @ fitted[low]
    return Orders(np.concatenate([[abs(mean)], np.hypot(cosines, sines)]),
                  float(np.sqrt(2.0 * np.square(rest).mean())))
