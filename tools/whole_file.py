# SPDX-License-Identifier: MIT
"""Results that are there whole or not at all."""

import os
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path, **options):
    """A text file to write, which takes the place of `path` when all of it is written."""
    beside = Path(f"{path}.{os.getpid()}.part")
    try:
        with open(beside, "x", encoding="utf-8", **options) as file:
            yield file
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
