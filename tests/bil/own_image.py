# SPDX-License-Identifier: MIT
"""Images for motors and boards of one's own, whose files lie outside of the project."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ROOT / "host_sim"


def replaced(path, *pairs):
    """A shipped file with some lines changed."""
    text = path.read_text(encoding="utf-8")
    for old, new in pairs:
        if old not in text:
            raise ValueError(f"{path} has no line {old}")
        text = text.replace(old, new)
    return text


def build_image(folder, nfconfig, motor, board, tuning="any"):
    """In a folder, from which the paths of both files are. Again, with others, for a part of the time."""
    for command in (["cmake", "-S", ROOT, "--preset", "stm32g4", "-B", "build", f"-DNF_NFCONFIG={nfconfig}",
                     f"-DNF_MOTOR={motor}", f"-DNF_BOARD={board}", f"-DNF_TUNING={tuning}"],
                    ["cmake", "--build", "build", "--target", "neurofoc_g4"]):
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if run.returncode:
            raise AssertionError(run.stdout + run.stderr)
    return folder / "build/neurofoc_g4.elf"
