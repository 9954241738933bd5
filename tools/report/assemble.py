"""Write the report of a folder of runs: index.html and the figures as PNG files."""

import matplotlib

from report import claim, style
from report.caption import alternative, caption
from report.draw import draw
from report.layouts import layouts
from report.page import TITLES, Picture, page
from report.runs import PlotError, Run, read_runs
from report.svg import svg

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


def picture(run, layout, folder):
    trace, bases = run.trace, claim.bases(run)
    name = f"{run.name}_{layout.key}"
    save(draw(trace, layout, style.PRINT, bases), style.PRINT, folder / f"{name}.png")
    words = alternative(trace, layout, bases)
    forms = {shape: svg(draw(trace, layout, shape, bases), shape, f"{name}-{suffix}", words)
             for shape, suffix in ((style.WIDE, "w"), (style.NARROW, "n"))}
    return Picture(layout.title, caption(trace, layout, bases), forms[style.WIDE],
                   forms[style.NARROW], f"{name}.png")


def write_report(runs_folder, folder, more=()):
    """Returns the path of the page. What is in `more` takes the folder and gives an entry as of page()."""
    runs = sorted(read_runs(runs_folder), key=lambda run: run.scenario not in TITLES)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(f"{folder}: {error.strerror}; expected a folder to write to") from error
    entries = []
    for run in runs:
        shown = Run(run.name, run.trace.cut(start=0.0), run.metrics)
        entries.append((shown, [picture(shown, layout, folder) for layout in layouts(shown)]))
    path = folder / "index.html"
    path.write_text(page(entries, [make(folder) for make in more]), encoding="utf-8")
    return path
