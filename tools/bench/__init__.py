# SPDX-License-Identifier: MIT
"""What a control tick costs on a Cortex-M: the modules of tools/bench_target.py."""
