#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Figures: one simulated run, a report of all, what the dead time does, a gain design.

Runs come from the simulator, which writes a trace and the metrics of a scenario, designs from
gaindesign:

  build/host/motorsim run s1 --trace build/runs/s1.csv --json build/runs/s1.json
  build/host/gaindesign design --json build/design.json

Exit status: 0 done, 2 a file, a column or an argument is missing or wrong.
`tools/plot.py COMMAND --help` tells more of each command.
"""

import argparse
import sys
from pathlib import Path

import own_python
import user_text
from deadtime.points import SETS

TRACE_HELP = """One run as a figure: panels over one time axis, steps of the command and load marked.

  tools/plot.py trace build/runs/s2.csv
  tools/plot.py trace build/runs/s2.csv --panels speed,iq,angle-error --from 0.48 --to 0.6

"""
REPORT_HELP = """All runs of a folder as one page, index.html, with the figures of paper A
(fig. 5 to 8) and paper B, the measured errors beside the paper's claim of 2 %, and all metrics.

  tools/plot.py report --runs build/runs --out build/report

Each run is a trace, NAME.csv, and its metrics, NAME.json. The scenario in the metrics decides
the figures: s1 to s5 get the papers', any other an overview. The part before t = 0 is
not drawn.
"""
DESIGN_HELP = """A gain design as the figures 3, 4a, 4b, 5a, 5b and 6 of paper B: the stable region with
the paper's gains and the ones found, and the step responses, for each set of matrices.

  build/host/gaindesign design --json build/design.json
  tools/plot.py design build/design.json --out build/report

"""
DEADTIME_HELP = """What giving the dead time back does: motor A at constant speeds under constant loads, with
and without, each a run of the simulator. A figure of currents, angle errors and harmonics, and a table
of THD, ripples and angle errors, which is printed.

  tools/plot.py deadtime --out build/deadtime     deadtime.png, deadtime.json
  tools/plot.py report --deadtime build/deadtime/deadtime.json
"""
MOTORSIM = Path(__file__).resolve().parent.parent / "build" / "host" / "motorsim"


def chosen_panels(names, trace):
    from report.layouts import OVERVIEW, overview
    from report.panels import CATALOGUE
    from report.runs import PlotError
    if names is None:
        panels = overview(trace)
        if not panels:
            raise PlotError(f"{trace.path}: nothing to show; expected the columns of one of the "
                            f"panels {', '.join(OVERVIEW)}, and a value that changes")
        return panels
    unknown = [name for name in names if name not in CATALOGUE]
    if unknown:
        raise PlotError(f"--panels: no panel '{unknown[0]}'; "
                        f"expected names out of: {', '.join(CATALOGUE)}")
    return tuple(CATALOGUE[name] for name in names)


def trace_command(args):
    from report import style
    from report.draw import draw
    from report.layouts import Layout
    from report.picture import save
    from report.runs import read_trace
    trace = read_trace(args.file).cut(args.start, args.end)
    panels = chosen_panels(args.panels, trace)
    layout = Layout("trace", args.title or args.file.stem, panels)
    out = args.out or args.file.with_suffix(".png")
    save(draw(trace, layout, style.PRINT), style.PRINT, out)
    print(out)


def report_command(args):
    from report.assemble import write_report
    more = []
    if args.deadtime:
        from deadtime import measure, section
        measurement = measure.read(args.deadtime)
        more.append(lambda folder: section.entry(measurement, folder))
    if args.design:
        from report import design_section
        more.append(lambda folder: design_section.entry(args.design, folder))
    print(write_report(args.runs, args.out, more))


def deadtime_command(args):
    from deadtime import figure, measure, table
    from report import style
    from report.picture import save
    measurement = measure.measure(args.motorsim, args.sets or SETS)
    path = args.out / f"{figure.KEY}.json"
    measure.write(measurement, path)
    print(table.text(measurement))
    save(figure.draw(measurement, style.PRINT), style.PRINT, path.with_suffix(".png"))
    print(path.with_suffix(".png"))


def design_command(args):
    from report.gains import write_figures
    for path in write_figures(args.file, args.out):
        print(path)


def panel_list():
    from report.panels import CATALOGUE
    lines = [f"  {name:<15} {panel.title}{f', {panel.unit}' if panel.unit else ''}"
             for name, panel in CATALOGUE.items()]
    return "Panels:\n" + "\n".join(lines)


def add_command(commands, name, run, words, help_text, epilog=None):
    parser = commands.add_parser(name, help=words, description=help_text, epilog=epilog,
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(run=run)
    return parser


def add_folder(parser, default):
    parser.add_argument("--out", type=Path, default=Path(default), metavar="DIR",
                        help=f"folder to write to (default: {default})")


def add_trace(commands):
    parser = add_command(commands, "trace", trace_command, "one run as a figure", TRACE_HELP,
                         panel_list())
    parser.add_argument("file", type=Path, metavar="FILE.csv", help="the trace")
    parser.add_argument("--out", type=Path, metavar="FILE",
                        help="picture to write: .png, .svg or .pdf (default: FILE.png)")
    parser.add_argument("--panels", type=lambda text: text.split(","), metavar="NAME,...",
                        help="panels from top to bottom (default: those that show something)")
    parser.add_argument("--from", type=float, default=0.0, dest="start", metavar="S",
                        help="start, seconds (default: 0; before it lies the run-up)")
    parser.add_argument("--to", type=float, dest="end", metavar="S",
                        help="end, seconds (default: the end of the trace)")
    parser.add_argument("--title", help="title of the figure (default: the name of the file)")


def add_report(commands):
    parser = add_command(commands, "report", report_command, "all runs of a folder as one page",
                         REPORT_HELP)
    parser.add_argument("--runs", type=Path, default=Path("build/runs"), metavar="DIR",
                        help="folder of the runs (default: build/runs)")
    add_folder(parser, "build/report")
    parser.add_argument("--deadtime", type=Path, metavar="FILE",
                        help="deadtime.json of `tools/plot.py deadtime`, for a section of its own")
    parser.add_argument("--design", type=Path, metavar="FILE",
                        help="output of `gaindesign design --json`, likewise")


def add_deadtime(commands):
    parser = add_command(commands, "deadtime", deadtime_command,
                         "what giving the dead time back does", DEADTIME_HELP)
    parser.add_argument("--motorsim", type=Path, default=MOTORSIM, metavar="FILE",
                        help="the simulator (default: build/host/motorsim)")
    parser.add_argument("--with", dest="sets", action="append", choices=SETS,
                        help="a set of imperfections with a dead time; several add up (default: all three)")
    add_folder(parser, "build/deadtime")


def add_design(commands):
    parser = add_command(commands, "design", design_command, "the figures of a gain design",
                         DESIGN_HELP)
    parser.add_argument("file", type=Path, metavar="FILE.json", help="output of gaindesign")
    add_folder(parser, "build/report")


def main(arguments=None):
    problem = own_python.missing("jinja2", "matplotlib", "numpy")
    if problem:
        sys.exit(f"plot.py: {problem}")
    from report.runs import PlotError
    parser = user_text.Parser(
        prog="plot.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    add_trace(commands)
    add_report(commands)
    add_deadtime(commands)
    add_design(commands)
    args = parser.parse_args(arguments)
    try:
        args.run(args)
    except PlotError as error:
        user_text.tell("plot.py", error)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
