# SPDX-License-Identifier: MIT
"""A run beyond rated speed: torque over speed, and the current in its plane with what bounds it."""

import math

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from report.style import LIGHT, settings

KEY, TITLE = "plane", "What bounds torque and current beyond rated speed"
BEYOND = 1.05           # of rated speed: an overshoot is not meant
COLUMNS = ("state", "speed_rpm", "torque_nm", "i_d_a", "i_q_a", "bus_v")
SAMPLES = 2500          # of the locus
GRID = 161              # of the current, along each axis
SPEEDS = 60
RAD_S_PER_RPM = math.pi / 30
LIMIT = {"color": LIGHT["command"], "linewidth": 1.0, "linestyle": (0, (4, 2))}
MOST = {"color": LIGHT["muted"], "linewidth": 1.0}
SALIENT = 0.01          # of L_d: less makes no line to see
CIRCLE = {"color": LIGHT["muted"], "linewidth": 1.0, "linestyle": (0, (1, 1.2))}
BELOW = {"color": LIGHT["third"], "linewidth": 0.8}
ABOVE = {"color": LIGHT["actual"], "linewidth": 0.8}
WORDS = ("(a) Torque in the direction of turning, over the speed; dashed: the most that the current and the voltage of the bus leave. (b) The "
         "currents in their plane; dashed: the voltage ellipse of the highest speed, dotted: the largest current. Beyond rated speed the "
         "current keeps within both, by what the drive leaves of the bus. Of a salient motor the grey line has the most torque for a "
         "current (MTPA): up to rated speed the currents are on it.")


class Motor:
    """What the plant of a run is made of."""

    def __init__(self, metrics):
        actual = {name: value["actual"] for name, value in metrics["parameters"].items()}
        self.resistance, self.flux = actual["resistance_ohm"], actual["flux_linkage_wb"]
        self.l_d, self.l_q = actual["inductance_d_h"], actual["inductance_q_h"]
        self.pole_pairs = metrics["motor"]["pole_pairs"]
        self.current = metrics["motor"]["max_current_a"]

    def voltage(self, rpm, i_d, i_q):
        """Amplitude of the phase voltage at a steady point."""
        speed = rpm * RAD_S_PER_RPM * self.pole_pairs
        return np.hypot(self.resistance * i_d - speed * self.l_q * i_q,
                        self.resistance * i_q + speed * (self.flux + self.l_d * i_d))

    def torque(self, i_d, i_q):
        return 1.5 * self.pole_pairs * (self.flux + (self.l_d - self.l_q) * i_d) * i_q

    def is_salient(self):
        return self.l_q - self.l_d > SALIENT * self.l_d

    def most_torque_d(self, i_q):
        """i_d with the most torque that a current of this i_q makes."""
        half = self.flux / (2 * (self.l_q - self.l_d))
        return half - np.hypot(half, i_q)

    def plane(self):
        """The currents of a grid of the circle's left half."""
        return np.meshgrid(np.linspace(-self.current, 0, GRID), np.linspace(-self.current, self.current, 2 * GRID - 1))

    def limits(self, rpm, voltage, sign):
        """The most torque in one direction at each of these speeds; NaN where no current is left."""
        i_d, i_q = self.plane()
        torque, inside = sign * self.torque(i_d, i_q), np.hypot(i_d, i_q) <= self.current
        found = [np.max(torque, where=inside & (self.voltage(one, i_d, i_q) <= voltage), initial=-np.inf) for one in rpm]
        return sign * np.where(np.isfinite(found), found, np.nan)


def goes_beyond(run):
    rated = (run.metrics.get("motor") or {}).get("rated_speed_rpm")
    return bool(rated) and run.trace.has(COLUMNS) and float(np.abs(run.trace["speed_rpm"]).max()) > BEYOND * rated


