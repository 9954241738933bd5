# SPDX-License-Identifier: MIT
"""HTML from templates: TOOL/page.jinja is tools/TOOL/templates/page.jinja. What they are given is escaped, unless it is Markup."""

import re
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, PrefixLoader, StrictUndefined
from markupsafe import Markup, escape

from report.style import DARK, LIGHT

TOOLS = Path(__file__).resolve().parents[1]
BREAKS = re.compile(r"(?<=\w[_/.])(?=\w)")


def breakable(text):
    """As HTML that can be broken within long names; a line of the text is one of the page."""
    return Markup(BREAKS.sub("<wbr>", str(escape(text)).replace("\n", "<br>")))


ENVIRONMENT = Environment(
    loader=PrefixLoader({folder.parent.name: FileSystemLoader(folder) for folder in TOOLS.glob("*/templates")}),
    autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
ENVIRONMENT.filters["breakable"] = breakable
ENVIRONMENT.globals.update(light=LIGHT, dark=DARK)


def render(name, **values):
    return Markup(ENVIRONMENT.get_template(name).render(values))
