"""Records of a campaign that a diagnosis can use: in V, with a force that says what drove them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import gcd
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, PlanError
from modallab.core.hold_out import RULES, HoldOut
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.gap.conditioning.hum import Hum, without_hum
from modallab.signals.checks import check_block
from modallab.signals.conversion import Conversion, block_in_volts
from modallab.signals.drive_kind import check_kind, is_hit
from modallab.signals.hit import find_hit
from modallab.signals.signals import to_signals


def records_in_volts(campaign: Campaign) -> Campaign:
    """The campaign with every record as its converter saw it: noise, hum and flat tops are of volts.

    Raises:
        DataError: a rig of several shakers, a record with other channels than the rig's, or in units that are none of
            its channels'.
    """
    forces = campaign.rig.forces
    if len(forces) > 1:
        raise DataError(
            f"the rig has {len(forces)} force channels, and a diagnosis models one force only",
            where=campaign.source,
            remedy="record hits or sines with a rig file without shakers and their force channels",
        )
    for block in campaign.blocks:
        check_block(block, campaign.rig)
    return replace(campaign, blocks=tuple(block_in_volts(b, campaign.rig) for b in campaign.blocks))


def usable_records(campaign: Campaign, hum: Hum | None = None) -> tuple[Block, ...]:
    """The records that say where they were driven and hold a force.

    Args:
        campaign: in V.
        hum: what hides hits on the row of the force, where it is known.

    Raises:
        DataError: there are none.
    """
    rig = campaign.rig
    found = [
        b
        for b in campaign.blocks
        if b.drive_point is not None
        and np.ptp(b.samples[rig.force_channel.index]) > 0
        and _states_its_drive(b if hum is None else without_hum(b, hum), rig)
    ]
    if not found:
        check_kind([to_signals(b, rig) for b in campaign.blocks if b.test == "impact"])
        raise DataError(
            f"none of {len(campaign.blocks)} records has a force, a drive point and all channels of the rig",
            where=campaign.source,
            remedy="record hits or sines with the force channel connected, and give their drive points",
        )
    return tuple(sorted(found, key=lambda b: b.order))


def records_as_recorded(campaign: Campaign, cleaned: Sequence[Block]) -> list[Block]:
    """Records as they came, but for a force in which hum hides the hit, and for drives, which are joined.

    Args:
        campaign: in V.
        cleaned: the records that are asked for, without their hum.
    """
    rig, force = campaign.rig, campaign.rig.force_channel.index
    clean = {b.name: b for b in cleaned}
    found: list[Block] = []
    for b in campaign.blocks:
        if b.name in clean and b.test in BROADBAND:
            found.append(clean[b.name])
        elif b.name in clean:
            hidden = b.test == "impact" and not _has_hit(b, rig)
            found.append(_with_row(b, force, clean[b.name].samples[force]) if hidden else b)
    return found


def _states_its_drive(block: Block, rig: Rig) -> bool:
    """Whether a record says what drove it."""
    return _has_hit(block, rig) if block.test == "impact" else block.test in BROADBAND or bool(block.frequency_hz)


def _has_hit(block: Block, rig: Rig) -> bool:
    force = Conversion.of_block(block, rig).force_n(block.samples)
    try:
        find_hit(force)
    except DataError:
        return False
    return is_hit(force)


def _with_row(block: Block, row: int, counts: NDArray[Any]) -> Block:
    samples = block.samples.astype(np.float64)
    samples[row] = counts
    return replace(block, samples=samples)


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


def every_third(listed: Sequence[T], first: int) -> Sequence[T]:
    """Every third of a list, from this place on: what is held out of it."""
    return listed[first::3]


def _third_of_hits(blocks: Sequence[Block], each_point: bool) -> set[str]:
    hits = [b for b in blocks if b.test == "impact"]
    points = list(dict.fromkeys(b.drive_point for b in hits))
    if len(points) > 1 and not each_point:
        return {b.name for b in hits if b.drive_point == points[-1]}
    return {b.name for p in points for b in every_third([h for h in hits if h.drive_point == p], 2)}


def _third_of_sines(blocks: Sequence[Block]) -> set[str]:
    frequencies = sorted({b.frequency_hz for b in blocks if b.test == "sine" and b.frequency_hz})
    chosen = set(every_third(frequencies, 1))
    return {b.name for b in blocks if b.test == "sine" and b.frequency_hz in chosen}


def _third_of_drives(blocks: Sequence[Block]) -> set[str]:
    driven = [b for b in blocks if b.test in BROADBAND]
    drives = list(dict.fromkeys((b.test, b.level) for b in driven))
    return {b.name for d in drives for b in every_third([b for b in driven if (b.test, b.level) == d], 1)}


SHARE = 0.02
"""Smallest share of a record's samples that counts as a flat top."""
MORE, FEW = 3.0, 4
"""Times a sine's own share at its top, and how many of its phases besides may stand there by chance."""


