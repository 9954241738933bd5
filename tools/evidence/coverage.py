# SPDX-License-Identifier: MIT
"""evidence.coverage: the unit and scenario tests go through all of the firmware.

That is firmware/ and what of the board's own code a PC runs, built by clang with counters. Asked for are every statement,
every branch both ways, and MC/DC: that each condition of a decision has decided it alone. What is compiled into several
places, as a header's functions are, counts where it is covered in one of them.

What cannot be covered stands in tests/evidence/justified.toml, line by line with its reason; a justification of
something that is covered, or that is not there, is a finding too.

The tests have run in the build of gate.asan, where each leaves its own counts. Which functions it runs goes to --ran, for
evidence.traceability, with those of the simulator: of each test that nf_count_tests() has given a place for its counts.
"""

import argparse
import glob
import json
import os
import re
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

import ctested
import part

BUILD = part.ROOT / "build/host-asan"
PROFILES = BUILD / "profiles"
COUNTED = ("firmware", "hal/stm32g4/led.c")
TESTS = ("unit", "board", "scenario")  # that have to cover it
REGISTER = Path("tests/evidence/justified.toml")
KEYS = {"file", "function", "text", "kind", "reason"}
KINDS = {"statement": "statements", "branch": "branches", "mcdc": "MC/DC conditions"}
CODE = 0  # kind of a region that is neither skipped nor a gap nor an expansion
COMMENT_OR_STRING = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', re.DOTALL)
OPERATOR = re.compile(r"&&|\|\|")
FUNCTION = re.compile(r"^\w[^;{}#]*?\b(\w+)\s*\([^;{}]*\)\s*\{", re.MULTILINE)


def quietly(command, **options):
    """Runs a command; what it says is shown only if it fails, and then the program ends."""
    run = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    if run.returncode != 0:
        sys.exit(f"{run.stdout}{run.stderr}evidence.coverage: failed: {' '.join(map(str, command))}")
    return run.stdout


def counted_files(root):
    """All source files of what is to be covered."""
    return [path for name in COUNTED for path in (sorted((root / name).rglob("*.c")) if (root / name).is_dir()
                                                  else [root / name] if (root / name).is_file() else [])]


def objects_of(build):
    """What is counted. llvm-cov 19 reads every object file, but not every archive of them."""
    folders = [build / name for name in COUNTED if (build / name).is_dir()] + [build / "tests/unit", build / "tests/board"]
    return sorted(path for folder in folders for path in folder.rglob("*.o"))


def raw_of(profiles, test):
    """Its counts: of each process (nf_count_tests), and of each Unity test in it (tests/evidence/each_test.c)."""
    return sorted(profiles.glob(f"{glob.escape(test.title)}.*.profraw"))


def merged(profiles, tests, name, *options):
    """The counts of these tests as one file."""
    raw = [path for test in tests for path in raw_of(profiles, test)]
    target = profiles / f"{name}.profdata"
    quietly(["llvm-profdata-19", "merge", *options, *raw, "-o", target])
    return target


COUNT = re.compile(r"^  (\S.*):\n    Hash: .*\n(?:    (?!Function).*\n)*    Function count: (\d+)", re.MULTILINE)


def functions_in(counts):
    """Names of the functions that these counts have, without their scope and file, and whether each has run."""
    shown = COUNT.findall(quietly(["llvm-profdata-19", "show", "--all-functions", counts]))
    names = [re.split("[;:]", name)[-1] for name, _ in shown]
    if any(name.startswith("_Z") for name in names):
        names = quietly(["c++filt", "-p"], input="\n".join(names)).splitlines()
    ran = {}
    for name, (_, count) in zip(names, shown, strict=True):
        bare = re.sub(r"<.*>|\[.*\]", "", name).rsplit("::", 1)[-1]
        ran[bare] = ran.get(bare, False) or count != "0"
    return ran


