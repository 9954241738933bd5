# SPDX-License-Identifier: MIT
"""Made-up runs that look like those of the simulator: a motor with a speed or position loop
and an estimate that lags behind it. Only for trying tools/plot.py without a simulator."""

import json
import math
import random

COLUMNS = (
    "time_s state speed_command_rpm speed_rpm speed_estimated_rpm speed_reference_rpm "
    "position_command_rad position_rad position_estimated_rad angle_el_deg "
    "angle_estimated_el_deg angle_error_el_deg i_q_a i_q_estimated_a i_q_reference_a i_d_a "
    "i_d_estimated_a i_a_a i_b_a i_c_a v_d_v v_q_v duty_a duty_b duty_c bus_v torque_command_nm load_torque_nm "
    "torque_nm fault").split()
RPM = 30 / math.pi
POLE_PAIRS, TORQUE_PER_A, INERTIA, LARGEST_A = 2, 1.161, 0.003, 10.0

SCENARIOS = {   # end, speed command, position command, load: each a function of the time
    "s1": (1.0, lambda t: 0 if t < 0.2 else 1000 if t < 0.6 else 1800, None, lambda t: 0),
    "s2": (1.0, lambda t: 1800, None, lambda t: 3 if 0.5 <= t < 0.8 else 0),
    "s3": (1.7, None, lambda t: 0 if t < 0.3 else 3 * math.pi if t < 1 else -3 * math.pi,
           lambda t: 0),
}


def limited(value, limit):
    return max(-limit, min(limit, value))


class Motor:
    """Rotor, cascaded control and estimate; one step is `period` seconds."""

    def __init__(self, period, speed_rpm, noise):
        self.period, self.noise = period, random.Random(noise)
        self.speed = self.estimate = speed_rpm / RPM
        self.position = self.integral = self.lag = self.current = 0.0

    def step(self, speed_rpm, position_rad, load_nm):
        target = speed_rpm / RPM if position_rad is None else limited(
            15 * (position_rad - self.position), 100)
        error = target - self.estimate
        wanted = limited(0.15 * error + self.integral, LARGEST_A)
        if abs(wanted) < LARGEST_A:
            self.integral += 4 * error * self.period
        self.current += (wanted - self.current) * min(1, self.period / 1e-3)
        torque = TORQUE_PER_A * self.current
        self.speed += (torque - load_nm - 0.001 * self.speed) / INERTIA * self.period
        self.position += self.speed * self.period
        before = self.estimate
        self.estimate += (self.speed - self.estimate) * min(1, self.period / 2e-3)
        self.lag = 1e-4 * (self.estimate - before) / self.period + 0.2 * self.noise.gauss(0, 0.2)
        return target, wanted, torque


def row(motor, time, command, position, load):
    target, wanted, torque = motor.step(command or 0, position, load)
    angle = math.degrees(POLE_PAIRS * motor.position)
    estimated = motor.current + motor.noise.gauss(0, 0.01)
    phases = [motor.current * -math.sin(math.radians(angle - k * 120)) for k in range(3)]
    volts = [-0.02 * motor.speed, 2.1 * motor.current + 0.77 * motor.speed]
    return [time, "RUN", target * RPM if command is None else command, motor.speed * RPM,
            motor.estimate * RPM, target * RPM, position or 0.0, motor.position,
            motor.position - math.radians(motor.lag) / POLE_PAIRS, angle % 360,
            (angle - motor.lag) % 360, motor.lag, motor.current, estimated, wanted,
            motor.noise.gauss(0, 0.01), motor.noise.gauss(0, 0.01), *phases, *volts,
            *[0.5 + p / 40 for p in phases], 310.0, 0.0, load, torque, 0]


def rows(scenario, period, prelude):
    end, speed, position, load = SCENARIOS[scenario]
    motor = Motor(period, speed(-1) if speed else 0, scenario)
    for k in range(-round(prelude / period), round(end / period) + 1):
        time = k * period
        yield row(motor, time, speed(time) if speed else None,
                  position(time) if position else None, load(time))


def metrics(scenario, table):
    speed_error = max(abs(r[3] - r[4]) for r in table)
    return {
        "scenario": scenario, "with": ["adc"], "seed": 1, "locked": True, "faults": [],
        "saturations": {"voltage": 12}, "saturation_internal_count": 0,
        "speed_error_max_rpm": speed_error, "speed_error_rms_rpm": speed_error / 4,
        "speed_error_max_pct": speed_error / 18,
        "command_error_settled_pct": None if scenario == "s3" else 0.12,
        "angle_error_max_deg": max(abs(r[11]) for r in table),
        "iq_error_max_a": max(abs(r[12] - r[13]) for r in table),
        "settling_time_s": 0.09, "overshoot_pct": 4.1, "speed_dip_rpm": 48.0,
        "recovery_time_s": 0.05, "id_settled_a": 0.01,
        "position_error_final_rad": 0.002 if scenario == "s3" else None,
    }


def text(cell):
    return cell if isinstance(cell, str) else f"{cell:.6g}"


def write(folder, name, scenario=None, period=1e-4, prelude=0.05):
    """Write NAME.csv and NAME.json into `folder`; returns the path of the trace."""
    scenario = scenario or name
    table = list(rows(scenario, period, prelude))
    lines = [",".join(COLUMNS)] + [",".join(map(text, cells)) for cells in table]
    path = folder / f"{name}.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / f"{name}.json").write_text(json.dumps(metrics(scenario, table)), encoding="utf-8")
    return path
