"""Robustness campaigns: thousands of seeded runs of the simulator, counted and drawn."""
