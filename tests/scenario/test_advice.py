# SPDX-License-Identifier: MIT
"""The advice of a fault leads to what it was made by: causes injected into several motors, and which advice comes first.

test_advice.py MOTORSIM [--table]: --table prints each run, and the share for each fault. With many runs: each cause on each
motor, else each on one of them in turn.
"""

import collections
import concurrent.futures
import math
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import many_runs  # noqa: E402

MOTORSIM = sys.argv[1]
CORES = 2  # PROCESSORS of the test
ROOT = Path(__file__).resolve().parents[2] / "host_sim"
PAIRS = (("motor_a", "bench_310v"), ("odrive_d5065", "b_g431b_esc1"), ("teknic_m2310p", "frdm_mc_lvpmsm"),
         ("outrunner_24v", "b_g431b_esc1"), ("motor_b", "bench_310v"), ("compressor", "compressor_310v"))
LEAST_SHARE = 0.9  # of the runs that end in a fault: the first half of the advice names the cause or what ends it
# Each cause on one motor: a fifth of the runs, so the share has twice the spread, 0.04 rms of 0.93.
LEAST_SHARE_OF_FEW = 0.85
LEAST_FAULTS = 0.4  # of all runs: a large cause on a motor that bears it is no fault
BUS_STEPS = (0.05, 0.15)  # of the way from the lowest bus voltage to the nominal one


class Machine:
    def __init__(self, motor, board):
        self.motor, self.board = motor, board
        read = lambda kind, name: tomllib.loads((ROOT / kind / f"{name}.toml").read_text(encoding="utf-8"))
        self.of_motor = read("motors", motor)["motor"]
        self.of_board = read("boards", board)["board"]
        self.torque = self.of_motor["rated_torque_nm"]
        self.speed = self.of_motor["rated_speed_rpm"]

    def bus(self, name):
        return self.of_board[f"bus_{name}_v"]


def fault(what, time_s=1.2, value=None):
    return {"time_s": time_s, "what": what} | ({} if value is None else {"value": value})


def piston(machine, share, times):
    """A load that pulsates `times` in each turn, at a share of the rated speed."""
    period_s = 60 / (machine.speed * share * times)
    steps = 8
    count = math.ceil(3 / period_s * steps)
    return [(1 + k * period_s / steps, 0.9 * machine.torque * math.sin(2 * math.pi * k / steps)) for k in range(count)]


def elastic(hz, ratio, damping_pct):
    return [f"plant.shaft_resonance_hz={hz}", f"plant.load_inertia_ratio={ratio}", f"plant.shaft_damping_pct={damping_pct}"]


def loads_and_shafts(m):
    """(name, what the first half of the advice says, settings, load, commands in % of the rated speed, faults)"""
    for hz, ratio in ((130, 2), (160, 2), (220, 3), (300, 5)):
        yield f"elastic shaft, {hz} Hz", "notch", elastic(hz, ratio, 0.5), None, None, ()
    for hz, ratio in ((3, 20), (8, 12)):
        yield f"load on a soft shaft, {hz} Hz", "bandwidth", elastic(hz, ratio, 1), None, None, ()
    for ratio in (20, 40):
        yield f"J of the file {ratio} times too large", "bandwidth", [f"model.inertia={ratio}"], None, None, ()
    for share in (0.5, 0.8):
        for times in (1, 2):
            yield (f"load pulsates {times} times a turn, {share:g}", "pulsates", [], piston(m, share, times), [(0.1, 100 * share)], ())
    for share in BUS_STEPS:
        volt = m.bus("min") + share * (m.bus("nominal") - m.bus("min"))
        yield (f"bus low by {share:g} under load", "low bus", [], [(0.8, 0.8 * m.torque)], [(0.1, 100)],
               [fault("bus_voltage", value=volt)])
    for below_c in (1, 4):
        celsius = m.of_board.get("temperature_max_c", 100) - below_c
        yield (f"{below_c} K below the hottest under load", "heat or temperature", [], [(0.8, 0.8 * m.torque)], [(0.1, 100)],
               [fault("temperature", value=celsius)])
    yield "shaft blocked at the start", "free", [], None, None, [fault("rotor_blocked", 0)]
    yield "shaft blocked in RUN", "free|load", [], None, None, [fault("rotor_blocked")]
    yield "load of three times the rated torque", "load", [], [(1.2, 3 * m.torque)], None, ()
    yield "load of 1.5 times the rated torque at the start", "load", [], [(0, 1.5 * m.torque)], None, ()
    yield "load drives", "load", [], [(1.2, -2.2 * m.torque)], None, ()
    yield "load above the continuous current", "load", [], [(0.8, 1.25 * m.torque)], None, ()


def files_and_sensors(m):
    dead_time_s = m.of_board.get("dead_time_s", 1e-6)
    for gain in (15, 30):
        yield f"gains of the current sensors {gain} % apart", "sensor", [f"plant.adc_gain_error_pct=[{gain},-{gain}]"], None, None, ()
    for noise in (15, 40, 100):
        yield f"noise of {noise} LSB", "noisy", [f"plant.adc_noise_lsb={noise}"], None, None, ()
    yield "zero of a current sensor", "sensor", ["plant.adc_offset_lsb=[400,0]"], None, None, ()
    for times in (2, 3):
        yield f"dead time of the file {times} times", "dead time", [f"model.dead_time_s={times * dead_time_s}"], None, None, ()
    for name, value, says in (("resistance", 3, r"\bR\b"), ("resistance", 0.3, r"\bR\b"), ("inductance", 3, r"\bL\b|bandwidth"),
                              ("inductance", 0.3, r"\bL\b"), ("flux", 2, "flux"), ("flux", 0.5, "flux|bandwidth")):
        yield f"{name} of the file {value:g} times", says, [f"model.{name}={value}"], None, None, ()


