"""The plan file: YAML to plans, with everything that is wrong said at once."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import yaml
from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails
from yaml.composer import ComposerError

from modallab.core.errors import PlanError
from modallab.core.field_errors import allowed_values, is_short_by_wrong_entries, quoted_value
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan

_PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)
_KINDS = {"impact": ImpactPlan, "sine": SinePlan, "broadband": BroadbandPlan}
_REMEDY = "correct what is named; docs/reference/plan.md describes every field"
_EXAMPLE = "write for instance: {kind: impact, points: [10, 6], hits: 5}"


def read_plans(path: Path) -> list[Plan]:
    """The tests of a plan file: one test, or a list of them.

    Raises:
        PlanError: it cannot be read, or one error with everything that is wrong: test, field, value, what is allowed.
    """
    listed = _entries(path)
    plans: list[Plan] = []
    problems: list[str] = []
    for number, entry in enumerate(listed, 1):
        where = f"test {number}: " if len(listed) > 1 else ""
        try:
            plans.append(_PLAN.validate_python(entry))
        except ValidationError as error:
            problems += [f"{where}{problem}" for problem in _problems(entry, error)]
    if problems:
        raise PlanError("; ".join(problems), where=str(path), remedy=_REMEDY)
    return plans


def _entries(path: Path) -> list[object]:
    try:
        content: object = yaml.safe_load(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        found = "is a folder" if path.is_dir() else f"cannot be read: {error.strerror or error}"
        raise PlanError(found, where=str(path), remedy="name the YAML file with the plan") from error
    except UnicodeDecodeError as error:
        raise PlanError("is not text in UTF-8", where=str(path), remedy=_EXAMPLE) from error
    except ComposerError as error:
        raise PlanError(
            f"is not one YAML document: {_first_line(error)}",
            where=str(path),
            remedy="write several tests as a list, each behind a dash: - {kind: impact, points: [10]}",
        ) from error
    except (yaml.YAMLError, ValueError) as error:
        raise PlanError(f"is not YAML: {_first_line(error)}", where=str(path), remedy=_EXAMPLE) from error
    if isinstance(content, Mapping) and "tests" in content:
        content = cast("Mapping[str, object]", content)["tests"]
    listed = cast("list[object]", content) if isinstance(content, list) else [content]
    if content is None or not listed:
        raise PlanError("holds no test", where=str(path), remedy=_EXAMPLE)
    return listed


def _problems(entry: object, error: ValidationError) -> list[str]:
    if not isinstance(entry, Mapping):
        return [f"{str(entry)[:40]!r} is no test; {_EXAMPLE}"]
    fields = cast("Mapping[str, Any]", entry)
    kind = fields.get("kind")
    if "channels" in fields:
        return ["describes a rig, no test; name the file of the plan here, and the rig file in its own place"]
    if kind not in _KINDS:
        found = "no kind is given" if kind is None else f"no test is of kind {kind!r}"
        return [f"{found}; allowed: {', '.join(_KINDS)}"]
    details = error.errors()
    kept = [one for one in details if not is_short_by_wrong_entries(one, details)]
    return list(dict.fromkeys(_problem(str(kind), one) for one in kept))


def _problem(kind: str, error: ErrorDetails) -> str:
    place = [str(part) for part in error["loc"] if part not in _KINDS and "[" not in str(part)]
    field = ".".join(place) or kind
    if error["type"] == "extra_forbidden":
        return (
            f"{field} is an unknown field; allowed: {', '.join(_KINDS[kind].model_fields) if len(place) == 1 else ''}"
        )
    if error["type"] == "missing":
        return f"{field} is missing"
    if error["type"] == "value_error":
        return f"{field}: {allowed_values(error)}"
    return f"{field} is {quoted_value(error['input'])}; allowed: {_allowed(error)}"


def _allowed(error: ErrorDetails) -> str:
    return "a list, such as [10, 6]" if error["type"] == "tuple_type" else allowed_values(error)


def _first_line(error: Exception) -> str:
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        return f"line {error.problem_mark.line + 1}: {error.problem or error.context}"
    return str(error).partition("\n")[0]
