"""Facts above a table: a key with one value for the table, or with one for each column.

What a program does not write above the columns it writes here: the unit of the abscissa, the step of the samples, the
response, or whether two columns are the parts of complex numbers.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from modallab.formats.csv.csv_cells import BLANKS, number, split
from modallab.formats.time_names import RATES, STEPS, plain_name
from modallab.formats.unit_text import (
    is_of_frequency,
    is_of_time,
    is_unit,
    name_and_unit,
    normal_unit,
    quantity_of,
    to_seconds,
)

_MARK = re.compile(r"\s*[:=]\s*|\t\s*")
_UNITS = re.compile(r"unit|einheit", re.IGNORECASE)
_UNIT_OF_X = re.compile(r"^\W*(?:x|abscissa)?[\W_]*(?:axis)?[\W_]*(?:unit|einheit)s?$", re.IGNORECASE)
_UNIT_OF_Y = re.compile(r"^\W*(?:y|ordinate|amplitude)[\W_]*(?:axis)?[\W_]*(?:unit|einheit)s?$", re.IGNORECASE)
_PRODUCT = re.compile(r"\(?([^()]+)\)\(([^()]+)\)?")
_KIND = re.compile(r"^(?:data)?[\W_]*type$", re.IGNORECASE)
WHOSE = re.compile(
    r"^(?:signal|channel|response|point|node|dof)(?:[\W_]*(?:names?|id|index|no|number))?$", re.IGNORECASE
)
_WITH_UNIT = re.compile(r"^(?P<number>[-+.,\deE]+)\s*(?P<unit>\D*)$")


@dataclass(frozen=True, slots=True)
class Fact:
    """A key, "" for a line that is no more than a title, and what stands beside it or below it."""

    key: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Facts:
    """All facts above one table, in their order."""

    all: tuple[Fact, ...] = ()

    def of(self, key: re.Pattern[str]) -> tuple[str, ...]:
        """The values of the first fact with such a key that has any; () if there is none."""
        return next((fact.values for fact in self.all if fact.values and key.match(fact.key)), ())

    def called(self, names: Sequence[str]) -> tuple[str, ...]:
        """The same of the first fact whose key is one of these plain names."""
        return next((fact.values for fact in self.all if fact.values and plain_name(fact.key) in names), ())

    @property
    def unit_of_x(self) -> str:
        """Of the abscissa, "" where none is said."""
        return _known_unit(self.of(_UNIT_OF_X))

    @property
    def unit_of_y(self) -> str:
        """Of all other columns, "" where none is said."""
        return _known_unit(self.of(_UNIT_OF_Y))

    def units(self, columns: int) -> Sequence[str]:
        """The unit of each column, "" without any; of all columns, or of all but the first."""
        for fact in self.all:
            found = [normal_unit(value) for value in fact.values]
            if _UNITS.search(fact.key) and any(map(quantity_of, found)) and len(found) in (columns, columns - 1):
                return [*([self.unit_of_x] if len(found) < columns else []), *found]
        return [self.unit_of_x, *[self.unit_of_y] * (columns - 1)]

    def of_ratio(self, unit: str) -> str:
        """A unit, where the facts say that (m/s^2)(N) is a ratio."""
        found = _PRODUCT.fullmatch(unit)
        said = found and "ratio" in (value.lower() for value in self.of(_UNITS))
        return f"{found[1]}/{found[2]}" if found and said else unit

    @property
    def rate_hz(self) -> float | None:
        """The sampling rate, where one is said that is the same for all channels."""
        steps = {_seconds(value) for value in self.called(STEPS)}
        rates = {1 / step for step in steps if step} if steps else {_hertz(value) for value in self.called(RATES)}
        return rates.pop() if len(rates) == 1 and None not in steps | rates else None

    @property
    def are_complex(self) -> bool:
        """Whether two columns are the parts of complex numbers."""
        return any("complex" in value.lower() for value in self.of(_KIND))

    @property
    def whose(self) -> str:
        """The channel or the point that the numbers are of, "" where none is said."""
        return next(iter(self.of(WHOSE)), "")

    def titles(self) -> dict[str, str]:
        """By key what may say whose FRFs a table holds, the last title first."""
        found = {"": next((fact.values[0] for fact in reversed(self.all) if not fact.key and fact.values), "")}
        return found | {fact.key: fact.values[0] for fact in self.all if fact.values and WHOSE.match(fact.key)}


def facts_of(lines: Sequence[str], delimiter: str) -> Facts:
    """The facts in lines; a key that ends with a colon and stands alone has its values in the next line."""
    found: list[Fact] = []
    rest = list(lines)
    while rest:
        key, *values = _parts(rest.pop(0), delimiter)
        if key.endswith(":") and not any(values) and rest and not _parts(rest[0], delimiter)[0].endswith(":"):
            values = _parts(rest.pop(0), delimiter)
        elif not values:
            key, values = "", [key]
        name, unit = name_and_unit(key.rstrip(" :="))
        behind = f" {unit}" if is_of_time(unit) or is_of_frequency(unit) else ""
        key = name if behind else key.rstrip(" :=")
        found.append(Fact(key, tuple(value + behind for value in values if value)))
    return Facts(tuple(found))


def names_by_facts(facts: Facts, columns: Sequence[Sequence[str]]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units of columns that no line names, as far as facts and numbers leave no choice; else () and ().

    A column that counts the rows is left out; then the abscissa is the first, whose unit is among the facts.

    Args:
        facts: above the table.
        columns: their cells.
    """
    unit = facts.unit_of_x
    counts = len(columns) > 2 and counts_rows(columns[0])
    filled = [k for k, cells in enumerate(columns) if any(cells) and not (counts and k == 0)]
    parts = ("Re ", "Im ") if facts.are_complex else ("",)
    if not unit or len(filled) != 1 + len(parts) or (facts.are_complex and not is_of_frequency(unit)):
        return (), ()
    names, units = [""] * len(columns), [""] * len(columns)
    names[filled[0]], units[filled[0]] = "time" if is_of_time(unit) else "frequency", unit
    for place, part in zip(filled[1:], parts, strict=True):
        names[place], units[place] = f"{part}{facts.whose}".strip() or "value", facts.unit_of_y
    return tuple(names), tuple(units)


