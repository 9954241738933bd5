"""evidence.proof_can_fail: the proof finds an index out of its array and a clamp that is gone.

Each fault alone is put into a copy of the sources.
"""

import shutil
import tempfile
import unittest
from pathlib import Path

import proof

FAULTS = {
    "an index out of its array": (
        "firmware/drive/supervision.c", "phase < SUPERVISION_PHASES; phase++) {\n        note_phase",
        "phase <= SUPERVISION_PHASES; phase++) {\n        note_phase", "supervision.c"),
    "a clamp that is gone": (
        "firmware/control/pi.c", "fx_sat27(pi->integral_q26 + fx_asr(error * cfg->ki, cfg->ki_shift))",
        "pi->integral_q26 + fx_asr(error * cfg->ki, cfg->ki_shift)", "integral_q26"),
}


class ProofCanFail(unittest.TestCase):
    def test_each_fault_is_found(self):
        for name, (path, text, fault, found) in FAULTS.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                root = Path(folder)
                for part in ("firmware", "tests/proof"):
                    shutil.copytree(proof.ROOT / part, root / part)
                source = (root / path).read_text(encoding="utf-8")
                self.assertEqual(source.count(text), 1, path)
                (root / path).write_text(source.replace(text, fault), encoding="utf-8")
                bad, _, _ = proof.findings(root, ["proof_startup"], root)
                self.assertTrue([line for line in bad if line.startswith("proof_startup: ") and found in line], bad)


if __name__ == "__main__":
    unittest.main()
