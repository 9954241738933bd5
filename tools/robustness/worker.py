"""What runs on a worker of the cluster: one process of the simulator.

Travels to the workers by value, so it needs nothing but Python there.
"""

import hashlib
import os
import subprocess
from functools import lru_cache
from pathlib import Path


@lru_cache(maxsize=64)
def digest_of_version(path, modified_ns, size):
    """Of a file as it was at a time; the time is what makes the cache true."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def digest(path):
    status = os.stat(path)
    return digest_of_version(str(path), status.st_mtime_ns, status.st_size)


def fingerprint(motorsim, data_files):
    """One text for the simulator and one for all files that it may read."""
    names = "".join(f"{path} {digest(path)}\n" for path in data_files)
    return {"simulator": digest(motorsim), "data files": hashlib.sha256(names.encode()).hexdigest()}


def simulate(run, command, data_files, expected):
    """The run's number, exit status, standard output and last line of standard error.

    The process has a session of its own: Ctrl-C ends the campaign, not half of its runs.
    """
    found = fingerprint(command[0], data_files)
    for what, text in expected.items():
        if found[what] != text:
            raise RuntimeError(f"the {what} changed, or {os.uname().nodename} has others")
    done = subprocess.run(command, capture_output=True, text=True, check=False,
                          start_new_session=True)
    return run, done.returncode, done.stdout, done.stderr.strip().rpartition("\n")[2]
