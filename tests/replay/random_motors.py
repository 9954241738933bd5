# SPDX-License-Identifier: MIT
"""Motors and boards as they could be bought: drawn by class, made from ratios that a designer of motors works with.

A motor of a class has a power, a speed, pole pairs and a bus voltage. From them follow, by drawn shares: the flux linkage by
the EMF's share of the voltage, R by the copper loss, L by the reactance, J by the time to accelerate with rated torque. Its
board has a converter somewhat larger than the largest current, and dead time by voltage.
"""

import math
from dataclasses import dataclass

G431_CLOCK_HZ = 170_000_000
ADC_REFERENCE_V = 3.3
PGA_GAINS = (2, 4, 8, 16, 32, 64)
POWER_A = (0.4, 120)  # of a power over its bus voltage: finer wire and thicker one are not wound
TUNINGS = ("robust",) * 8 + ("published", "voltage_phase")


@dataclass(frozen=True)
class Class:
    name: str
    bus_v: tuple      # what there is
    power_w: tuple    # from, to; but see POWER_A
    speed_rpm: tuple  # rated
    pole_pairs: tuple
    saliency: tuple   # L_q/L_d


CLASSES = (
    Class("gimbal", (12, 16, 24), (5, 40), (200, 2000), (7, 14), (1, 1.05)),
    Class("small servo", (12, 24), (10, 300), (2000, 8000), (2, 8), (1, 1.1)),
    Class("outrunner", (12, 16, 24, 36, 48), (50, 5000), (2000, 12000), (5, 21), (1, 1.1)),
    Class("hub", (24, 36, 48, 72), (150, 3000), (150, 900), (10, 25), (1, 1.3)),
    Class("servo", (48, 60, 310, 560), (100, 7500), (1500, 6000), (3, 10), (1, 1.4)),
    Class("compressor or fan", (24, 48, 310, 400), (50, 5000), (900, 9000), (1, 6), (1, 2.5)),
    Class("industrial", (310, 560, 650, 800), (750, 15000), (750, 4500), (1, 8), (1, 3)),
)


