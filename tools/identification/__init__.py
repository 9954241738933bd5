# SPDX-License-Identifier: MIT
"""Motors of the zoo, identified by the drive: how far the results are off, and whether the drive runs with them."""
