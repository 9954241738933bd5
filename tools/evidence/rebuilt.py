# SPDX-License-Identifier: MIT
"""What a build makes of changed sources, beside it: only what the change reaches is made again, and nothing in its folder.

The build says how (`ninja -t compdb`) and which object reads which file (`ninja -t deps`). Its commands are run with the
sources taken from a copy, and with each changed object, archive, program or generated header from a folder for those.
"""

import functools
import json
import os
import re
import shlex
import subprocess
from pathlib import Path

NOT_SOURCES = ("build", ".cache")  # of the project's folder: shared by all copies
FOR_THE_BUILD_ALONE = {"-MD": 1, "-MT": 2, "-MF": 2}  # options, with how many words they are
SEAL = "seal.py"  # what is run after a link and makes the output what it is: without its checksum an image does not start
SEVERAL = "Unity"  # the folder of the sources that CMake makes to include several
DATA = "NEUROFOC_DATA"  # where the programs look for motors, boards and so on


class CannotBuild(Exception):
    """With what the compiler or the linker says."""


def copied(word, root, copy):
    """The word of a command with the copy's files in place of the project's."""
    return re.sub(rf"{re.escape(str(root))}(?=/(?!({'|'.join(map(re.escape, NOT_SOURCES))})(/|$))|$)", str(copy), word)


class Build:
    """A build by CMake and ninja: a folder with build.ninja. Outputs and files are whole paths."""

    def __init__(self, folder):
        self.folder = folder
        self.commands = {folder / edge["output"]: edge["command"] for edge in json.loads(self.ninja("compdb"))
                         if edge["command"]}
        self.read = {}  # object → files that it is compiled from
        for line in self.ninja("deps").splitlines():
            if line.startswith(" "):
                self.read[object_].add(Path(os.path.normpath(folder / line.strip())))
            elif line:
                object_ = folder / line.split(": #deps")[0]
                self.read[object_] = set()

    def ninja(self, tool):
        return subprocess.run(["ninja", "-t", tool], cwd=self.folder, check=True, capture_output=True, text=True).stdout

    @functools.cache
    def steps(self, output):
        """The commands that make it, and where they run; what is run after a link is left out, but for the seal."""
        steps = [[]]
        for word in shlex.split(self.commands[output]):
            if word == "&&":
                steps.append([])
            else:
                steps[-1].append(word)
        steps = [step for step in steps if step not in ([], [":"])]
        place = self.folder
        if steps and steps[0][0] == "cd":
            place = Path(steps.pop(0)[1])
        after = next((at for at, step in enumerate(steps) if step[0] == "cd"), len(steps))
        return place, steps[:after] + [step for step in steps[after:] if any(Path(word).name == SEAL for word in step)]

    @functools.cache
    def inputs(self, output):
        """What is made before it, by this build or another, and stands in its commands or is read by its compiler."""
        place, steps = self.steps(output)
        named = {place / word for step in steps for word in step if not word.startswith("-")}
        return {path for path in named | self.read.get(output, set()) if build_of(path)} - {output}


@functools.cache
def build_of(path):
    """The build whose output a path is, None if it is of none."""
    folder = next((parent for parent in path.parents if (parent / "build.ninja").is_file()), None)
    build = folder and known(folder)
    return build if build and path in build.commands else None


@functools.cache
def known(folder):
    return Build(folder)


def own_words(step):
    """The command without what it writes for the build beside its output."""
    words, at = [], 0
    while at < len(step):
        skipped = FOR_THE_BUILD_ALONE.get(step[at], int(step[at].startswith("-Wl,-Map=")))
        if not skipped:
            words.append(step[at])
        at += skipped or 1
    return words


class Rebuilt:
    """Of the sources in `copy`, where one file is another than in the project: what comes of it, in `folder`."""

    def __init__(self, root, copy, file, folder):
        self.root, self.copy, self.folder = root, copy, folder
        self.file = root / file
        self.made = {}

    def output(self, path):
        """Where it is with the change in, None if the change does not reach it."""
        build = build_of(path)
        if build and path not in self.made:
            changed = {name: made for name in sorted(build.inputs(path)) if (made := self.output(name))}
            reached = changed or self.file in build.read.get(path, ())
            self.made[path] = self.make(build, path, changed) if reached else None
        return self.made.get(path)

    def make(self, build, output, changed):
        new = self.folder / str(len(self.made)) / output.name
        new.parent.mkdir(parents=True)
        place, steps = build.steps(output)
        names = {str(name): str(made) for name, made in {**changed, output: new}.items()}
        for step in steps:
            words = [self.renamed(self.of_several(word, place, new.parent), place, names) for word in own_words(step)]
            if "-c" in words:
                # The changed headers before those of the build; and a change may leave something unused.
                first = next((at for at, word in enumerate(words) if word.startswith("-I")), words.index("-c"))
                words[first:first] = ["-w", *(f"-I{made.parent}" for made in changed.values())]
            run = subprocess.run(words, cwd=place, capture_output=True, text=True, errors="replace", check=False,
                                 env={**os.environ, DATA: str(self.copy / "host_sim")})
            if run.returncode != 0:
                raise CannotBuild(run.stderr.strip() or run.stdout.strip())
        return new

    def of_several(self, word, place, folder):
        """In place of a source that CMake has made to include several: one that includes those of the copy."""
        path = place / word
        if path.parent.name != SEVERAL or path.suffix != ".cxx":
            return word
        (folder / path.name).write_text(copied(path.read_text(encoding="utf-8"), self.root, self.copy), encoding="utf-8")
        return str(folder / path.name)

    def renamed(self, word, place, names):
        """The word of a command with the changed outputs and the copy's files in it."""
        if str(place / word) in names:
            return names[str(place / word)]
        for name, made in names.items():
            word = word.replace(name, made)
        return copied(word, self.root, self.copy)
