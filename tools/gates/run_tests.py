# SPDX-License-Identifier: MIT
"""tools/dev test: ctest without the evidence, and then what each test has cost.

Which tier a test belongs to, in one rule: `test` has what tells whether a change is right, for at most MOST core-seconds a
test; all else is evidence (label `evidence`). A test that is dearer and stays has the label `dear`, by nf_is_dear() with the
reason beside it. Cost is processor time, which other programs hardly change. A test fails above FAILS: a slower machine takes
more than the one on which MOST was measured.
"""

import argparse
import sys
from pathlib import Path

import sources

sys.path.insert(0, str(sources.ROOT / "tools/evidence"))
import ctest_run  # noqa: E402
import ctested  # noqa: E402

MOST = 20  # core-seconds
FAILS = 1.5 * MOST
SHOWN = 20


def report(ended):
    """The dearest tests, for those who look for what makes the whole slow."""
    dearest = sorted(ended, key=lambda test: -test.core_seconds)[:SHOWN]
    print(f"\nThe dearest of {len(ended)} tests, in core-seconds ({sum(test.core_seconds for test in ended):.0f} in all):")
    for test in dearest:
        print(f"{test.core_seconds:8.1f}  {test.name}")


def too_dear(ended, tests):
    for test in ended:
        if test.core_seconds > FAILS and "dear" not in tests[test.name].labels:
            yield (f"{test.name}: took {test.core_seconds:.0f} core-seconds; allowed: {MOST}, and {FAILS:.0f} on a "
                   "slower machine, or a reason: nf_is_dear() in its CMakeLists.txt")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="the build folder")
    parser.add_argument("-LE", "--label-exclude", metavar="REGEX", help="as of ctest; the evidence is left out anyway")
    args, of_ctest = parser.parse_known_args()
    tests = ctested.listed(args.build, whole=False)
    # Of several -LE ctest leaves out what matches all of them.
    left_out = "|".join(filter(None, ("^evidence$", args.label_exclude)))
    run = ctest_run.Run(args.build, ["-j2", "--output-on-failure", "--no-tests=error", "-LE", left_out, *of_ctest],
                        {name: test.command for name, test in tests.items() if "evidence" not in test.labels})
    ended = list(run)
    report(ended)
    dear = list(too_dear(ended, tests))
    for line in dear:
        print(line)
    return run.status or (1 if dear else 0)


if __name__ == "__main__":
    sys.exit(main())
