# SPDX-License-Identifier: MIT
"""What dead-time compensation does to a drive on the switched plant, measured with and without."""
