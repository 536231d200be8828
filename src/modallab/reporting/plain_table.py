"""Any table for the terminal."""

from collections.abc import Iterable, Sequence

from rich.markup import escape
from rich.table import Table


def plain_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Any table; a cell wider than its column goes on in the next line, as a number that is cut is another one.

    Args:
        headings: of the columns.
        rows: as many cells each.
    """
    table = Table(box=None, pad_edge=False, collapse_padding=True)
    for heading in headings:
        table.add_column(escape(heading), overflow="fold")
    for row in rows:
        table.add_row(*map(escape, row))
    return table
