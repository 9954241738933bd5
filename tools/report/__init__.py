# SPDX-License-Identifier: MIT
"""Figures and the report of simulated runs; the command line is tools/plot.py."""
