"""Which records of a campaign can be identified: what a converter or a cable spoilt is left out by name."""

from collections.abc import Iterable, Sequence

from modallab.core.array_checks import check_signals, moving_channels
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.formats.error_list import Collected
from modallab.signals.checks import overloaded_channels
from modallab.signals.faults.found import faults_of
from modallab.signals.faults.runs import Fault

_NAMED = 3
"""Faults that a message lists; more of them are counted."""


def undamaged_records(
    campaign: Campaign, blocks: Sequence[Block], force: str | None
) -> tuple[tuple[Block, ...], tuple[str, ...]]:
    """The records without those at full scale or with faults in their samples, and a note on these.

    Args:
        campaign: of the records.
        blocks: of one test.
        force: name of the channel that must be alive; None if none was measured.

    Raises:
        DataError: damaged samples, or no record is left.
    """
    errors, moving = Collected(), moving_channels((b.channels, b.samples) for b in blocks)
    for block in blocks:
        where = f"{campaign.source}, record {block.name}"
        with errors:
            check_signals(block.samples, block.channels, where, force=force, moving=moving)
    errors.done()
    over = [b.name for b in blocks if overloaded_channels(b, campaign.rig)]
    faults = {b.name: found for b in blocks if b.name not in over and (found := faults_of(b, campaign.rig))}
    clean = tuple(b for b in blocks if b.name not in over and b.name not in faults)
    if not clean and not faults:
        raise DataError(
            f"all {len(blocks)} records run into the converter's full scale",
            where=campaign.source,
            remedy="lower the drive or the preamplifiers' gain and record again",
        )
    if not clean:
        raise DataError(
            f"every record has a fault in its samples: {_faults_in_words(faults.items())}",
            where=campaign.source,
            remedy="record again with another range or cable; or leave the channel out of both rig and recording",
        )
    notes = [f"Left out, because they ran into the converter's full scale: {', '.join(over)}."] if over else []
    notes += [f"Left out, because of faults in their samples: {_faults_in_words(faults.items())}."] if faults else []
    return clean, tuple(notes)


def _faults_in_words(faults: Iterable[tuple[str, tuple[Fault, ...]]]) -> str:
    each = [f"{name}, {fault}" for name, found in faults for fault in found]
    more = f"; and {len(each) - _NAMED} more" if len(each) > _NAMED else ""
    return "; ".join(each[:_NAMED]) + more
