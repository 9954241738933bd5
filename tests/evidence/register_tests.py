# SPDX-License-Identifier: MIT
"""What a register of the evidence is held to, whatever is in it: for the tests of those who read one."""

import tempfile
from pathlib import Path


class RegisterTests:
    """Beside unittest.TestCase: the register itself and `ENTRY` are right, and each text of `BROKEN` has one thing wrong."""

    REGISTER = None  # the file
    ENTRY = None
    BROKEN = ()

    def registered(self, path):
        """What is read, and what is wrong with it."""
        raise NotImplementedError

    def wrong(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / self.REGISTER.name
            path.write_text(text, encoding="utf-8")
            return self.registered(path)[1]

    def test_the_register_that_there_is_has_nothing_wrong(self):
        self.assertEqual(self.wrong(self.ENTRY), [])
        self.assertEqual(self.registered(self.REGISTER)[1], [])

    def test_an_entry_is_whole_of_a_known_kind_and_there_once(self):
        for text in self.BROKEN:
            with self.subTest(text):
                self.assertEqual(len(self.wrong(text)), 1)
