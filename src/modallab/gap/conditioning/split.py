"""Which records are held out: those a fit has never seen say how far the gap shrinks.

Source: Stone, J. R. Stat. Soc. B 36 (1974), 111, on judging a model by data that did not make it.
"""

from collections.abc import Sequence
from typing import TypeVar

from modallab.core.block import Block
from modallab.core.errors import PlanError
from modallab.core.hold_out import RULES, HoldOut
from modallab.core.units import BROADBAND

T = TypeVar("T")


def split_held_out(blocks: Sequence[Block], hold_out: HoldOut) -> tuple[list[Block], list[Block]]:
    """(fitted, held out) of all records, which are given in the order of time.

    Raises:
        PlanError: the rule leaves nothing to fit or nothing held out.
    """
    held = _is_held_out(blocks, hold_out)
    fitted = [b for b in blocks if b.name not in held]
    if not fitted or not (held or hold_out.where_possible):
        raise PlanError(
            f"the rule '{hold_out}' holds out {len(held)} of {len(blocks)} records",
            remedy=f"choose another: {RULES}",
        )
    return fitted, [b for b in blocks if b.name in held]


def _is_held_out(blocks: Sequence[Block], hold_out: HoldOut) -> set[str]:
    value = hold_out.value
    match hold_out.rule:
        case "point":
            return {b.name for b in blocks if b.drive_point == int(value)}
        case "level":
            return {b.name for b in blocks if b.level == value}
        case "test":
            return {b.name for b in blocks if b.test == value}
        case "last":
            return {b.name for b in blocks[round(len(blocks) * (1 - float(value))) :]}
        case rule:
            hits = _third_of_hits(blocks, each_point=rule == "spread")
            return hits | _third_of_sines(blocks) | _third_of_drives(blocks)


def one_third_of(listed: Sequence[T], first: int) -> Sequence[T]:
    """Every third of a list, from this place on: what is held out of it."""
    return listed[first::3]


def _third_of_hits(blocks: Sequence[Block], each_point: bool) -> set[str]:
    hits = [b for b in blocks if b.test == "impact"]
    points = list(dict.fromkeys(b.drive_point for b in hits))
    if len(points) > 1 and not each_point:
        return {b.name for b in hits if b.drive_point == points[-1]}
    return {b.name for p in points for b in one_third_of([h for h in hits if h.drive_point == p], 2)}


def _third_of_sines(blocks: Sequence[Block]) -> set[str]:
    frequencies = sorted({b.frequency_hz for b in blocks if b.test == "sine" and b.frequency_hz})
    chosen = set(one_third_of(frequencies, 1))
    return {b.name for b in blocks if b.test == "sine" and b.frequency_hz in chosen}


def _third_of_drives(blocks: Sequence[Block]) -> set[str]:
    driven = [b for b in blocks if b.test in BROADBAND]
    drives = list(dict.fromkeys((b.test, b.level) for b in driven))
    return {b.name for d in drives for b in one_third_of([b for b in driven if (b.test, b.level) == d], 1)}
