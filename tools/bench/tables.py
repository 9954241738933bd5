"""The bench's results as tables of text."""

from rich.table import Table
from rich.text import Text


def profile_table(bench, state, shares, top):
    """The shares of a tick, largest first; what does not fit into `top` rows as one."""
    table = Table(title=f"{bench.core}, {bench.tuning}: instructions of a {state} tick")
    for name, justify in (("mean", "right"), ("longest", "right"), ("function", "left"),
                          ("source", "left")):
        table.add_column(name, justify=justify)
    for share in shares[:top]:
        table.add_row(f"{share.mean:.1f}", str(share.worst), share.function, Text(share.file))
    rest = shares[top:]
    if rest:
        table.add_row(*total(rest), f"({len(rest)} more)", "", style="dim")
    table.add_section()
    table.add_row(*total(shares), "all", "")
    return table


def total(shares):
    return (f"{sum(share.mean for share in shares):.1f}", str(sum(share.worst for share in shares)))
