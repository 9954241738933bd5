# SPDX-License-Identifier: MIT
"""gate.one_definition: a setting is defined once: few files name it, as whatever needs all settings loops over cfg.def.

Counted are the C and C++ files that name the member of its struct: the row, the header that declares it, the module that
uses it, the line that computes it from SI units, and whoever looks at it by name. The median over all members of the
structs may be five; one that is in several rows, as a regulator's gain, counts once.
Not counted are the unit tests of these files, with the example that they share: test_<module>, reference_<module>, and
those that a whole folder has. A member is told from one of another struct by what stands before its dot: a member or a
variable of that type. Where types are not written, as in generic code, a name that this struct's variables have counts.
"""

import argparse
import re
import statistics
from pathlib import Path

import sources

ROOT_TYPE = "drive_cfg_t"
MOST = 5  # files, median
EXAMPLE = "tests/unit/example_cfg.h"
OF_A_FOLDER = {  # unit tests of several of its files together
    "firmware/drive": [f"tests/unit/test_{name}.c" for name in ("drive", "drive_change", "drive_steps", "low_speed", "voltage_drive")],
    "host_sim/config": ["tests/config/*"],
}
STRUCT = re.compile(r"typedef struct \{([^{}]*)\} (\w+);")
MEMBER = re.compile(r"\b(\w+) (\w+);")
ROW = re.compile(r"^CFG\w*\(([\w.]+),", re.MULTILINE)
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
NAMED = re.compile(r"(?:(\w+)(?:\[[^\]]*\])?|([{,])\s*)(?=(?:\.|->)(\w+)\b(?!\())")  # before the dot: a name, or an initialiser's
VARIABLE = re.compile(r"\b(\w+_t) (?:const )?[*&]?(?:const )?(\w+)")
ANY = {"cfg", "c"}  # what a variable of any configuration is called
COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)


class Files:
    """What each file says without its comments. Texts count: a path in quotes names a setting."""

    def __init__(self, root):
        self.texts = {path: COMMENT.sub("", (root / path).read_text(encoding="utf-8"))
                      for path in sources.files(root, "*.c", "*.h", "*.cpp", "*.def")}
        self.named = {path: {(name or brace, member) for name, brace, member in NAMED.findall(text)}
                      for path, text in self.texts.items()}
        self.variables = {path: set(VARIABLE.findall(text)) for path, text in self.texts.items()}
        self.by_name = {}
        for path in self.texts:
            self.by_name.setdefault(path.name, []).append(path)
        self.reach = {path: self.reached(path, set()) for path in self.texts}

    def reached(self, path, seen):
        """The file and all that it includes."""
        if path not in seen:
            seen.add(path)
            for name in INCLUDE.findall(self.texts[path]):
                for included in self.by_name.get(Path(name).name, []):
                    self.reached(included, seen)
        return seen

    def names(self, path, type_, members, leaf):
        """Whether the file names this member of the struct; `members`: of other structs, of this type."""
        own = {name for of_type, name in self.variables[path] if of_type == type_}
        before = members | own | (ANY | {"{", ","} if type_ in self.texts[path] else set())
        return any((name, leaf) in self.named[path] for name in before)

    def structs(self):
        """Type → (header, member → its type), of the firmware."""
        return {name: (path, {member: type_ for type_, member in MEMBER.findall(body)})
                for path, text in self.texts.items() if path.parts[0] == "firmware" and path.suffix == ".h"
                for body, name in STRUCT.findall(text)}


def own_test(path, namers):
    """Whether it is a unit test of one of these, or what unit tests share."""
    of_a_module = re.match(r"(?:test|reference)_(\w+)", path.stem)
    tests = [test for folder in {namer.parent.as_posix() for namer in namers} for test in OF_A_FOLDER.get(folder, [])]
    return (bool(of_a_module and of_a_module[1] in {namer.stem for namer in namers})
            or any(path.match(test) for test in [EXAMPLE, *tests]))


def namers(files):
    """(struct, member) of each row → the files that name it."""
    structs = files.structs()
    rows = [row for path, text in files.texts.items() if path.name == "cfg.def" for row in ROW.findall(text)]
    members_of = {}  # type → names of the members that have it
    for _, members in structs.values():
        for member, type_ in members.items():
            members_of.setdefault(type_, set()).add(member)
    for row in rows:
        *parents, leaf = row.split(".")
        type_ = ROOT_TYPE
        for parent in parents:
            type_ = structs[type_][1][parent]
        header, _ = structs[type_]
        members = members_of.get(type_, {"cfg"})
        found = [path for path in files.texts
                 if path == header or path.name == "cfg.def"
                 or (header in files.reach[path] and files.names(path, type_, members, leaf))]
        yield (type_, leaf), [path for path in found if not own_test(path, found)]


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--root", type=Path, default=sources.ROOT)
parser.add_argument("--list", action="store_true", help="print who names each setting")
args = parser.parse_args()
counted = dict(namers(Files(args.root)))
if args.list:
    for member, paths in counted.items():
        print(f"{len(paths):3} {'.'.join(member)}: {', '.join(map(str, paths))}")
median = statistics.median(map(len, counted.values())) if counted else 0
print(f"{len(counted)} members, each named by {median:g} files in the median")
bad = [] if counted and median <= MOST else [f"firmware: {median:g} files name a setting in the median, allowed are {MOST}"]
sources.finish("one_definition", bad, "Loop over the rows of cfg.def in place of a list of settings; --list says who names which.")
