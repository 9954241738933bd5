# SPDX-License-Identifier: MIT
"""Write the report of a folder of runs: index.html and the figures as PNG files."""

import matplotlib

from report import claim, style, voltage_drive
from report.caption import alternative, caption
from report.draw import draw
from report.layouts import layouts
from report.page import TITLES, Picture, conditions, page
from report.runs import PlotError, Run, read_runs
from report.svg import svg
from whole_file import whole_file

PNG_DPI = 200
NO_METADATA = {"Software": None}


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


def picture(name, title, words, draw_shape, folder):
    """Writes name.png; draw_shape takes a Shape, words are (caption, alternative of the figure)."""
    save(draw_shape(style.PRINT), style.PRINT, folder / f"{name}.png")
    forms = {shape: svg(draw_shape(shape), shape, f"{name}-{suffix}", words[1])
             for shape, suffix in ((style.WIDE, "w"), (style.NARROW, "n"))}
    return Picture(title, words[0], forms[style.WIDE], forms[style.NARROW], f"{name}.png")


def picture_of_run(run, layout, folder):
    trace, bases = run.trace, claim.bases(run)
    words = caption(trace, layout, bases), alternative(trace, layout, bases)
    return picture(f"{run.name}_{layout.key}", layout.title, words,
                   lambda shape: draw(trace, layout, shape, bases), folder)


def make_folder(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(f"{folder}: {error.strerror}; expected a folder to write to") from error


def write_report(runs_folder, folder, more=()):
    """Returns the path of the page. What is in `more` takes the folder and gives an entry as of page()."""
    runs = sorted(read_runs(runs_folder), key=lambda run: run.scenario not in TITLES)
    make_folder(folder)
    entries = []
    for run in runs:
        shown = Run(run.name, run.trace.cut(start=0.0), run.metrics)
        entries.append((shown, [picture_of_run(shown, layout, folder) for layout in layouts(shown)]))
    path = folder / "index.html"
    made = page(entries, [*voltage_drive.entries([run for run, _ in entries], conditions),
                          *(make(folder) for make in more)])
    with whole_file(path) as file:
        file.write(made)
    return path
