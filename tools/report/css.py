"""The style sheet of the report."""

from report.style import DARK, LIGHT


def variables(colors):
    return " ".join(f"--{name}: {color};" for name, color in colors.items())


STYLE = f"""
:root {{ color-scheme: light dark; {variables(LIGHT)} --good: #1a6b3c; --bad: #a8260f; }}
@media screen and (prefers-color-scheme: dark) {{
  :root {{ {variables(DARK)} --good: #6fd19a; --bad: #ff8a73; }}
}}
""" + """
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0 auto; max-width: 56rem; padding: 2rem 1.25rem 4rem; background: var(--paper);
  color: var(--ink); font: 1rem/1.55 system-ui, "Segoe UI", "Liberation Sans", sans-serif; }
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.3rem; margin: 3rem 0 .5rem; padding-top: .75rem;
  border-top: 1px solid var(--grid); }
h3 { font-size: 1.05rem; margin: 2rem 0 .5rem; }
p, li, dd { max-width: 44rem; }
a { color: var(--actual); }
nav a { display: inline-block; margin: 0 .9rem .3rem 0; }
.muted, small { color: var(--muted); }
small { display: block; font-size: .8rem; font-weight: 400; overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--muted); padding-bottom: .4rem; }
th, td { text-align: left; vertical-align: top; padding: .45rem .7rem .45rem 0;
  border-bottom: 1px solid var(--grid); }
thead th { font-size: .85rem; color: var(--muted); font-weight: 600; }
summary { cursor: pointer; margin: .4rem 0; }
details table { font-size: .85rem; }
.good { color: var(--good); } .bad { color: var(--bad); }
.verdict { font-weight: 600; white-space: nowrap; }
dt { font-weight: 600; margin-top: .5rem; } dd { margin: 0; }
.metrics { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr));
  column-gap: 2rem; margin: 0; }
.metrics div { display: flex; justify-content: space-between; gap: 1rem; padding: .3rem 0;
  border-bottom: 1px solid var(--grid); font-size: .9rem; }
.metrics dt { margin: 0; font-weight: 400; color: var(--muted); }
.metrics dd { text-align: right; overflow-wrap: anywhere; }
figure { margin: 0 0 1rem; }
figcaption { font-size: .9rem; color: var(--muted); max-width: 46rem; }
figure svg { display: block; width: 100%; height: auto; }
figure svg * { stroke-linejoin: round; stroke-linecap: butt; }
.narrow { display: none; }
@media screen and (max-width: 40rem) {
  body { padding: 1.25rem .9rem 3rem; }
  .wide { display: none; } .narrow { display: block; }
  .cards thead { position: absolute; clip-path: inset(50%); }
  .cards tr, .cards th, .cards td { display: block; border: 0; padding: .1rem 0; }
  .cards tr { border-bottom: 1px solid var(--grid); padding: .7rem 0; }
  .cards td { display: grid; grid-template-columns: 8.5rem 1fr; gap: .5rem; }
  .cards td:empty { display: none; }
  .cards td::before { content: attr(data-label); color: var(--muted); }
}
@media print {
  @page { margin: 14mm; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  nav, .files { display: none; }
  details::details-content { content-visibility: visible; display: block; }
  h2, h3 { break-after: avoid; }
  tr, figure, .metrics div { break-inside: avoid; }
  section.run { break-before: page; }
  figure svg { max-height: 172mm; }
}
"""
