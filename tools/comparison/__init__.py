# SPDX-License-Identifier: MIT
"""The drive's observer beside estimators of the literature, each in its place."""
