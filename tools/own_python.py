# SPDX-License-Identifier: MIT
"""Tools start with any python3 and go on in the project's own, which has their packages."""

import importlib
import os
import sys
from pathlib import Path

VENV = Path(__file__).resolve().parent.parent / ".cache" / "venv"


def missing(*modules):
    """What is missing here and in the project's environment, as text, or None. May start again there."""
    try:
        for module in modules:
            importlib.import_module(module)
    except ImportError as error:
        python = VENV / "bin" / "python"
        if python.exists() and Path(sys.prefix) != VENV:
            os.execv(python, [str(python), *sys.argv])
        return f"{error}; expected the packages of tools/requirements.txt: run tools/dev setup"
    return None
