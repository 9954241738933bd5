# SPDX-License-Identifier: MIT
"""Builds the documentation site; `tools/dev docs` calls it.

build.py --out FOLDER

Doxygen reads the firmware's headers into XML, Sphinx makes pages of docs/ and of that. Any warning is an error: an unknown
link, a page that no table of contents names, a header that Doxygen cannot read.
"""
import argparse
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FILTER = f"{sys.executable} {Path(__file__).with_name('doxygen_filter.py')}"
FOLDERS = ("firmware/app", "firmware/record", "firmware/drive", "firmware/config", "firmware/protect", "firmware/control",
           "firmware/math", "hal")


def doxygen_settings(out):
    folders = " ".join(str(ROOT / folder) for folder in FOLDERS)
    return f"""
PROJECT_NAME = neurofoc
INPUT = {folders}
FILE_PATTERNS = *.h
RECURSIVE = NO
STRIP_FROM_PATH = {ROOT}
OUTPUT_DIRECTORY = {out}
GENERATE_XML = YES
GENERATE_HTML = NO
GENERATE_LATEX = NO
XML_PROGRAMLISTING = NO
OPTIMIZE_OUTPUT_FOR_C = YES
JAVADOC_AUTOBRIEF = YES
EXTRACT_ALL = YES
EXTRACT_STATIC = YES
MACRO_EXPANSION = NO
INPUT_FILTER = "{FILTER}"
QUIET = YES
WARN_IF_UNDOCUMENTED = NO
WARN_NO_PARAMDOC = NO
"""


def run(command, **options):
    done = subprocess.run(command, text=True, capture_output=True, check=False, **options)
    said = (done.stdout + done.stderr).strip()
    if done.returncode or said:
        print(said, file=sys.stderr)
        sys.exit(f"build.py: failed: {command[0]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder of the site")
    out = parser.parse_args().out.resolve()
    work = out.with_name(out.name + ".work")
    work.mkdir(parents=True, exist_ok=True)
    run(["doxygen", "-"], input=doxygen_settings(work), cwd=ROOT)
    run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", str(work / "doctrees"), "-b", "html",
         str(ROOT / "docs"), str(out)],
        env=os.environ | {"NEUROFOC_DOXYGEN_XML": str(work / "xml")})
    print(f"{out}/index.html")


if __name__ == "__main__":
    main()
