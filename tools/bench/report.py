# SPDX-License-Identifier: MIT
"""All figures of a measurement, as plain values: the JSON file, and what tables and budget show."""

from collections import Counter

from . import cycles, profile, sizes, stack
from .replay import ENTRY

# What a complete RUN tick may cost, instructions: mean and max.
GOALS = {"cortex-m0plus": (600, 800), "cortex-m3": (330, 440), "cortex-m4": (300, 400)}
CORE_LIMIT = 16 * 1024
STATE_LIMIT = 2 * 1024


def collect(benches):
    """The figures by core: ticks and stack by tuning; of the first tuning the sizes of the image and RUN by source file."""
    report = {}
    for bench in benches:
        of_core = report.setdefault(bench.core, {"ticks": {}, "stack": {}})
        costs = costs_of(bench)
        of_core["ticks"][bench.tuning] = {state: ticks(bench, costs, state)
                                          for state in bench.states}
        of_core["stack"][bench.tuning] = stack_of(bench)
        if "sizes" not in of_core:
            of_core["sizes"] = sizes_of(bench.image)
            of_core["run_by_file"] = by_file(bench)
    return report


def costs_of(bench):
    """Instructions and the models' cycles of each way that a tick took, in any state."""
    models = [model for model in cycles.MODELS if model.core == bench.core]
    clocks = {model.title: cycles.Clock(model) for model in models}
    costs = {}
    for way in {way for replay in bench.replays for _, way in replay.ways}:
        blocks = bench.blocks(way)
        costs[way] = {title: clock.cycles(blocks, way[-1]) for title, clock in clocks.items()}
        costs[way]["instructions"] = sum(len(block.instructions) for block in blocks)
    return costs


def ticks(bench, costs, state):
    """Instructions and cycles of a state's ticks, over all scenarios and in each."""
    found = summary(costs, bench.ways(state))
    found["scenarios"] = {}
    for replay in bench.replays:
        ways = {way: n for (of, way), n in replay.ways.items() if of == state}
        if ways:
            found["scenarios"][replay.scenario] = summary(costs, ways)
    return found


def summary(costs, ways):
    """Mean and maximum over the ticks that took these ways; of cycles at best and at worst."""
    count = {way: costs[way]["instructions"] for way in ways}
    found = {"ticks": sum(ways.values()), "mean": mean(count, ways), "max": max(count.values()),
             "cycles": {}}
    for title in next(iter(costs.values())):
        if title != "instructions":
            ends = [{way: costs[way][title][end] for way in ways} for end in (0, 1)]
            found["cycles"][title] = {"mean": [mean(end, ways) for end in ends],
                                      "max": [max(end.values()) for end in ends]}
    return found


def mean(values, ways):
    return round(sum(values[way] * n for way, n in ways.items()) / sum(ways.values()), 2)


def stack_of(bench):
    size, chain = stack.computed(bench.image, ENTRY)
    return {"measured": max(replay.stack_bytes for replay in bench.replays), "computed": size,
            "deepest": list(chain)}


def by_file(bench):
    """Mean instructions of a RUN tick by source file."""
    found = Counter()
    for share in profile.profile(bench, "RUN"):
        found[share.file] += share.mean
    return {file: round(mean, 1) for file, mean in found.most_common()}


def sizes_of(image):
    found = sizes.measure(image)
    return {"code": found.code, "constants": found.constants, "variables": found.variables,
            "sections": found.sections, "core": found.core, "state": found.state}


def figures(report):
    """What the budget bounds: {group: {figure: value}}."""
    found = {}
    for core, of_core in report.items():
        for tuning, states in of_core["ticks"].items():
            group = found[f"{core}.{tuning}"] = {"run_mean_instructions": states["RUN"]["mean"]}
            for state, of_state in states.items():
                group[f"{state.lower()}_max_instructions"] = of_state["max"]
            group["stack_measured_bytes"] = of_core["stack"][tuning]["measured"]
            group["stack_computed_bytes"] = of_core["stack"][tuning]["computed"]
        found[f"{core}.sizes"] = {
            "core_code_and_tables_bytes": of_core["sizes"]["core"],
            "state_bytes": of_core["sizes"]["state"],
            "data_bytes": of_core["sizes"]["sections"][".data"],
            "bss_bytes": of_core["sizes"]["sections"][".bss"],
        }
    return found
