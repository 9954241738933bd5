# SPDX-License-Identifier: MIT
"""The table of what the phase compensator saves, from made-up runs."""

import unittest
from pathlib import Path

import numpy as np
from support import FolderTest  # noqa: F401 (puts tools on the path)
from report import voltage_drive
from report.runs import Run, Trace


def steady(i_d_a, direction=1, state="RUN", **metrics):
    """Two seconds with a lead of 10° on a rotor that is 1° behind the frame of the rotor."""
    time = np.linspace(0, 2, 201)
    lead = np.radians(9.0)
    values = {"time_s": time, "state": np.full(len(time), state),
              "v_d_v": np.full(len(time), -100 * np.sin(lead) * direction),
              "v_q_v": np.full(len(time), 100 * np.cos(lead) * direction),
              "angle_error_el_deg": np.full(len(time), -1.0),
              "i_d_a": np.where(time < 0.5, 9.0, i_d_a), "i_q_a": np.full(len(time), 4.0 * direction),
              "torque_nm": np.full(len(time), 3.0 * direction)}
    return Run("s4", Trace(Path("s4.csv"), values),
               {"scenario": "s4", "parameters": {"resistance_ohm": {"actual": 0.5}}, **metrics})


class Table(unittest.TestCase):
    def test_figures_are_means_of_the_settled_part(self):
        lead, i_d, i_q, amplitude, torque, loss = voltage_drive.figures(steady(3.0))
        for found, right in ((lead, 10), (i_d, 3), (i_q, 4), (amplitude, 5), (torque, 3), (loss, 1.5 * 0.5 * 25)):
            self.assertAlmostEqual(found, right)

    def test_the_lead_is_counted_in_the_direction_of_rotation(self):
        self.assertAlmostEqual(voltage_drive.figures(steady(3.0, direction=-1))[0], 10)

    def test_a_run_that_tripped_shows_its_fault_in_place_of_figures(self):
        name, _, text = voltage_drive.entries([steady(3.0, state="FAULT", faults=["OVERCURRENT@5"])], lambda run: "ideal")[0]
        self.assertIn(f'id="{name}"', text)
        self.assertIn("<th scope=row>S4, ideal</th>", text)
        self.assertIn(f"colspan={len(voltage_drive.COLUMNS)}>OVERCURRENT@5</td>", text)

    def test_other_scenarios_make_no_table(self):
        self.assertEqual(voltage_drive.entries([Run("s1", None, {"scenario": "s1"})], str), [])


if __name__ == "__main__":
    unittest.main()