def what_ran(profiles, tests):
    """{"counted": functions that can be seen to run, "tests": {test: {"": those that it runs, and each Unity test in it by
    its name: those that this runs}}}."""
    counted, ran = set(), {}
    for test in tests:
        parts = {path.name.split(".")[-2]: path for path in raw_of(profiles, test)}
        whole = functions_in(merged(profiles, [test], test.title)) if parts else {}
        counted |= set(whole)
        if parts:
            ran[test.title] = {"": names_of(whole)} | {name: names_of(functions_in(path)) for name, path in parts.items()
                                                       if not name.isdigit()}
    return {"counted": sorted(counted), "tests": ran}


def names_of(functions):
    return sorted(name for name, has_run in functions.items() if has_run)


def export(objects, counts):
    """What llvm-cov has counted in each function of the objects."""
    command = ["llvm-cov-19", "export", f"--instr-profile={counts}", *(f"--object={path}" for path in objects)]
    return json.loads(quietly(command))["data"][0]["functions"]


def inside(outer, span):
    return outer[:2] <= span[:2] and span[2:] <= outer[2:]


def items(function):
    """All that is to be covered in one function: (kind, file, span, which way or condition) and whether it is."""
    names = function["filenames"]
    for *span, count, file, _, kind in function["regions"]:
        if kind == CODE:
            yield ("statement", names[file], tuple(span), ""), count > 0
    branches = [(names[file], tuple(span), true, false)
                for *span, true, false, file, _, _ in function["branches"]]
    for file, span, true, false in branches:
        yield ("branch", file, span, "true"), true > 0
        yield ("branch", file, span, "false"), false > 0
    for *span, _, _, alone in function["mcdc_records"]:
        yield ("decision", names[0], tuple(span), ""), True
        conditions = sorted({(file, inner) for file, inner, _, _ in branches if inside(tuple(span), inner)})
        for (file, inner), covered in zip(conditions, alone, strict=True):
            yield ("mcdc", file, inner, ""), covered


def measure(functions, root):
    """Every item within what is to be covered, by its file relative to root, and whether it is covered anywhere."""
    core = tuple(str(root / name) + (os.sep if (root / name).is_dir() else "") for name in COUNTED)
    measured = {}
    for function in functions:
        if function["filenames"][0].startswith(core):  # not of a test
            for (kind, file, span, way), covered in items(function):
                key = (Path(file).relative_to(root).as_posix(), span, kind, way)
                measured[key] = measured.get(key, False) or covered
    return measured


def without_comments(text):
    """The text with comments and strings blanked, each character else where it was."""
    return COMMENT_OR_STRING.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def not_counted(measured, root):
    """Operators of decisions that clang has no MC/DC of: it leaves out those with a decision within, and only warns."""
    decisions = defaultdict(list)
    for file, span, kind, _ in measured:
        decisions[file] += [span] if kind == "decision" else []
    for file in sorted({file for file, *_ in measured}):
        text = without_comments((root / file).read_text(encoding="utf-8"))
        for number, line in enumerate(text.splitlines(), 1):
            for found in OPERATOR.finditer(line):
                at = (number, found.start() + 1)
                if not any(span[:2] <= at < span[2:] for span in decisions[file]):
                    yield f"{file}:{number}: clang counts no MC/DC of this decision: {line.strip()}"


def not_built(measured, root):
    """Source files with functions of which nothing was counted."""
    files = {file for file, *_ in measured}
    for path in counted_files(root):
        name = path.relative_to(root).as_posix()
        if name not in files and FUNCTION.search(without_comments(path.read_text(encoding="utf-8"))):
            yield f"{name}: nothing of it is counted"


def excerpt(lines, span):
    """The source text of a span, on one line."""
    first, start, last, end = span
    text = lines[first - 1:last]
    text[-1] = text[-1][:end - 1]
    text[0] = text[0][start - 1:]
    return " ".join(" ".join(text).split())


def function_at(lines, number):
    """The name of the function that has this line."""
    before = FUNCTION.findall("\n".join(lines[:number]) + "{")
    return before[-1] if before else ""


def gaps(measured, root):
    """What is not covered: (file, line, function, text, kind, way)."""
    sources = {}
    for (file, span, kind, way), covered in sorted(measured.items()):
        if not covered:
            lines = sources.setdefault(file, (root / file).read_text(encoding="utf-8").splitlines())
            yield file, span[0], function_at(lines, span[0]), excerpt(lines, span), kind, way


