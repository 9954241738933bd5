# SPDX-License-Identifier: MIT
"""Which panels make up the figure of a scenario."""

from dataclasses import dataclass, replace

from report.panels import ANGLES, CATALOGUE, I_D, I_Q, I_Q_ESTIMATED, Panel, speed


@dataclass(frozen=True)
class Layout:
    """Panels from top to bottom; those whose indices are in `same_range` share their y range."""

    key: str
    title: str
    panels: tuple
    same_range: tuple = ()


def lettered(*panels):
    return tuple(replace(panel, title=f"({letter}) {panel.title}")
                 for letter, panel in zip("abcdefgh", panels))


IQ_ACTUAL = Panel("actual q current", "A", (I_Q,))
IQ_ESTIMATED = Panel("estimated q current", "A", (I_Q_ESTIMATED,))
RESPONSE = lettered(
    Panel("command and actual speed", "rpm", speed("command", "actual")),
    Panel("command and estimated speed", "rpm", speed("command", "estimated")),
    IQ_ACTUAL, IQ_ESTIMATED,
    Panel("actual and estimated angle", "° el.", ANGLES, "zoom"))
POSITION = lettered(
    replace(CATALOGUE["position"], title="command, actual and estimated position"),
    Panel("actual and estimated speed", "rpm", speed("actual", "estimated")),
    Panel("actual and estimated angle", "° el.", ANGLES, "angle"),
    IQ_ACTUAL, IQ_ESTIMATED)
ERRORS = lettered(*(CATALOGUE[name] for name in (
    "command-error", "speed-error", "iq-error", "angle-error")))
VOLTAGE = lettered(
    Panel("command and actual speed", "rpm", speed("command", "actual")),
    Panel("actual d current", "A", (I_D,)), IQ_ACTUAL, CATALOGUE["voltage"], CATALOGUE["angle-error"])
VOLTAGE_FIGURE = (
    Layout("fig6", "Response to a step of the load without current regulators (paper B, fig. 6)", VOLTAGE),)

# The papers' figures, by scenario.
SCENARIOS = {
    "s1": (Layout("fig5", "Response to steps of the speed command (paper A, fig. 5)",
                  RESPONSE, (2, 3)),),
    "s2": (Layout("fig6", "Response to a step of the load (paper A, fig. 6)", RESPONSE, (2, 3)),
           Layout("fig8", "Errors through the step of the load (paper A, fig. 8)", ERRORS)),
    "s3": (Layout("fig7", "Position control (paper A, fig. 7)", POSITION, (3, 4)),),
    "s4": VOLTAGE_FIGURE,
    "s5": VOLTAGE_FIGURE,
}
OVERVIEW = ("state", "speed", "speed-error", "position", "angle-error", "iq", "id", "torque-command", "torque")

# Shown only where somebody asks for it.
COMMANDED = {"position": "position_command_rad", "torque-command": "torque_command_nm"}


def moves(trace, panel):
    """Whether the panel would show more than one constant value."""
    return any((trace[name] != trace[name][0]).any() for name in panel.columns())


def overview(trace):
    """The panels of any run: those of OVERVIEW whose columns are there and do something."""
    found = [CATALOGUE[name] for name in OVERVIEW if trace.has(CATALOGUE[name].columns())]
    for name, command in COMMANDED.items():
        if trace.has([command]) and not trace[command].any():
            found = [panel for panel in found if panel is not CATALOGUE[name]]
    return tuple(panel for panel in found if moves(trace, panel))


def layouts(run):
    """The figures of a run: a paper's, or the overview of a scenario the papers do not have."""
    if run.scenario in SCENARIOS:
        return SCENARIOS[run.scenario]
    panels = overview(run.trace)
    return (Layout("overview", "Overview of the run", panels),) if panels else ()
