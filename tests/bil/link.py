# SPDX-License-Identifier: MIT
"""As much of the link (firmware/app/link_messages.h) as the tests of the image need, written a second time."""

import binascii
import struct

HELLO, PING, COMMAND, LINE, WRITE, APPLY, STORE = 1, 3, 4, 5, 7, 8, 9
ANSWER = 0x80
VERSION = 2
SALT = 20261129
TICKET_BYTES = 4
WORDS = 32  # in one message
PATIENCE_TICKS = 20000


def stuffed(data):
    """COBS."""
    return b"".join(bytes([len(part) + 1]) + part for part in data.split(b"\0"))


def unstuffed(code):
    data, at = b"", 0
    while at < len(code):
        data += code[at + 1:at + code[at]] + b"\0"
        at += code[at]
    return data[:-1]


def framed(kind, tag, body=b""):
    """A question as it is sent. Messages are shorter than the 254 bytes from which on COBS has a code without a zero."""
    message = bytes([kind, tag]) + body
    return b"\0" + stuffed(message + struct.pack("<I", binascii.crc32(message))) + b"\0"


def answer_in(said, tag):
    """Type and body of a frame that has come whole, with the question's tag; or None."""
    for code in bytes(said).split(b"\0"):
        message = unstuffed(code) if code else b""
        whole = len(message) > 5 and message[-4:] == struct.pack("<I", binascii.crc32(message[:-4]))
        if whole and message[0] >= ANSWER and message[1] == tag:
            return message[0], message[2:-4]
    return None


class Link:
    """Asks a board of board.py, whose time goes on meanwhile."""

    def __init__(self, board):
        self.board = board
        self.tag = 0

    def ask(self, kind, body=b""):
        """The body of the answer."""
        self.tag = self.tag % 255 + 1
        self.board.chip.usart.said.clear()
        self.board.send(framed(kind, self.tag, body))
        for _ in range(PATIENCE_TICKS):
            self.board.tick()
            if (answer := answer_in(self.board.chip.usart.said, self.tag)) is not None:
                break
        if answer is None or answer[0] != kind + ANSWER:
            raise AssertionError(f"question {kind} is answered by {answer}")
        return answer[1]

    def hello(self):
        self.ask(HELLO, struct.pack("<BI", VERSION, SALT))

    def verdict(self, kind, body=b""):
        """Empty, or why not: what is behind the ticket."""
        return self.ask(kind, body)[TICKET_BYTES:].decode()

    def line(self, text):
        """What a person would type."""
        self.verdict(LINE, self.ask(PING)[-TICKET_BYTES:] + text.encode())

    def apply(self, block):
        """Empty, or why not."""
        words = len(block) // 4
        for first in range(0, words, WORDS):
            part = block[4 * first:4 * (first + WORDS)]
            if why := self.verdict(WRITE, struct.pack("<HB", first, len(part) // 4) + part):
                return why
        return self.verdict(APPLY, block[-8:-4])  # the CRC of the configuration, in front of that of the block

    def store(self):
        return self.verdict(STORE)


class SteadyLink:
    """A PC that commands, for a board whose ticks are somebody else's: feed() before each of them."""

    BOOT_TICKS, PING_TICKS = 600, 4000

    def __init__(self, board):
        self.board = board
        self.tag = self.waiting = 0
        self.silent = 0  # ticks since the last question
        self.ticket = None
        self.wanted = self.commanded = None  # request, mode, target

    def _ask(self, kind, body=b""):
        self.tag = self.tag % 255 + 1
        self.board.chip.usart.said.clear()
        self.waiting, self.silent = kind, 0
        self.board.chip.usart.receive(framed(kind, self.tag, body))

    def _take(self):
        answer = answer_in(self.board.chip.usart.said, self.tag)
        if answer is None:
            return
        assert answer[0] == self.waiting + ANSWER, f"question {self.waiting} is answered by {answer}"
        verdict = answer[1]
        if self.waiting == COMMAND:
            assert len(verdict) == TICKET_BYTES, verdict
        self.ticket = verdict[:TICKET_BYTES] if self.waiting == COMMAND else verdict[-TICKET_BYTES:]
        self.waiting = 0

    def feed(self):
        self.silent += 1
        if self.waiting:
            self._take()
        elif self.ticket is None:
            if self.silent >= self.BOOT_TICKS:
                self._ask(HELLO, struct.pack("<BI", VERSION, SALT))
        elif self.wanted != self.commanded:
            self.commanded = self.wanted
            self._ask(COMMAND, struct.pack("<BBi", *self.wanted) + self.ticket)
        elif self.silent >= self.PING_TICKS:
            self._ask(PING)
