"""What is wrong in the fields of a document, in plain words: the field, the value found, and what is allowed."""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple, cast

from pydantic import ValidationError
from pydantic_core import ErrorDetails

ALLOWED = {
    "missing": "this field is needed",
    "string_type": "text, in quotes",
    "string_too_short": "text that is not empty",
    "string_too_long": "at most {max_length} characters",
    "finite_number": "a finite number",
    "float_type": "a number",
    "float_parsing": "a number, with a decimal point",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_parsing_size": "a whole number of common size",
    "int_from_float": "a whole number",
    "tuple_type": "a list, each entry after a dash",
    "model_type": "a group of fields, each as name: value",
    "model_attributes_type": "a group of fields, each as name: value",
    "dict_type": "a group of fields, each as name: value",
    "invalid_key": "a name, as text",
    "greater_than": "more than {gt:g}",
    "greater_than_equal": "{ge:g} or more",
    "less_than": "less than {lt:g}",
    "less_than_equal": "{le:g} or less",
    "literal_error": "{expected}",
    "too_short": "at least {min_length} entries",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
}
"""Kind of error -> what the field may hold."""
INVALID: Final = object()
"""Stands where a field was found to be wrong on its own: nothing further can be said about it."""


def allowed_values(detail: ErrorDetails) -> str:
    """What the field may hold."""
    template = ALLOWED.get(detail["type"])
    if template is not None:
        return template.format(**detail.get("ctx", {})).replace("at least 1 entries", "at least one entry")
    if detail["type"].startswith("date"):
        return "a date, as 2025-01-31"
    return detail["msg"].removeprefix("Value error, ").removeprefix("Input should be ").replace("\n", "; ")


def is_short_by_wrong_entries(detail: ErrorDetails, details: Sequence[ErrorDetails]) -> bool:
    """Whether a list is called too short only since its entries are wrong, which are named themselves."""
    place = detail["loc"]
    return detail["type"] == "too_short" and any(
        len(other["loc"]) > len(place) and other["loc"][: len(place)] == place for other in details
    )


def quoted_value(value: object) -> str:
    """A value as a message quotes it."""
    if value is None:
        return "nothing"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def error_sentences(error: ValidationError) -> list[str]:
    """Each wrong field once: `hits is -1; allowed: more than 0`."""
    details = error.errors()
    kept = [d for d in details if not is_short_by_wrong_entries(d, details)]
    return list(dict.fromkeys(_error_sentence(detail) for detail in kept))


def _error_sentence(detail: ErrorDetails) -> str:
    field = ".".join(map(str, detail["loc"]))
    if detail["type"] == "missing":
        return f"{field} is missing"
    if detail["type"] == "extra_forbidden":
        return f"{field} is an unknown field"
    if detail["type"] == "value_error":
        return f"{field}: {allowed_values(detail)}" if field else allowed_values(detail)
    return f"{field} is {quoted_value(detail['input'])}; allowed: {allowed_values(detail)}"


class FieldProblem(NamedTuple):
    """One thing that is wrong in a rig: the field, what it holds, what it may hold."""

    field: str
    found: str
    allowed: str

    def __str__(self) -> str:
        return f"{self.field}: {self.found}; allowed: {self.allowed}"


def reject_problems(problems: Sequence[FieldProblem]) -> None:
    """Reject a document in which something is wrong, all of it at once.

    Raises:
        ValueError: something is.
    """
    if problems:
        raise ValueError("\n".join(str(problem) for problem in problems))


def repeated_entries(group: str, field: str, values: Sequence[str | float | None]) -> list[FieldProblem]:
    """What occurs twice in a field of a group of entries; None: not known."""
    return [
        FieldProblem(
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
