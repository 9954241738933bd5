# SPDX-License-Identifier: MIT
"""Tools start with any python3 and go on in the project's own, which has their packages."""

import importlib.util
import os
import sys
from pathlib import Path

# The matrices of the tools are small: threads of the linear algebra would cost several times what they compute.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
VENV = Path(__file__).resolve().parent.parent / ".cache" / "venv"


def missing(*modules):
    """What is missing here and in the project's environment, as text, or None. May start again there. Loads none of them."""
    absent = [module for module in modules if importlib.util.find_spec(module) is None]
    if not absent:
        return None
    python = VENV / "bin" / "python"
    if python.exists() and Path(sys.prefix) != VENV:
        os.execv(python, [str(python), *sys.argv])
    return f"no module {', '.join(absent)}; expected the packages of tools/requirements_checks.txt: run tools/dev setup"
