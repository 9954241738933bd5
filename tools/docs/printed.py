# SPDX-License-Identifier: MIT
"""Tables of a page that a program prints, with an empty line between them.

printed.py PAGE TABLE... -- PROGRAM [ARGUMENT]...   says whether the page shows what the program prints; exit status 1 if not
printed.py --write PAGE TABLE... -- PROGRAM ...     writes the tables anew
"""
import argparse
import subprocess
import sys

import generated


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="write the tables anew")
    parser.add_argument("page", metavar="PAGE", help="in the project's folder")
    parser.add_argument("tables", nargs="+", metavar="TABLE", help="their names in the page, in the order of the program")
    words = sys.argv[1:]
    at = words.index("--") if "--" in words else len(words)
    args, command = parser.parse_args(words[:at]), words[at + 1:]
    if not command:
        parser.error("expected -- and the program that prints them")
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(f"{command[0]}: exit status {done.returncode}; expected 0")
    printed = done.stdout.strip("\n").split("\n\n")
    if len(printed) != len(args.tables):
        sys.exit(f"{command[0]} printed {len(printed)} tables; expected {len(args.tables)}: {', '.join(args.tables)}")
    made = {name: f"{text}\n" for name, text in zip(args.tables, printed)}
    generated.finish(args.page, made, command[0].rpartition("/")[2], args.write)


if __name__ == "__main__":
    main()