REPEATS_IN = 4
"""A sine that repeats at least so many times in a block, sample by sample, has a few phases only."""


@dataclass(frozen=True, slots=True)
class ClippedChannel:
    """A channel that is cut.

    Attributes:
        row: its row.
        volts: the level.
        records: names of the records that reach it.
    """

    row: int
    volts: float
    records: tuple[str, ...]


def find_clipped(blocks: Sequence[Block], noise_v: Real, full_scale_v: Real, force: int) -> list[ClippedChannel]:
    """Channels but the force's with flat tops below their (rows,) full scale in V."""
    found: list[ClippedChannel] = []
    for row in (r for r in range(len(noise_v)) if r != force):
        peaks = np.array([np.max(np.abs(b.samples[row] * b.scale[row])) for b in blocks])
        level = float(np.max(peaks))
        if level > 0.999 * full_scale_v[row]:
            continue
        near = 6 * noise_v[row]
        flat = [i for i, b in enumerate(blocks) if peaks[i] > level - near and _is_flat(b, row, peaks[i], near)]
        if flat:
            level = float(np.median([_clipping_level(blocks[i], row, peaks[i], near) for i in flat]))
            reached = tuple(b.name for b, p in zip(blocks, peaks, strict=True) if p > level - near)
            found.append(ClippedChannel(row, level, reached))
    return found


def _clipping_level(block: Block, row: int, peak: float, near: float) -> float:
    volts = np.abs(block.samples[row] * block.scale[row])
    return float(np.median(volts[volts > peak - near]))


def _is_flat(block: Block, row: int, peak: float, near: float) -> bool:
    """Whether more samples, or longer runs of them, stay at the top than a sine of this frequency could."""
    volts = np.abs(block.samples[row] * block.scale[row])
    top = volts > peak - near
    share = float(np.mean(top))
    # What noise fills to half the peak and beyond has no top of its own.
    if block.test == "impact" or not block.frequency_hz or share < SHARE or near > peak / 2:
        return False
    own = 2 / np.pi * np.arccos(1 - min(near / peak, 1.0))
    if share > MORE * own + FEW / _phases_of_sine(block.frequency_hz / block.rate_hz, block.n_samples):
        return True
    arc = 2 * np.arccos(1 - min(near / peak, 1.0)) / (2 * np.pi * block.frequency_hz) * block.rate_hz
    edges = np.diff(np.concatenate([[0], top.astype(int), [0]]))
    runs = np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
    # A sine that repeats after few samples may have the same two of them beside its top in every period.
    repeats = _phases_of_sine(block.frequency_hz / block.rate_hz, block.n_samples) * REPEATS_IN < block.n_samples
    return float(np.mean(runs)) > 1.8 * arc + (2 if repeats else 1)


def _phases_of_sine(per_sample: float, n: int) -> int:
    """How many different phases the samples of a sine see: few, where it repeats after some samples."""
    periods = round(per_sample * n)
    return n // gcd(periods, n) if periods and abs(per_sample * n - periods) < 0.02 else n
