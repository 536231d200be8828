"""Whether a campaign is whole in itself, and whether its recordings can be measurements."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from modallab.core.array_checks import check_frf, check_rate, check_samples, check_signals
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, ErrorCollection
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.core.units import TO_SI, is_voltage


def check_structure(campaign: Campaign) -> None:
    """Reject a campaign whose parts do not belong together.

    Raises:
        DataError: repeated or unusable names, channels that are not those of the rig, scales or units that are none.
    """
    errors = ErrorCollection()
    for name, count in Counter(block.name for block in campaign.blocks).items():
        with errors:
            _check_name(name, count, campaign.source)
    for block in campaign.blocks:
        place = _Place(_place_of(campaign, block))
        with errors:
            place.check_block(block, campaign.rig)
    for frf in campaign.frfs:
        with errors:
            _check_outputs(frf, campaign.rig, campaign.source)
    errors.raise_collected()


def check_recordings(campaign: Campaign) -> None:
    """Reject samples and FRFs that no measurement can hold, and records of which none holds a force and a response.

    One that does not, beside others, is for the identification to leave out.

    Raises:
        DataError: one message with everything found in any record.
    """
    check_values(campaign)
    empty = ErrorCollection()
    force = campaign.rig.force.name if campaign.rig.force else None
    for block in campaign.blocks:
        with empty:
            check_signals(block.samples, block.channels, _place_of(campaign, block), force=force)
    if len(empty.errors) == len(campaign.blocks):
        empty.raise_collected()


def check_values(campaign: Campaign) -> None:
    """Reject samples and FRFs that no measurement can hold; see `modallab.core.array_checks`.

    Raises:
        DataError: one message with everything found in any record.
    """
    errors = ErrorCollection()
    for block in campaign.blocks:
        with errors:
            check_samples(block.samples, block.channels, _place_of(campaign, block))
    for frf in campaign.frfs:
        with errors:
            check_frf(frf.frequency_hz, frf.values, frf.outputs, campaign.source, even=False)
    errors.raise_collected()


def _place_of(campaign: Campaign, block: Block) -> str:
    return f"{campaign.source}, record {block.name}" if campaign.source else f"record {block.name}"


def check_channels(names: tuple[str, ...], rig: Rig, where: str) -> None:
    """Reject channels that are not those of the rig, in its order.

    Raises:
        DataError: names what is missing, unknown or out of order.
    """
    requested = tuple(channel.name for channel in rig.channels)
    if names == requested:
        return
    missing = [name for name in requested if name not in names]
    unknown = [name for name in names if name not in requested]
    parts = [f"{len(names)} channels where the rig has {len(requested)}"] if len(names) != len(requested) else []
    parts += [f"no channel {', '.join(missing)}"] if missing else []
    parts += [f"channel {', '.join(unknown)} is not on the rig"] if unknown else []
    found = "; ".join(parts) or f"channels in the order {', '.join(names)}, on the rig {', '.join(requested)}"
    raise DataError(found, where=where, remedy="make rig and recording name the same channels, in the same order")


@dataclass(frozen=True)
class _Place:
    where: str

    def check_block(self, block: Block, rig: Rig) -> None:
        check_rate(block.rate_hz, self.where)
        check_channels(block.channels, rig, self.where)
        n = len(block.channels)
        lengths = {len(block.samples), len(block.scale), len(block.units), n}
        if len(lengths) > 1 or (block.overload is not None and len(block.overload) != n):
            raise DataError(
                f"{len(block.samples)} rows of samples, {len(block.scale)} scales and {len(block.units)} units "
                f"for {n} channels",
                where=self.where,
                remedy="give one of each for every channel",
            )
        self._check_scales(block, rig)

    def _check_scales(self, block: Block, rig: Rig) -> None:
        for channel, scale, unit in zip(rig.channels, block.scale, block.units, strict=True):
            where = f"{self.where}, channel {channel.name}"
            if not (np.isfinite(scale) and scale != 0):
                raise DataError(f"the scale is {scale:g}", where=where, remedy=f"give the {unit} of one count")
            if not is_voltage(unit) and unit not in TO_SI[channel.quantity]:
                raise DataError(
                    f"unit {unit!r} is no unit of {channel.quantity}",
                    where=where,
                    remedy=f"give it in one of {', '.join(TO_SI[channel.quantity])}, or in V or mV; or correct the rig",
                )


def _check_name(name: str, count: int, where: str) -> None:
    if count > 1:
        raise DataError(f"{count} records are named {name!r}", where=where, remedy="give each record its own name")
    if not name or "/" in name or name in {".", ".."} or "\0" in name:
        raise DataError(f"a record is named {name!r}", where=where, remedy="use a name without / and not empty")


def _check_outputs(frf: Frf, rig: Rig, where: str) -> None:
    known = [channel.name for channel in rig.responses]
    unknown = [name for name in frf.outputs if name not in known]
    if unknown:
        raise DataError(
            f"FRFs of {', '.join(unknown)}, which the rig does not have; it has {', '.join(known)}",
            where=where,
            remedy="make rig and recording name the same channels",
        )
