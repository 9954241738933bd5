"""The frame of every page: one HTML file with its style in it, and nothing from elsewhere."""

import html

from report.css import STYLE


def document(title, header, main):
    """`title` is text, `header` and `main` are HTML."""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<style>{STYLE}</style>
</head>
<body>
<header>
{header}
</header>
<main>
{main}
</main>
</body>
</html>
"""


def anchor(name, title):
    return f'<a href="#{html.escape(name)}">{html.escape(title)}</a>'
