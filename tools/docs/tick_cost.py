# SPDX-License-Identifier: MIT
"""The table of docs/cost.md that says what a tick in RUN takes, out of what target.cost has counted.

tick_cost.py COST.JSON           says whether the page is as it was counted; exit status 1 if not
tick_cost.py COST.JSON --write   writes the table anew
"""
import argparse
import json
from pathlib import Path

import generated

CORES = {"cortex-m4": "Cortex-M4", "cortex-m3": "Cortex-M3", "cortex-m0plus": "Cortex-M0+"}
TUNINGS = {"published": "published tuning", "robust": "robust tuning, every imperfection", "voltage_phase": "voltage drive, S5"}
AIM = ["aim", "300 / 400", "330 / 440", "600 / 800"]


def run_ticks(cost):
    def of(core, tuning):
        ticks = cost[core]["ticks"][tuning]["RUN"]
        return f"{ticks['mean']:.0f} / {ticks['max']}"

    rows = [[name, *(of(core, tuning) for core in CORES)] for tuning, name in TUNINGS.items()]
    return generated.table(["", *CORES.values()], [AIM, *rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cost", type=Path, metavar="COST.JSON", help="as tools/bench_target.py --json has written it")
    parser.add_argument("--write", action="store_true", help="write the table anew")
    args = parser.parse_args()
    cost = json.loads(args.cost.read_text(encoding="utf-8"))
    generated.finish("docs/cost.md", {"run ticks": run_ticks(cost)}, "the count of the ticks", args.write)


if __name__ == "__main__":
    main()
