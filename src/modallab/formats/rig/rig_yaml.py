"""YAML as rig files use it, where a key stands once in a mapping, and what is wrong in such a file, field by field."""

from collections.abc import Hashable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, cast

import yaml
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from modallab.core.effect import Revision
from modallab.core.field_errors import INVALID, FieldProblem, allowed_values, is_short_by_wrong_entries, quoted_value
from modallab.core.frozen import Frozen
from modallab.core.hardware import Calibration, Certificate, Excitation, Shaker, Synchronisation
from modallab.core.rig import Beam, Channel, Converter, DampingPrior, Limits, Point, Rig, Tolerance
from modallab.core.rig_checks import inconsistent_fields

_MAX_DEPTH = 12
_MAX_VALUES = 100_000
SECTIONS: dict[str, type[Frozen]] = {
    "": Rig,
    "beam": Beam,
    "tolerance": Tolerance,
    "damping_ratio": DampingPrior,
    "points": Point,
    "channels": Channel,
    "converter": Converter,
    "limits": Limits,
    "excitation": Excitation,
    "history": Calibration,
    "shakers": Shaker,
    "synchronisation": Synchronisation,
    "revisions": Revision,
}
"""The document that stands at each place of a rig file."""

_SENSITIVITY = "sensitivity_v_per_unit"
_TESTS = ("impact", "sine")
_PER_TEST = "a number, or one number each under impact: and sine:"


class Truth:
    """Stands for true or false, which no field of a rig takes, but which would pass for 1 or 0."""

    def __init__(self, value: bool) -> None:
        self.value = value

    def __repr__(self) -> str:
        return str(self.value).lower()


class _Loader(yaml.SafeLoader):
    """Safe loading that notes repeated keys, of which YAML keeps the last without a word."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.repeated: list[FieldProblem] = []

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        lines: dict[str, int] = {}
        for key, _ in node.value:
            name, line = str(key.value), key.start_mark.line + 1
            if name in lines and name != "<<":
                found = f"found twice, in lines {lines[name]} and {line}"
                self.repeated.append(FieldProblem(name, found, "each field once"))
            lines[name] = line
        return super().construct_mapping(node, deep)


def load_yaml(text: str) -> tuple[object, list[FieldProblem]]:
    """The content of a YAML text, and a problem for every key that stands twice in a mapping.

    Raises:
        Exception: of any kind PyYAML has: the text is not YAML, or no tree of reasonable size.
    """
    loader = _Loader(text)
    try:
        return _tree(loader.get_single_data(), _MAX_DEPTH, [_MAX_VALUES]), loader.repeated
    finally:
        loader.dispose()


def _tree(value: object, depth: int, left: list[int]) -> object:
    # Aliases make a YAML text refer to itself, or stand for more values than a memory holds.
    left[0] -= 1
    if depth == 0 or left[0] < 0:
        raise ValueError("nested too deeply, or too large")
    if isinstance(value, Mapping):
        return {key: _tree(v, depth - 1, left) for key, v in cast("Mapping[object, object]", value).items()}
    if isinstance(value, list):
        return [_tree(v, depth - 1, left) for v in cast("list[object]", value)]
    return Truth(value) if isinstance(value, bool) else value


def rig_problems(content: Mapping[str, object], error: ValidationError) -> list[FieldProblem]:
    """Every problem of a rig: those of single fields, and those between fields as far as they can be seen."""
    details = [d for d in error.errors() if d["type"] != "value_error" and not _other_arm(d)]
    details = [d for d in details if not is_short_by_wrong_entries(d, details)]
    problems = list(dict.fromkeys(_problem(detail) for detail in details))
    sieved = _copy(content)
    for detail in details:
        _blank(sieved, _place(detail))
    return [*problems, *inconsistent_fields(cast("Mapping[str, object]", sieved))]


def _problem(detail: ErrorDetails) -> FieldProblem:
    loc, kind, value = detail["loc"], detail["type"], cast("object", detail["input"])
    if _SENSITIVITY in loc:
        return _sensitivity_problem(detail)
    field = _path(loc)
    if kind == "extra_forbidden":
        return FieldProblem(field, "no such field", _nearest(loc))
    found = "missing" if kind == "missing" else f"found {quoted_value(value)}"
    if kind == "literal_error" and loc == ("format_version",):
        return FieldProblem(field, found, "1 or 2; a newer file needs a newer modallab")
    return FieldProblem(field, found, allowed_values(detail))


def _other_arm(detail: ErrorDetails) -> bool:
    # pydantic reports both arms of "a number or a number per test"; the value shows which of them was meant.
    whole, value = _place(detail)[-1] == _SENSITIVITY, cast("object", detail["input"])
    if _SENSITIVITY not in detail["loc"] or not whole:
        return False
    return isinstance(value, Mapping) or (isinstance(value, float) and detail["type"] == "dict_type")


def _sensitivity_problem(detail: ErrorDetails) -> FieldProblem:
    place, value = _place(detail), cast("object", detail["input"])
    if "[key]" in detail["loc"]:
        return FieldProblem(_path(place), "no such test", " or ".join(_TESTS))
    whole = place[-1] == _SENSITIVITY and not isinstance(value, float)
    return FieldProblem(_path(place), f"found {quoted_value(value)}", _PER_TEST if whole else allowed_values(detail))


def _place(detail: ErrorDetails) -> tuple[int | str, ...]:
    loc = detail["loc"]
    if _SENSITIVITY in loc:
        stem = loc.index(_SENSITIVITY) + 1
        return loc[:stem] + tuple(part for part in loc[stem + 1 :] if part != "[key]")
    return loc


def _nearest(loc: Sequence[int | str]) -> str:
    section = "" if len(loc) == 1 else str(loc[0])
    fields = list((Certificate if "certificate" in loc else SECTIONS[section]).model_fields)
    near = get_close_matches(str(loc[-1]), fields, n=1, cutoff=0.5)
    return f"did you mean {near[0]}?" if near else ", ".join(fields)


def _path(loc: Sequence[int | str]) -> str:
    text = ""
    for part in loc:
        text += f"[{part}]" if isinstance(part, int) and text else f".{part}" if text else str(part)
    return text


def _copy(content: object) -> object:
    if isinstance(content, Mapping):
        return {key: _copy(value) for key, value in cast("Mapping[object, object]", content).items()}
    return [_copy(value) for value in cast("list[object]", content)] if isinstance(content, list) else content


def _blank(content: object, place: Sequence[int | str]) -> None:
    for part in place[:-1]:
        content = cast("Any", content)[part]
    if isinstance(content, dict | list):
        cast("Any", content)[place[-1]] = INVALID
