"""What people type at a prompt, looked at before anything is computed: a band, frequencies, a plan, a file's name."""

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from numbers import Real
from pathlib import Path
from typing import cast

from pydantic import TypeAdapter, ValidationError

from modallab.core.errors import DataError, PlanError, StorageError
from modallab.core.field_errors import error_sentences
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan
from modallab.formats.plan_file import read_plans

_PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)


def band_of(given: object) -> tuple[float, float] | None:
    """A band in Hz, lower edge first.

    Raises:
        DataError: it is not two finite numbers.
    """
    if given is None:
        return None
    edges = _numbers(given)
    if edges is None or len(edges) != 2:
        raise DataError(f"band={given!r} is no pair of numbers", remedy="give both edges in Hz: band=(3, 110)")
    return edges[0], edges[1]


def frequencies_of(given: object, name: str) -> tuple[float, ...]:
    """Frequencies in Hz; a single one may stand by itself.

    Raises:
        DataError: they are no numbers.
    """
    found = _numbers([given] if isinstance(given, Real) else given)
    if found is None:
        raise DataError(
            f"{name}={given!r} is no list of numbers", remedy=f"give frequencies in Hz: {name}=(4.75, 30.5)"
        )
    return found


def plans_of(given: object) -> list[Plan] | None:
    """Plans: one or several, as objects, as their fields, or in a plan file.

    Raises:
        PlanError: none of these, or a plan that is wrong.
    """
    if given is None:
        return None
    if isinstance(given, str | Path):
        return read_plans(Path(given))
    several = isinstance(given, Sequence) and not isinstance(given, bytes)
    return [_plan_of(one) for one in cast("Sequence[object]", given if several else [given])]


def path_for(given: object, suffixes: Sequence[str]) -> Path:
    """The path to write to, whose ending says what is written.

    Raises:
        StorageError: it is no path, or ends otherwise.
    """
    path = Path(given) if isinstance(given, str | Path) else Path()
    if path.suffix.lower() not in suffixes:
        raise StorageError(
            f"{given!r} does not end in {' or '.join(suffixes)}", remedy=f"name a file such as result{suffixes[0]}"
        )
    return path


def _plan_of(given: object) -> Plan:
    if isinstance(given, ImpactPlan | SinePlan | BroadbandPlan):
        return given
    if not isinstance(given, Mapping):
        raise PlanError(
            f"{given!r} is no plan", remedy='give fields: plan={"kind": "impact", "points": [10], "hits": 5}'
        )
    try:
        return _PLAN.validate_python(given)
    except ValidationError as error:
        raise PlanError(
            "; ".join(error_sentences(error)), remedy="docs/reference/plan.md describes every field"
        ) from error


def _numbers(given: object) -> tuple[float, ...] | None:
    if isinstance(given, str | bytes) or not isinstance(given, Iterable):
        return None
    listed = list(cast("Iterable[object]", given))
    if not all(isinstance(one, Real) and isfinite(one) for one in listed):
        return None
    return tuple(float(cast("float", one)) for one in listed)
