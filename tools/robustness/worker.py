# SPDX-License-Identifier: MIT
"""What runs on a worker of the cluster: one process of the simulator.

Travels to the workers by value, so it needs nothing but Python there.
"""

import hashlib
import os
import subprocess
import sys
import types
from pathlib import Path


def digests():
    """Those known in this process; code that travels has no module of its own to keep them in."""
    name = "neurofoc_digests"
    return vars(sys.modules.setdefault(name, types.ModuleType(name)))


def digest(path):
    """Of a file; read again only if it was written to."""
    status = os.stat(path)
    known, key = digests(), f"{path} {status.st_mtime_ns} {status.st_size}"
    if key not in known:
        known[key] = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    return known[key]


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