def counts_rows(cells: Sequence[str]) -> bool:
    """Whether a column, which is then no channel, holds the number of each row, from 0 or 1."""
    first = number(cells[0])
    return first in (0, 1) and all(number(cell) == k for k, cell in enumerate(cells, start=int(first)))


def _parts(line: str, delimiter: str) -> list[str]:
    """A key and its values; a colon or an equals sign may stand between them instead of the delimiter."""
    cells = [line.strip()] if delimiter == BLANKS else split(line, delimiter)
    filled = [cell for cell in cells if cell] or [""]
    if len(filled) > 1:
        return filled if cells[0] else ["", *filled]
    key, *values = _MARK.split(filled[0], maxsplit=1)
    return [f"{key}:" if values and not values[0] else key, *(value for value in values if value)]


def _known_unit(values: Sequence[str]) -> str:
    unit = normal_unit(values[0]) if len(values) == 1 else ""
    return unit if is_unit(unit) else ""


def _quantity(text: str) -> tuple[float, str] | None:
    found = _WITH_UNIT.match(text.strip())
    value = number(found["number"]) if found else None
    return None if found is None or value is None or value <= 0 else (value, normal_unit(found["unit"]))


def _seconds(text: str) -> float | None:
    found = _quantity(text)
    return found[0] * to_seconds(found[1]) if found and (not found[1] or is_of_time(found[1])) else None


def _hertz(text: str) -> float | None:
    found = _quantity(text)
    factors = {"": 1.0, "Hz": 1.0, "kHz": 1e3, "S/s": 1.0, "samples/s": 1.0}
    return found[0] * factors[found[1]] if found and found[1] in factors else None