def log_uniform(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def draw_motor(rng, kind, bus_v):
    lowest, highest = kind.power_w
    power_w = log_uniform(rng, max(lowest, bus_v * POWER_A[0]), min(highest, bus_v * POWER_A[1]))
    speed_rpm = log_uniform(rng, *kind.speed_rpm)
    pole_pairs = rng.randint(*kind.pole_pairs)
    speed = speed_rpm * math.pi / 30
    torque_nm = power_w / speed
    emf_v = rng.uniform(0.5, 0.8) * bus_v / math.sqrt(3)
    flux_wb = emf_v / (speed * pole_pairs)
    current_a = torque_nm / (1.5 * pole_pairs * flux_wb)
    loss_share = min(0.4, 0.4 * (power_w / 5) ** -0.35) * rng.uniform(0.6, 1.5)
    reactance_ohm = rng.uniform(0.1, 0.5) * emf_v / current_a
    inductance_h = reactance_ohm / (speed * pole_pairs)
    # No field weakening: the highest speed is where the EMF ends.
    emf_room = 0.8 * bus_v / math.sqrt(3) / emf_v
    return {
        "name": f"{kind.name}, {power_w:.3g} W, {bus_v} V",
        "pole_pairs": pole_pairs,
        "resistance_ohm": loss_share * power_w / (1.5 * current_a**2),
        "inductance_d_h": inductance_h,
        "inductance_q_h": inductance_h * rng.uniform(*kind.saliency),
        "flux_linkage_wb": flux_wb,
        "rated_torque_nm": torque_nm,
        "rated_speed_rpm": speed_rpm,
        "max_speed_rpm": speed_rpm * rng.uniform(1.0, max(1.0, min(1.3, emf_room))),
        "max_current_a": current_a * rng.uniform(1.5, 3),
        "inertia_kg_m2": torque_nm * log_uniform(rng, 0.005, 1) / speed,
        "viscous_friction_nm_s": rng.uniform(0.005, 0.05) * torque_nm / speed,
    }


def draw_dead_time_s(rng, bus_v):
    if bus_v <= 72:
        return rng.uniform(0.1e-6, 0.8e-6)
    return rng.uniform(0.5e-6, 1.5e-6) if bus_v <= 400 else rng.uniform(0.8e-6, 2.5e-6)


def draw_board(rng, bus_v, max_current_a):
    frequency_hz = rng.choice((8e3, 10e3, 12e3, 16e3, 20e3, 24e3, 32e3, 40e3, log_uniform(rng, 8e3, 40e3)))
    dead_time_s = draw_dead_time_s(rng, bus_v)
    settling_s = rng.uniform(0.3e-6, 0.8e-6)
    full_scale_a = max_current_a * rng.uniform(1.3, 3)
    overcurrent_a = max_current_a * rng.uniform(1.05, 0.92 * full_scale_a / max_current_a)
    return {
        "name": f"{bus_v} V, {full_scale_a:.3g} A",
        "pwm_frequency_hz": frequency_hz,
        "timer_clock_hz": G431_CLOCK_HZ,
        "adc_bits": 12,
        "current_full_scale_a": full_scale_a,
        "bus_full_scale_v": bus_v * rng.uniform(1.3, 1.8),
        "bus_nominal_v": bus_v,
        "bus_min_v": bus_v * rng.uniform(0.4, 0.8),
        "bus_max_v": bus_v * rng.uniform(1.1, 1.28),
        "overcurrent_a": overcurrent_a,
        "trip_a": overcurrent_a * rng.uniform(1.02, 1.3),
        "offset_max_a": full_scale_a * rng.uniform(0.01, 0.05),
        # Half of the shortest low-side on-time, margin/4 of a period, holds dead time and settling.
        "duty_margin_pct": 100 * 4 * frequency_hz * (dead_time_s + settling_s) * rng.uniform(1.02, 1.5),
        "dead_time_s": dead_time_s,
        "device_drop_v": 0.0 if bus_v <= 72 else rng.uniform(0, 2),
        "offset_samples_log2": rng.randint(6, 10),
        "temperature_points_c": [-20, 0, 20, 40, 60, 80, 100, 120],
        "temperature_points_pct": [5.9, 14.28, 27.92, 44.72, 60.73, 73.31, 82.11, 87.91],
        "temperature_max_c": rng.uniform(70, 110),
        "recorder_entries": 1408,
    }, settling_s


def draw_hal(rng, board, settling_s):
    shunt_v = log_uniform(rng, 0.03, 0.2)  # at full scale
    gain = ADC_REFERENCE_V / 2 / shunt_v
    trip_v = ADC_REFERENCE_V / 2 * board["trip_a"] / board["current_full_scale_a"]
    pga_gain = rng.choice([gain for gain in PGA_GAINS if trip_v / gain >= 0.025])
    falls = trip_v < ADC_REFERENCE_V / 2 * 0.95 and rng.random() < 0.3
    return {
        "adc_settling_ns": settling_s * 1e9,
        "adc_sampling_ns": rng.uniform(50, min(1000, settling_s * 1e9)),
        "break_polarity": "active_low" if falls else "active_high",
        "shunt_ohm": shunt_v / board["current_full_scale_a"],
        "amplifier_gain": gain * rng.choice((-1, 1)),
        "amplifier_zero_v": ADC_REFERENCE_V / 2,
        "pga_gain": pga_gain,
        "adc_reference_v": ADC_REFERENCE_V,
        "bus_divider": ADC_REFERENCE_V / board["bus_full_scale_v"],
    }


def toml(sections):
    def shown(value):
        return f'"{value}"' if isinstance(value, str) else f"{value:.6g}" if isinstance(value, float) else str(value)
    return "\n".join(f"[{name}]\n" + "".join(f"{key} = {shown(value)}\n" for key, value in keys.items())
                     for name, keys in sections.items())


def write_case(rng, folder):
    """motor.toml, board.toml and scenario.toml of one motor on its board."""
    kind = rng.choice(CLASSES)
    bus_v = rng.choice(kind.bus_v)
    motor = draw_motor(rng, kind, bus_v)
    board, settling_s = draw_board(rng, bus_v, motor["max_current_a"])
    scenario = {
        "title": motor["name"],
        "mode": "speed",
        "duration_s": 0.01,
        "seed": rng.randrange(1 << 16),
        "initial_angle_el_deg": rng.uniform(0, 360),
        "initial_speed_rpm": rng.choice((0.0, motor["rated_speed_rpm"] * rng.uniform(-1, 1))),
    }
    folder.mkdir()
    (folder / "motor.toml").write_text(toml({"motor": motor}))
    (folder / "board.toml").write_text(toml({"board": board, "hal": draw_hal(rng, board, settling_s)}))
    (folder / "scenario.toml").write_text(
        f'motor = "./motor.toml"\nboard = "./board.toml"\ntuning = "{rng.choice(TUNINGS)}"\n'
        + toml({"scenario": scenario})
        + f'[[scenario.command]]\ntime_s = 0\nspeed_rpm = {motor["rated_speed_rpm"] / 2:.6g}\n')
