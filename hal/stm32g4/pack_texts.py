# SPDX-License-Identifier: MIT
"""Makes the texts of an image shorter: pieces that come often become one byte each, which text.h puts back.

pack_texts.py PIECES COMPILER ARGUMENT...   compiles a C source, with its texts packed; anything else as it is
pack_texts.py PIECES --learn FILE...        prints the pieces that pack the texts of preprocessed sources best

PIECES is firmware/app/text_pieces.def. A text is a string of LEAST characters or more: shorter ones may be compared.
"""

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

LEAST = 10
FIRST_CODE = 0x80
PIECES_MAX = 127
LONGEST = 24
APART = {"text.c"}  # it has the pieces
NAMES = "neurofoc: "  # begins the names of motor and board, which recordings have too
TOKEN = re.compile(r"""^\#[^\n]* | "(?:[^"\\]|\\.)*" | '(?:[^'\\]|\\.)*' | \w+ | .""", re.MULTILINE | re.VERBOSE | re.DOTALL)
NO_TEXTS = {"asm", "__asm", "__asm__", "__attribute__", "__attribute", "_Static_assert"}  # of their parentheses


def read_pieces(path):
    return re.findall(r'^TEXT_PIECE\("(.*)"\)$', path.read_text(encoding="utf-8"), re.MULTILINE)


def texts_of(source):
    """(begin, end) of what is inside the quotes of each text."""
    depth = 0  # of the parentheses of something without texts
    waits = False
    for token in TOKEN.finditer(source):
        word = token[0]
        if word in NO_TEXTS:
            waits = True
        elif word == "(" and (waits or depth):
            depth, waits = depth + 1, False
        elif word == ")" and depth:
            depth -= 1
        elif word[0] == '"' and not depth and len(word) >= LEAST + 2 and not word.startswith(f'"{NAMES}'):
            yield token.start() + 1, token.end() - 1


def parts(text):
    """What is between the escapes, and the escapes."""
    return re.split(r"(\\[0-7]{1,3}|\\x[0-9a-fA-F]+|\\.)", text)


def packer(pieces):
    codes = {piece: f"\\{FIRST_CODE + number:03o}" for number, piece in enumerate(pieces)}
    any_of = re.compile("|".join(map(re.escape, sorted(pieces, key=len, reverse=True))))

    def pack(text):
        return "".join(part if part.startswith("\\") else any_of.sub(lambda found: codes[found[0]], part) for part in parts(text))

    return pack


def packed(source, pack):
    at, out = 0, []
    for begin, end in texts_of(source):
        out += [source[at:begin], pack(source[begin:end])]
        at = end
    return "".join([*out, source[at:]])


def learn(sources):
    """Greedily: the piece that saves most of what is left."""
    texts = sorted({source[begin:end] for source in sources for begin, end in texts_of(source)})
    left = [part for text in texts for part in parts(text) if part and not part.startswith("\\")]
    pieces = []
    while len(pieces) < PIECES_MAX:
        count = Counter(part[begin:begin + length] for part in left for length in range(2, LONGEST)
                        for begin in range(len(part) - length + 1))
        best = max(count, key=lambda piece: (count[piece] * (len(piece) - 1) - len(piece) - 1, piece))
        if count[best] * (len(best) - 1) <= len(best) + 2:
            break
        pieces.append(best)
        left = [rest for part in left for rest in part.split(best) if rest]
    return pieces


def compile_packed(pieces, command):
    source = command[command.index("-c") + 1]
    target = command[command.index("-o") + 1]
    between = f"{target}.i"
    preprocess = ["-E" if word == "-c" else between if word == target else word for word in command]
    again = [between if word == source else word for word in command if word != "-MD"]
    for option in ("-MT", "-MF"):
        if option in again:
            preprocess[preprocess.index(option) + 1] = command[command.index(option) + 1]
            del again[again.index(option):again.index(option) + 2]
    subprocess.run(preprocess, check=True)
    path = Path(between)
    path.write_text(packed(path.read_text(encoding="utf-8"), packer(pieces)), encoding="utf-8")
    subprocess.run(again, check=True)


def main(pieces, *command):
    if command[0] == "--learn":
        print("\n".join(f'TEXT_PIECE("{piece}")' for piece in learn(Path(path).read_text(encoding="utf-8") for path in command[1:])))
        return 0
    is_source = "-c" in command and Path(command[command.index("-c") + 1]).name not in APART
    if not is_source:
        return subprocess.run(command, check=False).returncode
    try:
        compile_packed(read_pieces(Path(pieces)), list(command))
    except subprocess.CalledProcessError as failure:  # the compiler has said why
        return failure.returncode
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
