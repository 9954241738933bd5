# SPDX-License-Identifier: MIT
"""ctest as a child: each test as it ends, with the processor time that it took.

ctest itself says how long a test took by the clock, which depends on what else the machine does. So the processes of each
test are looked at while they run. What a process uses after the last look is not seen: an error of LOOK_S at most.
"""

import re
import subprocess
import threading
from dataclasses import dataclass

import psutil

LOOK_S = 0.5
ENDED = re.compile(r"^\s*(?P<number>\d+)/(?P<total>\d+) Test\s+#\d+: (\S+) [.]+(.*?)\s+[\d.]+ sec")


@dataclass
class Ended:
    """A test that has ended."""

    name: str
    passed: bool
    core_seconds: float


def is_run_by(command, words):
    """Whether these are the words of a process of the test; a script has its interpreter before them."""
    return bool(words) and words[len(words) - len(command) + 1:] == command[1:] and command[0] in words


def used(process):
    """Processor time of the process, of its children that run, and of those that it has waited for."""
    total = 0.0
    for one in (process, *process.children(recursive=True)):
        try:
            total += sum(one.cpu_times()[:4])
        except psutil.Error:
            continue
    return total


class Looker(threading.Thread):
    """Looks at the children of a process until it is told to stop."""

    def __init__(self, parent, commands):
        super().__init__(daemon=True)
        self.parent, self.commands = psutil.Process(parent), commands
        self.names, self.most = {}, {}
        self.over = threading.Event()

    def run(self):
        while not self.over.wait(LOOK_S):
            try:
                children = self.parent.children()
            except psutil.Error:
                return
            for child in children:
                self.look_at(child)

    def look_at(self, child):
        try:
            name = self.names.get(child.pid) or self.name_of(child.cmdline())
            if name:
                self.names[child.pid] = name
                self.most[name] = max(self.most.get(name, 0.0), used(child))
        except psutil.Error:
            return

    def name_of(self, words):
        return next((name for name, command in self.commands.items() if is_run_by(command, words)), None)


def shown(lines):
    for line in lines:
        print(line, end="", flush=True)
        yield line


def own_lines(lines):
    """(name, result) of each test that has ended. The output of a test may have such lines of another ctest: those of
    this one count from 1 on and have the same total."""
    count, total = 0, None
    for found in filter(None, map(ENDED.match, lines)):
        if int(found["number"]) == count + 1 and total in (None, found["total"]):
            count, total = count + 1, found["total"]
            yield found[3], found[4].strip()


class Run:
    """One call of ctest. Iterated, it gives each test that has ended; then `status` is ctest's exit status."""

    def __init__(self, build, arguments, commands):
        """`commands`: name of a test → the words of its command."""
        self.words = ["ctest", "--test-dir", str(build), *arguments]
        self.commands = {name: list(map(str, command)) for name, command in commands.items()}
        self.status = None

    def __iter__(self):
        with subprocess.Popen(self.words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              errors="replace") as ctest:
            looker = Looker(ctest.pid, self.commands)
            looker.start()
            try:
                for name, result in own_lines(shown(ctest.stdout)):
                    yield Ended(name, result == "Passed", looker.most.get(name, 0.0))
            finally:
                looker.over.set()
        self.status = ctest.returncode
