# SPDX-License-Identifier: MIT
"""Datagrams of `motorsim live --udp`: JSON that another parser reads, one object each, as PlotJuggler's UDP streaming wants it."""

import json
import socket
import subprocess
import sys
import unittest

EVERY = 10
TICK_S = 1e-4
# Room for all of the run, so that a slow reader loses none.
BUFFER_BYTES = 4 << 20


def numbers(value, path=""):
    """Path and value of each leaf."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{path}/{key}")
    else:
        yield path, value


def refuse_constant(name):
    raise ValueError(f"{name} is not JSON")


def received():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(0.2)
        port = listener.getsockname()[1]
        subprocess.run([PROGRAM, f"127.0.0.1:{port}", str(EVERY)], check=True)
        texts = []
        try:
            while True:
                texts.append(listener.recv(65536))
        except TimeoutError:
            return texts


class Datagrams(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.objects = [json.loads(text, parse_constant=refuse_constant) for text in received()]

    def test_each_is_an_object_with_a_time_and_nothing_but_numbers(self):
        self.assertGreater(len(self.objects), 10)
        for one in self.objects:
            self.assertIsInstance(one, dict)
            self.assertIn("timestamp", one)
            for path, value in numbers(one):
                self.assertIs(type(value) in (int, float), True, path)

    def test_the_time_goes_on_by_every_tenth_tick(self):
        times = [one["timestamp"] for one in self.objects]
        for before, after in zip(times, times[1:]):
            # Times are multiples of a tick; a double holds them to some 1e-15.
            self.assertAlmostEqual(after - before, EVERY * TICK_S, delta=1e-9)

    def test_values_are_nested_by_quantity(self):
        paths = {path for path, _ in numbers(self.objects[-1])}
        self.assertLessEqual({"/state", "/speed/estimated_rpm", "/current/q_a", "/voltage/bus_v"}, paths)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
