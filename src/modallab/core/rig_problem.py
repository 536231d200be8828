"""One thing that is wrong in a rig, and reading what its fields hold before they are known to be valid."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple, cast

INVALID: Final = object()
"""Stands where a field was found to be wrong on its own: nothing further can be said about it."""


class Problem(NamedTuple):
    """One thing that is wrong in a rig: the field, what it holds, what it may hold."""

    field: str
    found: str
    allowed: str

    def __str__(self) -> str:
        return f"{self.field}: {self.found}; allowed: {self.allowed}"


def reject_problems(problems: Sequence[Problem]) -> None:
    """Reject a document in which something is wrong, all of it at once.

    Raises:
        ValueError: something is.
    """
    if problems:
        raise ValueError("\n".join(str(problem) for problem in problems))


def repeated_entries(group: str, field: str, values: Sequence[str | float | None]) -> list[Problem]:
    """What occurs twice in a field of a group of entries; None: not known."""
    return [
        Problem(
            f"{group}[{place}].{field}",
            f"found {value_in_message(value)}, as in {group}[{values.index(value)}]",
            "each once",
        )
        for place, value in enumerate(values)
        if value is not None and values.index(value) < place
    ]


def value_in_message(value: str | float) -> str:
    """A value as it is written in a message."""
    return repr(value) if isinstance(value, str) else f"{value:g}"


def list_entries(content: Mapping[str, object], key: str) -> list[Mapping[str, object]]:
    """The entries of a list of the rig; a wrong entry keeps its place."""
    entries = content.get(key)
    if not isinstance(entries, Sequence) or isinstance(entries, str):
        return []
    # One of which nothing is known.
    nothing: Mapping[str, object] = {"id": INVALID, "quantity": INVALID}
    listed = cast("Sequence[object]", entries)
    return [cast("Mapping[str, object]", e) if isinstance(e, Mapping) else nothing for e in listed]


def number_or_none(value: object) -> float | None:
    """A number, or None where the field holds none."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        return float(value)
    except (ValueError, OverflowError):
        return None
