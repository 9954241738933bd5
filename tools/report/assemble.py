# SPDX-License-Identifier: MIT
"""Write the report of a folder of runs: index.html and the figures as PNG files."""

from report import claim, voltage_drive, weakening
from report.caption import alternative, caption
from report.draw import draw
from report.layouts import layouts
from report.page import TITLES, conditions, page
from report.picture import make_folder, picture
from report.runs import Run, read_runs
from whole_file import whole_file


def picture_of_run(run, layout, folder):
    trace, bases = run.trace, claim.bases(run)
    words = caption(trace, layout, bases), alternative(trace, layout, bases)
    return picture(f"{run.name}_{layout.key}", layout.title, words,
                   lambda shape: draw(trace, layout, shape, bases), folder)


def pictures_of_run(run, folder):
    found = [picture_of_run(run, layout, folder) for layout in layouts(run)]
    if weakening.goes_beyond(run):
        found.append(picture(f"{run.name}_{weakening.KEY}", weakening.TITLE, (weakening.WORDS, f"{weakening.TITLE}. {weakening.WORDS}"),
                             lambda shape: weakening.draw(run, shape), folder))
    return found


def write_report(runs_folder, folder, more=()):
    """Returns the path of the page. What is in `more` takes the folder and gives an entry as of page()."""
    runs = sorted(read_runs(runs_folder), key=lambda run: run.scenario not in TITLES)
    make_folder(folder)
    entries = []
    for run in runs:
        shown = Run(run.name, run.trace.cut(start=0.0), run.metrics)
        entries.append((shown, pictures_of_run(shown, folder)))
    path = folder / "index.html"
    made = page(entries, [*voltage_drive.entries([run for run, _ in entries], conditions),
                          *(make(folder) for make in more)])
    with whole_file(path) as file:
        file.write(made)
    return path
