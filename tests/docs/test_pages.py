# SPDX-License-Identifier: MIT
"""docs.pages: what a reader of the guides counts on."""

import json
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
GUIDES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PAGES = [*GUIDES, *(ROOT / "docs/api").glob("*.md")]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
ONE_PAGE = 140  # lines of the README
SOURCES = ("firmware", "hal", "host_sim", "tools", "tests")
LANGUAGES = {".c", ".h", ".cpp", ".def", ".py", ".cmake"}
FUNCTION = re.compile(r"""^\ {0,4}\w[^;{}()#=]*\b(\w+)\([^;{}]*\)[^;{}()]*\{    # of C and C++; `if (` has a space
                          | ^\#define\ (\w+)\( | ^\ *def\ (\w+)\( | ^(?:function|macro)\((\w+)""", re.MULTILINE | re.VERBOSE)
# What a page names: FILE:FUNCTION, or in backticks FUNCTION() or a FILE.
NAMED = re.compile(r"\b(\w+\.(?:c|h|cpp|py)):([A-Za-z_]\w*)|`(\w+)\(\)`|`([\w/]+\.(?:c|h|cpp|py|def))`")
NOT_OURS = {"add_subdirectory", "add_executable",  # of CMake
            "hal_config.h"}                        # nfconfig makes it


def defined_in(text):
    """The names of the functions and macros that a source file defines."""
    return set(filter(None, (name for names in FUNCTION.findall(text) for name in names)))


def files():
    """Each source file of the project, relative to it, and what it defines."""
    paths = (path for folder in SOURCES for path in (ROOT / folder).rglob("*")
             if path.suffix in LANGUAGES and "node_modules" not in path.parts)
    return {path.relative_to(ROOT): defined_in(path.read_text(encoding="utf-8")) for path in paths}


def not_there(text, defined):
    """What the text of a page names and the files do not have."""
    everywhere = set().union(*defined.values())
    for named in NAMED.finditer(text):
        file, function, alone, path = named.groups()
        there = (any(function in names for at, names in defined.items() if at.name == file) if file
                 else alone in everywhere if alone
                 else any(f"/{at}".endswith(f"/{path}") for at in defined))
        if not there and (alone or path) not in NOT_OURS:
            yield named[0]


class Pages(unittest.TestCase):
    def test_the_readme_is_one_page(self):
        self.assertLessEqual(len(README.splitlines()), ONE_PAGE)

    def test_every_link_leads_to_a_file(self):
        for page in PAGES:
            for link in LINK.findall(page.read_text(encoding="utf-8")):
                with self.subTest(page=page.name, link=link):
                    self.assertTrue("://" in link or (page.parent / link).exists())

    def test_every_function_and_source_file_that_a_page_names_is_there(self):
        defined = files()
        for page in PAGES:
            self.assertEqual(list(not_there(page.read_text(encoding="utf-8"), defined)), [], page.name)

    def test_every_public_header_is_in_the_api(self):
        shown = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/api").glob("*.md"))
        for header in [*(ROOT / "firmware").glob("*/*.h"), ROOT / "hal/hal.h"]:
            self.assertIn(f"doxygenfile}} {header.name}\n", shown)

    def test_every_link_of_a_packed_page_leads_to_a_packed_file(self):
        packed = [ROOT / name for name in json.loads((ROOT / "library.json").read_text(encoding="utf-8"))["export"]["include"]]
        for page in (path for path in packed if path.suffix == ".md"):
            for link in LINK.findall(page.read_text(encoding="utf-8")):
                target = (page.parent / link).resolve()
                self.assertTrue("://" in link or any(target.is_relative_to(path) for path in packed), f"{page.name}: {link}")


class TheTest(unittest.TestCase):
    def test_a_function_or_file_that_is_not_there_is_found(self):
        defined = {Path("a/b.c"): defined_in("static int f(int x)\n{\n    if (x) {\n"), Path("a/c.c"): {"g"}}
        self.assertEqual(list(not_there("b.c:f, `c.c:g`, `g()`, `a/b.c`, `c.c`, `add_executable()`", defined)), [])
        self.assertEqual(list(not_there("b.c:g, `h()`, `b/c.c`, `d.h`, c.c:if", defined)),
                         ["b.c:g", "`h()`", "`b/c.c`", "`d.h`", "c.c:if"])


if __name__ == "__main__":
    unittest.main()
