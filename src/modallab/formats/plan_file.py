"""The plan file: YAML to plans, with everything that is wrong said at once."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import yaml
from pydantic import TypeAdapter, ValidationError

from modallab.core.errors import PlanError
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan

_PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)
_KINDS = {"impact": ImpactPlan, "sine": SinePlan, "broadband": BroadbandPlan}
_REMEDY = "mend what is named; docs/reference/plan.md describes every field"
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
    if kind not in _KINDS:
        found = "no kind is given" if kind is None else f"no test is of kind {kind!r}"
        return [f"{found}; allowed: {', '.join(_KINDS)}"]
    found = [_problem(str(kind), cast("dict[str, Any]", dict(one))) for one in error.errors()]
    return list(dict.fromkeys(found))


def _problem(kind: str, error: dict[str, Any]) -> str:
    place = [str(part) for part in error["loc"] if part not in _KINDS and "[" not in str(part)]
    field, kind_of = ".".join(place) or kind, error["type"]
    if kind_of == "extra_forbidden":
        return f"{field} is no field here; allowed: {', '.join(_KINDS[kind].model_fields) if len(place) == 1 else ''}"
    if kind_of == "missing":
        return f"{field} is missing"
    said = str(error["msg"]).removeprefix("Value error, ").removeprefix("Input ").replace("\n", "; ")
    said = said.replace("should be a valid dictionary", "should be fields, each as name: value")
    return f"{field} is {str(error['input'])[:40]!r}, and {said}"


def _first_line(error: Exception) -> str:
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        return f"line {error.problem_mark.line + 1}: {error.problem or error.context}"
    return str(error).partition("\n")[0]
