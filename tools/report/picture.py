# SPDX-License-Identifier: MIT
"""Figures as files, and in the forms that a page shows them in."""

from dataclasses import dataclass

import matplotlib

from report import style
from report.runs import PlotError
from report.svg import svg

PNG_DPI = 200
NO_METADATA = {"Software": None}


@dataclass(frozen=True)
class Picture:
    """A figure in the forms that a page and its reader need."""

    title: str
    caption: str
    wide: str       # <svg> elements
    narrow: str
    file: str       # a PNG beside the page


def save(figure, shape, path):
    """Write a figure; the suffix of the path decides the format."""
    metadata = {".png": NO_METADATA, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    try:
        with matplotlib.rc_context(style.settings(shape)):
            figure.savefig(path, dpi=PNG_DPI, metadata=metadata.get(path.suffix))
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}; expected a place to write to") from error
    except ValueError as error:
        raise PlotError(f"{path}: {error}; expected .png, .svg or .pdf") from error


def make_folder(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(f"{folder}: {error.strerror}; expected a folder to write to") from error


def picture(name, title, words, draw_shape, folder):
    """Writes name.png; draw_shape takes a Shape, words are (caption, alternative of the figure)."""
    save(draw_shape(style.PRINT), style.PRINT, folder / f"{name}.png")
    forms = {shape: svg(draw_shape(shape), shape, f"{name}-{suffix}", words[1])
             for shape, suffix in ((style.WIDE, "w"), (style.NARROW, "n"))}
    return Picture(title, words[0], forms[style.WIDE], forms[style.NARROW], f"{name}.png")
