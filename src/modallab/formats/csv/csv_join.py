"""Tables below each other that are parts of one."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.errors import DataError
from modallab.formats.csv.csv_table import Table

_TITLE = re.compile(r"^(?:(?:FRF|transfer function|frequency response(?: function)?|H[12v])\b[\s:(]*)+", re.IGNORECASE)
"""What stands before the response in the title of a table of FRFs."""


def records_of(tables: Sequence[Table], where: str) -> list[Table]:
    """Tables of records; those over the same times that hold other channels are one.

    Raises:
        DataError: as `side_by_side`.
    """
    groups: list[list[Table]] = []
    for table in tables:
        before = groups[-1] if groups else []
        known = {name for one in before for name in one.names[1:]}
        other = bool(table.names) and not known & set(table.names[1:])
        if before and other and np.array_equal(before[0].values[:, 0], table.values[:, 0]):
            before.append(table)
        else:
            groups.append([table])
    return [side_by_side(group, where) for group in groups]


def side_by_side(tables: Sequence[Table], where: str) -> Table:
    """Tables of FRFs below each other as one. Columns that are called alike in two take their table's title.

    Raises:
        DataError: the tables differ in their first column, or columns called alike have no titles.
    """
    first = tables[0]
    if len(tables) == 1:
        return first
    _require_lines(tables, where)
    parts = [t.values if t.imaginary is None else t.values + 1j * t.imaginary for t in tables]
    whole = np.hstack([first.values[:, :1], *(part[:, 1:] for part in parts)])
    return replace(
        first,
        names=(first.names[0], *_names_of_all(tables, where)),
        units=(first.units[0], *(unit for table in tables for unit in table.units[1:])),
        values=np.ascontiguousarray(whole.real),
        ended=tables[-1].ended,
        imaginary=np.ascontiguousarray(whole.imag) if np.iscomplexobj(whole) else None,
    )


def _require_lines(tables: Sequence[Table], where: str) -> None:
    first = tables[0]
    for k, table in enumerate(tables, start=1):
        if not np.array_equal(table.values[:, 0], first.values[:, 0]):
            raise DataError(
                f"table {k} of {len(tables)} has other frequencies than the first: {_span(table)}, not {_span(first)}",
                where=where,
                remedy="export FRFs at the same lines, or each to a file of its own",
            )


def _names_of_all(tables: Sequence[Table], where: str) -> list[str]:
    names = [name for table in tables for name in table.names[1:]]
    if len(set(names)) == len(names):
        return names
    said = (
        [_TITLE.sub("", t.facts.titles().get(k, "")).rstrip(") ").replace(",", "/") for t in tables]
        for k in _keys(tables)
    )
    titles = next((one for one in said if "" not in one and len(set(one)) == len(one)), None)
    if titles is None:
        raise DataError(
            f"holds {len(tables)} tables of FRFs below each other, and not the response of each",
            where=where,
            remedy="write the response above each table, as FRF a1/force, or give one table with a column for each",
        )
    return [f"{name} {title}" for table, title in zip(tables, titles, strict=True) for name in table.names[1:]]


def _keys(tables: Sequence[Table]) -> list[str]:
    return list(dict.fromkeys(key for table in tables for key in table.facts.titles()))


def _span(table: Table) -> str:
    return f"{len(table.values)} from {table.values[0, 0]:g} to {table.values[-1, 0]:g}"
