# SPDX-License-Identifier: MIT
"""evidence.proof_can_fail: the proof finds each kind of run-time error, a saturation and a clamp that are gone, code that
it does not go through, a question that it does not ask, and a tool that fails. The class Short is its short form.

The faults are put into a copy of the sources.
"""

import os
import shutil
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import proof

RESET = "proof_init", "firmware/config/config_guard.c", "    *guard = (config_guard_t){.at = 0U, .crc = CRC32_START};\n"

# File, text, what becomes of it; what the finding has in it: where the fault is, so that none stands for another. In one
# copy together, as a tick takes most of a minute.
FAULTS_OF_A_TICK = {
    "an index out of its array": (
        "firmware/protect/supervision.c", "phase < SUPERVISION_PHASES; phase++) {\n        note_phase",
        "phase <= SUPERVISION_PHASES; phase++) {\n        note_phase", "supervision.c"),
    "a dropped saturation": (
        "firmware/control/pi.h", "fx_sat27(pi->integral_q26 + fx_asr(error * cfg->ki, cfg->ki_shift))",
        "pi->integral_q26 + fx_asr(error * cfg->ki, cfg->ki_shift)", "integral_q26"),
    "a missing clamp": (
        "firmware/control/nn_observer.c",
        "fx_clamp(obs->speed - weight_step, -cfg->speed_limit, cfg->speed_limit)", "obs->speed - weight_step",
        "FIELD(rotor.observer.speed, "),
}

# Each alone: entry; as above. Those of the short form: one of each kind of finding.
FAULTS = {
    "a function that nothing calls": (
        "proof_init", "firmware/control/pi.c", "void pi_reset(",
        "int32_t pi_left_behind(int32_t x)\n{\n    return x;\n}\n\nvoid pi_reset(",
        f"{proof.UNREACHED}: pi_left_behind"),
    "a shift too far": (
        *RESET, "    *guard = (config_guard_t){.at = 0U, .crc = CRC32_START << (32U + guard->at)};\n", "shift"),
    "an entry that asks for no range": (
        "proof_init", proof.DRIVE, "DERATING_HEAT_MAX_Q24));\n    check_state();\n", "DERATING_HEAT_MAX_Q24));\n",
        f"proof_init: {proof.CHECK}: "),
    "a tick that does not end": (
        "proof_recorder", "firmware/record/recorder.c", "    recorder_entry_t *at = recorder->at;\n\n    if (",
        "    recorder_entry_t *at = recorder->at;\n\n    while (recorder != NULL) {\n    }\n    if (",
        "proof_recorder: record: "),
}

FURTHER_FAULTS = {
    "a statement that nothing reaches": (
        *RESET, "    *guard = (config_guard_t){.at = 0U, .crc = CRC32_START};\n"
        "    if (guard->at != 0U) {\n        guard->at = 0U;\n    }\n",
        "config_guard_reset: 1 of "),
    "a function that is only declared": (
        *RESET, "    extern void config_guard_elsewhere(void);\n    config_guard_elsewhere();\n"
        "    *guard = (config_guard_t){.at = 0U, .crc = CRC32_START};\n", "config_guard_elsewhere has neither code"),
    "a division by zero": (
        *RESET, "    *guard = (config_guard_t){.at = 0U, .crc = CRC32_START / guard->at};\n", "division_by_zero"),
    "a word that was never written": (
        *RESET, "    uint32_t crc;\n    *guard = (config_guard_t){.at = 0U, .crc = crc};\n", "initialization"),
    "a code that is no state, and stays": (
        "proof_no_state", "firmware/drive/transitions.c", "        next = DRIVE_STATE_FAULT;\n", "        next = state;\n",
        "(check_code): precondition of within"),
    "a conversion that changes the value": (
        *RESET, "    *guard = (config_guard_t){.at = 0U, .crc = (uint8_t)CRC32_START};\n", "downcast"),
}

# Frama-C in name: what it says and how it ends.
TOOLS = {
    "a Frama-C that fails": ("exit 1", "frama-c ended with 1"),
    "a Frama-C that says nothing": ("exit 0", "frama-c ended with 0"),
    "a Frama-C without a list": ("echo ANALYSIS SUMMARY", "no list of properties"),
}


def findings(entry, folder, root=proof.ROOT):
    return proof.findings(root, [entry], folder)[0]


def planted(folder, faults):
    """A copy of the sources with faults: file, text, what becomes of it."""
    root = Path(folder)
    for part in ("firmware", "tests/proof"):
        shutil.copytree(proof.ROOT / part, root / part)
    for path, text, fault in faults:
        source = (root / path).read_text(encoding="utf-8")
        if source.count(text) != 1:
            raise AssertionError(f"{path} has not once: {text}")
        (root / path).write_text(source.replace(text, fault), encoding="utf-8")
    return root


class Found(unittest.TestCase):
    def assert_found(self, bad, found):
        self.assertTrue([line for line in bad if found in line], bad)

    def assert_each_found(self, faults):
        for name, (entry, *fault, found) in faults.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                self.assert_found(findings(entry, Path(folder), planted(folder, [fault])), found)


class Short(Found):
    """The entries that take a second or two."""

    def test_each_fault_is_found(self):
        self.assert_each_found(FAULTS)

    def test_a_tool_that_does_not_do_its_work_is_found(self):
        for name, (script, found) in TOOLS.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                tool = Path(folder, "frama-c")
                tool.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
                tool.chmod(0o755)
                with mock.patch.dict(os.environ, {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}):
                    bad = findings("proof_init", Path(folder))
                self.assert_found(bad, found)
                self.assert_found(bad, f"FIELD(limits.current_max, 1, 65536, current_q15): {proof.UNASKED}")


class Further(Found):
    def test_each_further_fault_is_found(self):
        self.assert_each_found(FURTHER_FAULTS)

    def test_each_fault_of_a_tick_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = planted(folder, [fault for *fault, _ in FAULTS_OF_A_TICK.values()])
            bad = findings("proof_plain_regulated", Path(folder), root)
        for name, (*_, found) in FAULTS_OF_A_TICK.items():
            with self.subTest(name):
                self.assert_found(bad, found)


if __name__ == "__main__":
    unittest.main()