def justified(register):
    """(file, function, text, kind) → reason, and what is wrong with the register itself."""
    entries, bad = {}, []
    for entry in tomllib.loads(register.read_text(encoding="utf-8")).get("justified", []):
        if set(entry) != KEYS or entry["kind"] not in KINDS or not entry["reason"].strip():
            bad.append(f"{REGISTER}: {entry}: an entry has {', '.join(sorted(KEYS))}; kind is {', '.join(KINDS)}")
            continue
        key = tuple(entry[name] for name in ("file", "function", "text", "kind"))
        if key in entries:
            bad.append(f"{REGISTER}: {entry['file']} ({entry['function']}): '{entry['text']}' stands there twice")
        entries[key] = entry["reason"]
    return entries, bad


def judge(measured, root, register):
    """The findings, the reasons of what is justified, and how much that is by (file, kind)."""
    reasons, bad = justified(register)
    bad += not_counted(measured, root)
    used = Counter()
    for file, line, function, text, kind, way in gaps(measured, root):
        key = (file, function, text, kind)
        if key in reasons:
            used[key] += 1
        else:
            bad.append(f"{file}:{line}: {kind} not covered in {function}: {text}{way and f' ({way})'}")
    bad += [f"{REGISTER}: {file} ({function}): {kind} '{text}' needs no justification"
            for file, function, text, kind in reasons if (file, function, text, kind) not in used]
    excused = Counter()
    for (file, _, _, kind), count in used.items():
        excused[file, kind] += count
    return bad, {key: reasons[key] for key in used}, excused


def percent(covered, whole):
    """Rounded down, so that 100 % is all of it."""
    return f"{1000 * covered // whole / 10:g} %" if whole else "–"


def report(measured, excused):
    """The figures of all of it, and a row for each file."""
    whole, covered = Counter(), Counter()
    for (file, _, kind, _), hit in measured.items():
        for name in (file, ""):
            whole[name, kind] += 1
            covered[name, kind] += hit
    for (file, kind), count in excused.items():
        covered[file, kind] += count
        covered["", kind] += count
    figures = [part.figure(f"{name} covered or justified", f"{percent(covered['', kind], whole['', kind])} of "
                           f"{whole['', kind]}", "100 %", 0 < whole["", kind] == covered["", kind])
               for kind, name in KINDS.items()]
    files = sorted({key[0] for key in measured})
    rows = [[file, *(f"{covered[file, kind] - excused[file, kind]} of {whole[file, kind]}" for kind in KINDS)]
            for file in files]
    return figures, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ran", type=Path, help="write which functions each test runs, as JSON")
    args = part.arguments(parser)
    root = part.ROOT
    if args.ran:
        counted = [test for test in ctested.listed(BUILD).values() if "LLVM_PROFILE_FILE" in test.environment]
        args.ran.parent.mkdir(parents=True, exist_ok=True)
        args.ran.write_text(json.dumps(what_ran(PROFILES, counted), indent=1) + "\n", encoding="utf-8")
    covering = [test for folder in TESTS for test in ctested.listed(BUILD, f"tests/{folder}").values()]
    measured = measure(export(objects_of(BUILD), merged(PROFILES, covering, "all", "-sparse")), root)
    bad, reasons, excused = judge(measured, root, root / REGISTER)
    bad += not_built(measured, root)
    figures, rows = report(measured, excused)
    says = ("The unit and scenario tests go through every statement of the firmware and of what of the board a PC runs, "
            "take every branch both ways, and let each condition of a decision decide it alone (MC/DC), counted by clang. What cannot be covered is "
            "justified line by line. Counted is what a PC compiles; what a Cortex-M has in place of port/generic gives "
            "the same bits there (target.identity).")
    tables = [part.table("Covered, by file", ["file", *KINDS.values()], rows,
                         f"{sum(excused.values())} gaps are justified.")]
    if reasons:
        tables.append(part.table("Justified", ["file", "function", "text", "kind", "reason"],
                                 [[*key, reason] for key, reason in sorted(reasons.items())]))
    return part.end(args.out, "coverage", "Coverage", says, figures, tables, bad)


if __name__ == "__main__":
    sys.exit(main())