class Locus:
    """Where the run was, turned so that it turns forwards."""

    def __init__(self, run):
        trace = run.trace
        at = np.flatnonzero(trace["state"] == "RUN")
        at = at[::max(1, len(at) // SAMPLES)]
        side = np.where(trace["speed_rpm"][at] < 0, -1.0, 1.0)
        self.rpm = side * trace["speed_rpm"][at]
        self.torque, self.i_q = side * trace["torque_nm"][at], side * trace["i_q_a"][at]
        self.i_d = trace["i_d_a"][at]
        self.beyond = self.rpm > run.metrics["motor"]["rated_speed_rpm"]
        self.voltage = float(np.median(trace["bus_v"])) / math.sqrt(3)

    def plot(self, ax, x, y):
        """What is beyond rated speed lies on top."""
        for chosen, how in ((~self.beyond, BELOW), (self.beyond, ABOVE)):
            ax.plot(np.where(chosen, x, np.nan), np.where(chosen, y, np.nan), **how)


def draw_torque(ax, motor, locus):
    rpm = np.linspace(1.0, 1.02 * locus.rpm.max(), SPEEDS)
    for sign in (1, -1):
        ax.plot(rpm, motor.limits(rpm, locus.voltage, sign), **LIMIT)
    locus.plot(ax, locus.rpm, locus.torque)
    ax.set(xlabel="speed, rpm", ylabel="torque, N·m", xlim=(0, rpm[-1]))
    ax.set_title("(a) torque over speed")


def draw_currents(ax, motor, locus):
    reach = 1.08 * motor.current
    i_d, i_q = np.meshgrid(np.linspace(-reach, reach, 2 * GRID), np.linspace(-reach, reach, 2 * GRID))
    ax.contour(i_d, i_q, motor.voltage(locus.rpm.max(), i_d, i_q), [locus.voltage], colors=LIMIT["color"], linewidths=1.0,
               linestyles=[LIMIT["linestyle"]])
    turn = np.linspace(0, 2 * math.pi, 200)
    ax.plot(motor.current * np.cos(turn), motor.current * np.sin(turn), **CIRCLE)
    if motor.is_salient():
        i_q = np.linspace(-motor.current, motor.current, GRID)
        inside = np.hypot(motor.most_torque_d(i_q), i_q) <= motor.current
        ax.plot(motor.most_torque_d(i_q)[inside], i_q[inside], **MOST)
    locus.plot(ax, locus.i_d, locus.i_q)
    ax.set(xlabel="d current, A", ylabel="q current, A", xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.set_title("(b) currents")


def legend(figure, motor, shape):
    marks = {"up to rated speed": BELOW, "beyond": ABOVE, "bound by voltage": LIMIT, "largest current": CIRCLE}
    if motor.is_salient():
        marks["MTPA"] = MOST
    title = TITLE if shape.titled else None
    figure.legend(handles=[Line2D([], [], label=name, **how) for name, how in marks.items()], loc="upper left", title=title,
                  title_fontproperties={"size": shape.font + 2}, alignment="left", bbox_to_anchor=(0.0, 1.0), frameon=False,
                  ncols=len(marks) if shape.columns > 1 else 2, handlelength=1.8, columnspacing=1.3, borderaxespad=0.4)


def draw(run, shape):
    """Side by side, or below each other where there is no room for that."""
    motor, locus = Motor(run.metrics), Locus(run)
    rows, columns = (1, 2) if shape.columns > 1 else (2, 1)
    with matplotlib.rc_context(settings(shape)):
        figure = Figure(figsize=(shape.width, 0.7 + rows * 3.1))
        top = 1 - 0.75 / (0.7 + rows * 3.1)
        axes = figure.subplots(rows, columns, gridspec_kw={
            "left": 0.6 / shape.width, "right": 1 - 0.15 / shape.width, "top": top, "bottom": 0.13 / rows, "wspace": 0.25, "hspace": 0.35})
        draw_torque(axes[0], motor, locus)
        draw_currents(axes[1], motor, locus)
        legend(figure, motor, shape)
    return figure
