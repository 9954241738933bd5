# SPDX-License-Identifier: MIT
"""A figure as SVG text for a page: colours by meaning, so that the page's mode decides them."""

import html
import io
import re

import matplotlib
from markupsafe import Markup

from report.style import LIGHT, settings

IDENTIFIERS = re.compile(r'(\bid="|url\(#|href="#)')
TAG = re.compile(r"<[^>]*>")    # what a reader sees is between them
LONG_NUMBERS = re.compile(r"(\d\.\d\d)\d+")
NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def svg(figure, shape, name, alternative):
    """The <svg> element; `name` keeps its identifiers apart from those of other figures."""
    stream = io.StringIO()
    with matplotlib.rc_context(settings(shape)):
        figure.savefig(stream, format="svg", metadata=NO_METADATA)
    text = stream.getvalue()
    text = text[text.index("<svg"):]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = IDENTIFIERS.sub(rf"\g<1>{name}-", text)
    text = TAG.sub(lambda tag: LONG_NUMBERS.sub(r"\1", tag[0]), text)
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)
    text = text.replace(" font-family: 'DejaVu Sans';", "")    # the page's font
    for meaning, color in LIGHT.items():
        text = text.replace(color, f"var(--{meaning})")
    width = re.search(r'width="([\d.]+)pt"', text)[1]
    head = (f'<svg role="img" aria-label="{html.escape(alternative)}" '
            f'preserveAspectRatio="xMinYMin" style="max-width: {width}pt"')
    return Markup(re.sub(r' (width|height)="[\d.]+pt"', "", text.replace("<svg", head, 1), count=2))
