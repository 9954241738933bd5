# SPDX-License-Identifier: MIT
"""The image in the emulator with its USART on a pseudo-terminal, as a board on a serial port.

port.py IMAGE BOARD CLOCK BIL_MOTOR: boots the image with motor A's machine, prints the name of the pseudo-terminal, and ticks
until its input ends. Each line of that input is obeyed between two ticks: `open phase a`, `open phase none`, `load 2.0` (N·m).
"""

import os
import sys
import time
import tty
from pathlib import Path

import digital
import machine

SCENARIO = "s1_robust"  # motor A
AT_ONCE = 4096
WAITS_S = 0.001
PHASES = {"none": 0, "a": 1, "b": 2, "c": 4}  # bil_motor has a bit for each


class WrongWord(Exception):
    """A line that is not understood."""


def read_at_once(file):
    """What is there: nothing is b"", the end is None."""
    try:
        return os.read(file, AT_ONCE) or None
    except BlockingIOError:
        return b""


class Port(machine.Bench):
    """The bench, whose console is on a pseudo-terminal."""

    def __init__(self, image, board, clock, bil_motor, machine_settings=(), flashed=()):
        self.master, self.port = os.openpty()
        tty.setraw(self.port)
        os.set_blocking(self.master, False)
        self.name = os.ttyname(self.port)
        super().__init__(image, board, clock, [bil_motor, SCENARIO, f"board={board}", *machine_settings], instant=False,
                         flashed=flashed)

    def close(self):
        super().close()
        os.close(self.master)
        os.close(self.port)

    def hear(self):
        usart = self.board.chip.usart
        try:
            os.write(self.master, bytes(usart.said))
        except BlockingIOError:
            pass  # nobody reads: it is lost, as on a line
        usart.said.clear()

    def tick(self, ticks=1):
        for _ in range(ticks):
            if said := read_at_once(self.master):
                self.board.chip.usart.receive(said)
            super().tick()

    def obey(self, line):
        """What happens to the motor."""
        word, _, value = line.rpartition(" ")
        if word == "open phase" and value in PHASES:
            self.broken = PHASES[value]
        elif word == "load":
            self.load_nm = load_of(value)
        else:
            raise WrongWord(f"the line is \"{line}\"; allowed: `open phase` with {', '.join(PHASES)}, or `load` with N·m")


class ReadPort(Port):
    """Its time stands while its reader, a process, is behind: nothing is lost on a machine that has much else to do.

    pace: it is no faster than so many seconds of the board in one of this machine. A reader that is told so waits and asks in
    its seconds, and the board has to wait for it in the same ones.
    """

    reader = None
    pace = None

    ahead_since = None  # the board's time less that of this machine, both in seconds of this machine

    def tick(self, ticks=1):
        super().tick(ticks)
        if self.pace:
            self.wait(self.board.chip.now / digital.CLOCK_HZ / self.pace)

    def wait(self, board_s):
        """What a slow machine has lost is not made up for."""
        ahead = board_s - time.monotonic()
        self.ahead_since = ahead if self.ahead_since is None else min(self.ahead_since, ahead)
        if ahead > self.ahead_since + WAITS_S:
            time.sleep(ahead - self.ahead_since)

    def hear(self):
        said = bytes(self.board.chip.usart.said)
        self.board.chip.usart.said.clear()
        while said and self.reader and self.reader.poll() is None:
            try:
                said = said[os.write(self.master, said):]
            except BlockingIOError:
                time.sleep(WAITS_S)


def load_of(text):
    try:
        return float(text)
    except ValueError:
        raise WrongWord(f"load = \"{text}\"; allowed: a number, in N·m") from None


def obey_until_end(port):
    """Lines of standard input, which may come in pieces."""
    os.set_blocking(sys.stdin.fileno(), False)
    rest = b""
    while (more := read_at_once(sys.stdin.fileno())) is not None:
        *lines, rest = (rest + more).split(b"\n")
        for line in lines:
            port.obey(line.decode(errors="replace"))
        port.tick()


def main():
    port = Port(*(Path(argument).resolve() for argument in sys.argv[1:5]))
    try:
        print(port.name, flush=True)
        obey_until_end(port)
    except WrongWord as wrong:
        sys.exit(f"port.py: {wrong}")
    finally:
        port.close()


if __name__ == "__main__":
    main()
