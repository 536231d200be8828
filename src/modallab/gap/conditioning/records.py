"""Records of a campaign that a diagnosis can use: in V, with a force that says what drove them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
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
