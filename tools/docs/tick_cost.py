# SPDX-License-Identifier: MIT
"""The tables of docs/cost.md that say what a tick in RUN takes, out of what target.cost has counted.

tick_cost.py COST.JSON           says whether the page is as it was counted; exit status 1 if not
tick_cost.py COST.JSON --write   writes the tables anew
"""
import argparse
import json
from pathlib import Path

import generated

CORES = {"cortex-m4": "Cortex-M4", "cortex-m3": "Cortex-M3", "cortex-m0plus": "Cortex-M0+"}
TUNINGS = {"published": "published tuning", "robust": "robust tuning, every imperfection", "voltage_phase": "voltage drive, S5"}
LEAST = 10  # instructions of a file that the page names
AIM = ["aim", "300 / 400", "330 / 440", "600 / 800"]


def run_ticks(cost):
    def of(core, tuning):
        ticks = cost[core]["ticks"][tuning]["RUN"]
        return f"{ticks['mean']:.0f} / {ticks['max']}"

    rows = [[name, *(of(core, tuning) for core in CORES)] for tuning, name in TUNINGS.items()]
    return generated.table(["", *CORES.values()], [AIM, *rows])


def by_file(cost):
    """A header counts to its source."""
    found = {}
    for file, mean in cost["cortex-m4"]["run_by_file"].items():
        name = file.removesuffix(".h").removesuffix(".c")
        found[name] = found.get(name, 0) + mean
    largest = sorted(found.items(), key=lambda pair: -pair[1])
    rows = {f"`{name}`": mean for name, mean in largest if mean >= LEAST}
    rows["the rest"] = sum(found.values()) - sum(rows.values())
    return generated.table(["source", "instructions"], ([name, f"{mean:.0f}"] for name, mean in rows.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cost", type=Path, metavar="COST.JSON", help="as tools/bench_target.py --json has written it")
    parser.add_argument("--write", action="store_true", help="write the tables anew")
    args = parser.parse_args()
    cost = json.loads(args.cost.read_text(encoding="utf-8"))
    made = {"run ticks": run_ticks(cost), "run by file": by_file(cost)}
    generated.finish("docs/cost.md", made, "the count of the ticks", args.write)


if __name__ == "__main__":
    main()
