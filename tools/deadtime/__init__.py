# SPDX-License-Identifier: MIT
"""What giving the dead time back does to a drive on the switched plant, measured with and without."""
