"""Results that show themselves: as a table or a figure in a notebook, as text at a prompt."""

from collections.abc import Iterable, Sequence
from html import escape
from io import StringIO
from typing import Generic, TypeVar

from rich.console import Console

from modallab.reporting.plain_table import plain_table

WIDTH = 100
"""Characters of a line at a prompt."""


T = TypeVar("T")


class DisplayedTable:
    """A table: HTML in a notebook, text at a prompt."""

    def __init__(self, headings: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> None:
        self.headings = tuple(headings)
        self.rows = tuple(tuple(row) for row in rows)
        self.caption = caption

    def __repr__(self) -> str:
        said = StringIO()
        console = Console(file=said, width=WIDTH, no_color=True, force_jupyter=False)
        console.print(plain_table(self.headings, self.rows))
        if self.caption:
            console.print(self.caption, markup=False, highlight=False)
        return "\n".join(line.rstrip() for line in said.getvalue().splitlines())

    def html(self) -> str:
        """The table as HTML."""
        head = "".join(f"<th>{escape(cell)}</th>" for cell in self.headings)
        rows = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in self.rows)
        caption = f"<caption style='caption-side:bottom'>{escape(self.caption)}</caption>" if self.caption else ""
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"

    def _repr_html_(self) -> str:
        return self.html()


class DisplayedResult(DisplayedTable, Generic[T]):
    """A table with its values in `numbers`.

    Attributes:
        numbers: every number of the table in SI units, as arrays.
    """

    def __init__(self, numbers: T, headings: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> None:
        super().__init__(headings, rows, caption)
        self.numbers = numbers
