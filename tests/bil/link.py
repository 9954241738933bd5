# SPDX-License-Identifier: MIT
"""As much of the link (firmware/app/link_messages.h) as the tests of the image need, written a second time."""

import binascii
import struct

HELLO, PING, LINE, WRITE, APPLY, STORE = 1, 3, 5, 7, 8, 9
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


class Link:
    """Asks a board of board.py. Messages are shorter than the 254 bytes from which on COBS has a code without a zero."""

    def __init__(self, board):
        self.board = board
        self.tag = 0

    def _answer(self):
        """Type, tag and body of a frame that has come whole, with the question's tag."""
        for code in bytes(self.board.chip.usart.said).split(b"\0"):
            message = unstuffed(code) if code else b""
            whole = len(message) > 5 and message[-4:] == struct.pack("<I", binascii.crc32(message[:-4]))
            if whole and message[0] >= ANSWER and message[1] == self.tag:
                return message[0], message[2:-4]
        return None

    def ask(self, kind, body=b""):
        """The body of the answer."""
        self.tag = self.tag % 255 + 1
        message = bytes([kind, self.tag]) + body
        self.board.chip.usart.said.clear()
        self.board.send(b"\0" + stuffed(message + struct.pack("<I", binascii.crc32(message))) + b"\0")
        for _ in range(PATIENCE_TICKS):
            self.board.tick()
            if (answer := self._answer()) is not None:
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
