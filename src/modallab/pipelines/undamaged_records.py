"""Which records of a campaign can be identified: what a converter or a cable spoilt is left out by name."""

from collections.abc import Collection, Mapping, Sequence

from modallab.core.array_checks import check_samples
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, ErrorCollection
from modallab.core.rig import Rig
from modallab.signals.faults.all_faults import find_faults
from modallab.signals.faults.repeats import SampleFault

_NAMED = 3
"""Faults that a message lists; more of them are counted."""


def undamaged_records(
    campaign: Campaign, blocks: Sequence[Block], unused: Collection[str] = ()
) -> tuple[tuple[Block, ...], Rig, tuple[str, ...]]:
    """The sound part of the records, the rig with its channels only, and notes on what was left out.

    A response at fault in most records is left out of all; other records at full scale or with faults go as a whole,
    as one does whose force is dead.

    Args:
        campaign: of the records.
        blocks: of one test.
        unused: names of channels that nobody asks for: they are left out, and what is wrong with them does not matter.

    Raises:
        DataError: damaged samples, or no record is left.
    """
    errors, rig = ErrorCollection(), campaign.rig.without(unused)
    blocks = [_without(block, unused) for block in blocks]
    for block in blocks:
        with errors:
            check_samples(block.samples, block.channels, f"{campaign.source}, record {block.name}")
    errors.raise_collected()
    faults = {b.name: found for b in blocks if (found := find_faults(b, rig))}
    spoilt = _spoilt_channels(faults, len(blocks), rig)
    left = {n: rest for n, found in faults.items() if (rest := tuple(f for f in found if f.channel not in spoilt))}
    sound = tuple(_without(b, spoilt) for b in blocks if b.name not in left)
    if not sound:
        raise DataError(
            f"every record has a fault: {_faults_in_words(left)}",
            where=campaign.source,
            remedy="record again with less drive, another range or cable; or leave the channel out of rig file and "
            "record",
        )
    notes = [
        f"Left out, channel {name}, at fault in {count} of {len(blocks)} records: {first}."
        for name, (count, first) in spoilt.items()
    ]
    notes += [f"Left out, because of faults in their samples: {_faults_in_words(left)}."] if left else []
    return sound, rig.without(spoilt), tuple(notes)


def _spoilt_channels(
    faults: Mapping[str, tuple[SampleFault, ...]], records: int, rig: Rig
) -> dict[str, tuple[int, str]]:
    """Responses at fault in more than half of the records, with in how many and the first fault; not all of them."""
    found: dict[str, tuple[int, str]] = {}
    for channel in rig.responses:
        of = [(name, f) for name, each in faults.items() for f in each if f.channel == channel.name]
        count = len({name for name, _ in of})
        if 2 * count > records:
            found[channel.name] = count, f"{of[0][0]}, {of[0][1].in_words}"
    return found if len(found) < len(rig.responses) else {}


def _without(block: Block, channels: Collection[str]) -> Block:
    """The block without these channels."""
    if not channels:
        return block
    return block.with_channels([k for k, name in enumerate(block.channels) if name not in channels])


def _faults_in_words(faults: Mapping[str, tuple[SampleFault, ...]]) -> str:
    each = [f"{name}, {fault}" for name, found in faults.items() for fault in found]
    more = f"; and {len(each) - _NAMED} more" if len(each) > _NAMED else ""
    return "; ".join(each[:_NAMED]) + more
