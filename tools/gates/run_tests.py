# SPDX-License-Identifier: MIT
"""tools/dev test: ctest without the evidence, and then what each test has cost.

Which tier a test belongs to, in one rule: `test` has what tells whether a change is right, for at most MOST of the processor
time of these tests; all else is evidence (label `evidence`). A test that is dearer and stays has the label `dear`, by
nf_is_dear() with the reason beside it. Its time is no part of the whole, because it depends on what is built already. A share
is the same on a machine that is twice as slow; seconds are not. A run of all tests fails above FAILS, because shares vary.
"""

import argparse
import sys
from pathlib import Path

import sources

sys.path.insert(0, str(sources.ROOT / "tools/evidence"))
import ctest_run  # noqa: E402
import ctested  # noqa: E402

MOST = 1 / 30
FAILS = 1.5 * MOST
SHOWN = 20
# Options of ctest that no word belongs to.
ALONE = {"-V", "-VV", "-Q", "-N", "-F", "-U", "--verbose", "--extra-verbose", "--quiet", "--show-only", "--progress",
         "--rerun-failed", "--output-on-failure", "--stop-on-failure", "--schedule-random"}


def report(ended):
    """The dearest tests, for those who look for what makes the whole slow."""
    dearest = sorted(ended, key=lambda test: -test.core_seconds)[:SHOWN]
    print(f"\nThe dearest of {len(ended)} tests, in core-seconds ({sum(test.core_seconds for test in ended):.0f} in all):")
    for test in dearest:
        print(f"{test.core_seconds:8.1f}  {test.name}")


def too_dear(ended, tests):
    if not {test.name for test in ended} >= {name for name, test in tests.items() if "evidence" not in test.labels}:
        return  # a share of what is not the whole says nothing
    judged = [test for test in ended if not tests[test.name].labels & {"dear", "evidence"}]
    whole = sum(test.core_seconds for test in judged)
    for test in judged:
        if test.core_seconds > FAILS * whole:
            yield (f"{test.name}: took {test.core_seconds:.0f} of {whole:.0f} core-seconds; allowed: {FAILS:.1%} of them "
                   f"({FAILS * whole:.0f}), or a reason: nf_is_dear() in its CMakeLists.txt")


def words_for_ctest(words):
    """Those of the user, and what leaves the evidence out; an error in one line, or None."""
    # argparse would take ctest's -L for the beginning of -LE.
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("-L", "--label-regex", action="append", default=[])
    parser.add_argument("-LE", "--label-exclude", action="append", default=[])
    labels, rest = parser.parse_known_args(words)
    for before, word in zip(["", *rest], rest):
        if (before in ALONE or not before.startswith("-")) and not word.startswith("-"):
            return [], f"tools/dev test: found '{word}'; allowed: options of ctest, for instance -R {word}"
    # Of several -LE ctest leaves out what matches all of them.
    left_out = "|".join(("^evidence$", *labels.label_exclude))
    chosen = [word for label in labels.label_regex for word in ("-L", label)]
    return ["-j2", "--output-on-failure", "--no-tests=error", "-LE", left_out, *chosen, *rest], None


def main(words):
    if {"-h", "--help"} & set(words):
        print(__doc__, "\nOptions are those of ctest: -R REGEX, -L LABEL, -LE LABEL, --rerun-failed, ...", sep="")
        return 0
    for_ctest, error = words_for_ctest(words[1:])
    if error:
        print(error, file=sys.stderr)
        return 2
    if words[0] == "--judge":  # the words alone: do nothing
        return 0
    build = Path(words[0])
    tests = ctested.listed(build, whole=False)
    run = ctest_run.Run(build, for_ctest,
                        {name: test.command for name, test in tests.items() if "evidence" not in test.labels})
    ended = list(run)
    report(ended)
    dear = list(too_dear(ended, tests))
    for line in dear:
        print(line)
    return run.status or (1 if dear else 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