def broken(m):
    for phase in "abc":
        for when, time_s in (("in RUN", 1.2), ("at the start", 0)):
            yield f"wire {phase} open {when}", "wire", [], None, None, [fault(f"phase_{phase}_open", time_s)]
    for phase in "ab":
        for when, time_s in (("in RUN", 1.2), ("at the start", 0)):
            yield f"current sensor {phase} stuck {when}", "sensor", [], None, None, [fault(f"adc_{phase}_stuck", time_s)]
        yield f"current sensor {phase} at its end", "sensor", [], None, None, [fault(f"adc_{phase}_high")]
    yield "break", "short", [], None, None, [fault("break_input")]
    yield "late ticks", "late|interrupt", [], None, None, [fault("late_isr", 1.2 + 0.0005 * k) for k in range(40)]
    yield "configuration changed", "image", [], None, None, [fault("config_corrupt", 0.2, 40)]


def of_supply(m):
    yield "supply too high in RUN", "supply", [], None, None, [fault("bus_voltage", value=1.03 * m.bus("max"))]
    yield "supply too high at rest", "supply", [], None, None, [fault("bus_voltage", 0, 1.03 * m.bus("max"))]
    yield "supply off", "off", [], None, None, [fault("bus_voltage", value=0.1 * m.bus("nominal"))]
    yield "supply too weak", "weak", [], None, None, [fault("bus_voltage", value=0.95 * m.bus("min"))]
    ohm = 0.02 * m.bus("nominal") / m.of_motor["max_current_a"]
    farad = 0.05 * m.of_motor["max_current_a"] / m.bus("nominal")
    yield ("braking into a rectifier", "brak", [f"plant.bus_capacitance_f={farad}", f"plant.bus_source_resistance_ohm={ohm}"], [(0, 0)],
           [(0.1, 100), (1.2, -100)], ())
    yield "too hot", "hot", [], None, None, [fault("temperature", value=m.of_board.get("temperature_max_c", 100) + 10)]
    if 0 < m.of_board.get("temperature_points_pct", [0])[0] < 100:  # else an end of the converter is a temperature
        yield "NTC open", "open", [], None, None, [fault("temperature", 0.3, -200)]
        yield "NTC shorted", "shorted", [], None, None, [fault("temperature", 0.3, 250)]


def causes(machine):
    for group in (loads_and_shafts, files_and_sensors, broken, of_supply):
        yield from group(machine)


def entry(table, values):
    lines = [f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value:.6g}" if key != "time_s" else f"{key} = {value:.6f}"
             for key, value in values.items()]
    return f"[[scenario.{table}]]\n" + "\n".join(lines) + "\n"


def scenario(machine, load, commands, faults):
    text = (f'base = "any"\nmotor = "{machine.motor}"\nboard = "{machine.board}"\n'
            '[scenario]\ntitle = "a cause"\nmode = "speed"\nduration_s = 4\n')
    for time_s, torque in load or ():
        text += entry("load", {"time_s": time_s, "torque_nm": torque})
    for time_s, pct in commands or ():
        text += entry("command", {"time_s": time_s, "speed_pct": pct})
    return text + "".join(entry("fault", one) for one in faults)


def found(job):
    """The first fault's name, and whether its advice begins with the cause; None without a fault."""
    machine, (name, says, settings, load, commands, faults) = job
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cause.toml"
        path.write_text(scenario(machine, load, commands, faults), encoding="utf-8")
        sets = [word for one in settings for word in ("--set", one)]
        run = subprocess.run([MOTORSIM, "run", path, "--with", "adc", *sets], capture_output=True, text=True, check=False)
    if run.returncode not in (0, 1):
        raise AssertionError(f"{machine.motor}, {name}: {run.stderr}")
    fault_lines = re.search(r"^  fault  +(\w+)@.*\n +(.*)\n +(.*)$", run.stdout, re.M)
    if not fault_lines:
        return None
    first = fault_lines[3].split(";")[0]
    if "--table" in sys.argv:
        print(f"{machine.motor:14} {name:46} {fault_lines[2]:52} {'' if re.search(says, first) else 'NOT '}{first}")
    return fault_lines[1], bool(re.search(says, first))


def all_found(many):
    machines = [Machine(*pair) for pair in PAIRS]
    jobs = [(machine, cause) for place, machine in enumerate(machines) for k, cause in enumerate(causes(machine))
            if many or k % len(machines) == place]
    with concurrent.futures.ThreadPoolExecutor(CORES) as pool:
        return list(pool.map(found, jobs))


class Advice(unittest.TestCase):
    def test_the_first_advice_names_the_cause_or_what_ends_it(self):
        many = many_runs.are_asked()
        runs = all_found(many)
        ended = [one for one in runs if one]
        self.assertGreater(len(ended), LEAST_FAULTS * len(runs))
        shares = collections.defaultdict(list)
        for name, is_right in ended:
            shares[name].append(is_right)
        text = "\n".join(f"{name:20} {sum(all_):3} of {len(all_):3}" for name, all_ in sorted(shares.items()))
        right = sum(is_right for _, is_right in ended) / len(ended)
        if "--table" in sys.argv:
            print(f"{text}\n{len(runs)} runs, {len(ended)} faults, {100 * right:.1f} % right")
        self.assertGreaterEqual(right, LEAST_SHARE if many else LEAST_SHARE_OF_FEW, text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
