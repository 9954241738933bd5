# SPDX-License-Identifier: MIT
"""Robustness campaigns: thousands of seeded runs of the simulator, counted and drawn."""
