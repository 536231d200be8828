"""Which records are held out: those a fit has never seen say how far the gap shrinks.

Source: Stone, J. R. Stat. Soc. B 36 (1974), 111, on judging a model by data that did not make it.
"""

from collections.abc import Sequence
from typing import TypeVar

from modallab.core.block import Block
from modallab.core.errors import PlanError
from modallab.core.units import BROADBAND, TESTS

RULES = "mixed, spread, point:N, level:NAME, test:impact, test:sine, last:SHARE"


T = TypeVar("T")

WHERE_POSSIBLE = ("mixed", "spread")
"""Rules that hold nothing out where there are too few records."""


def split(blocks: Sequence[Block], rule: str) -> tuple[list[Block], list[Block]]:
    """(fitted, held out).

    Args:
        blocks: all records, in the order of time.
        rule: `mixed` (one drive point of several, every third sine frequency), `spread` (every third hit at each point
            instead), `point:N`, `level:NAME`, `test:sine`, `test:impact`, or `last:SHARE` of the records in time.

    Raises:
        PlanError: the rule is not one of these, or leaves nothing to fit or nothing held out.
    """
    kind, _, value = rule.partition(":")
    if kind in WHERE_POSSIBLE:
        held = _third_of_hits(blocks, each_point=kind == "spread") | _third_of_sines(blocks) | _third_of_drives(blocks)
    elif kind == "point" and value.isdigit():
        held = {b.name for b in blocks if b.drive_point == int(value)}
    elif kind == "level" and value:
        held = {b.name for b in blocks if b.level == value}
    elif kind == "test" and value in TESTS:
        held = {b.name for b in blocks if b.test == value}
    elif kind == "last" and _is_share(value):
        held = {b.name for b in blocks[round(len(blocks) * (1 - float(value))) :]}
    else:
        raise PlanError(f"no rule {rule!r} to hold records out", remedy=f"use one of {RULES}")
    fitted = [b for b in blocks if b.name not in held]
    if not fitted or (not held and kind not in WHERE_POSSIBLE):
        raise PlanError(
            f"the rule {rule!r} holds out {len(held)} of {len(blocks)} records",
            remedy=f"choose another: {RULES}",
        )
    return fitted, [b for b in blocks if b.name in held]


def third(listed: Sequence[T], first: int) -> Sequence[T]:
    """Every third of a list, from this place on: what is held out of it."""
    return listed[first::3]


def _third_of_hits(blocks: Sequence[Block], each_point: bool) -> set[str]:
    hits = [b for b in blocks if b.test == "impact"]
    points = list(dict.fromkeys(b.drive_point for b in hits))
    if len(points) > 1 and not each_point:
        return {b.name for b in hits if b.drive_point == points[-1]}
    return {b.name for p in points for b in third([h for h in hits if h.drive_point == p], 2)}


def _third_of_sines(blocks: Sequence[Block]) -> set[str]:
    frequencies = sorted({b.frequency_hz for b in blocks if b.test == "sine" and b.frequency_hz})
    chosen = set(third(frequencies, 1))
    return {b.name for b in blocks if b.test == "sine" and b.frequency_hz in chosen}


def _third_of_drives(blocks: Sequence[Block]) -> set[str]:
    driven = [b for b in blocks if b.test in BROADBAND]
    drives = list(dict.fromkeys((b.test, b.level) for b in driven))
    return {b.name for d in drives for b in third([b for b in driven if (b.test, b.level) == d], 1)}


def _is_share(value: str) -> bool:
    try:
        return 0 < float(value) < 1
    except ValueError:
        return False
