# SPDX-License-Identifier: MIT
"""The documentation site: Sphinx with MyST for the guides, Doxygen and Breathe for the firmware's headers."""
import os

project = "neurofoc"
author = "the neurofoc authors"
project_copyright = author

extensions = ["myst_parser", "breathe"]
source_suffix = {".md": "markdown"}

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
highlight_language = "none"  # most blocks are commands and their output

breathe_projects = {"firmware": os.environ["NEUROFOC_DOXYGEN_XML"]}
breathe_default_project = "firmware"
breathe_domain_by_extension = {"h": "c"}

html_theme = "furo"
html_title = "neurofoc"
html_static_path = ["static"]
html_css_files = ["wide.css"]
html_show_copyright = False
html_show_sphinx = False
