"""A campaign in a format of others, by the format's name."""

from collections.abc import Sequence
from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.formats.format import Format, find_writer

_PARTS = {"records": "time records", "FRFs": "FRFs"}


def write_export(campaign: Campaign, out: Path, format_: str, models: Sequence[ModalModel] = ()) -> tuple[str, ...]:
    """Write a campaign, and models that were identified from it where the format holds such.

    Args:
        campaign: records, FRFs and the rig.
        out: file or folder to write.
        format_: name of a format that has a writer.
        models: identified from it.

    Returns:
        what had no place in the format, in plain sentences.

    Raises:
        DataError: no such format, there is nothing that it holds, or no place for a record of several forces.
        StorageError, DiskFullError: it cannot be written.
    """
    used = find_writer(format_)
    assert used.write is not None
    _require_place_of_forces(campaign, used)
    left_out = _without_place(campaign, used)
    if "modes" in used.holds:
        used.write(campaign, out, models)
    else:
        left_out += [f"{format_} has no place for modal models; they were left out"] if models else []
        used.write(campaign, out)
    return tuple(left_out)


def _require_place_of_forces(campaign: Campaign, used: Format) -> None:
    several = next((block for block in campaign.blocks if block.also_driven), None)
    if several is None or used.several_forces or "records" not in used.holds:
        return
    points = " and ".join(map(str, several.driven_points))
    raise DataError(
        f"forces at the points {points} drove at once, and a record in {used.name} names one point of one force",
        where=f"record {several.name}",
        remedy="export as hdf5, which holds them all",
    )


def _without_place(campaign: Campaign, used: Format) -> list[str]:
    """What of the campaign the format does not hold.

    Raises:
        DataError: that is everything there is.
    """
    held, others = ([p for p in _PARTS if (p in used.holds) == holds] for holds in (True, False))
    there = {"records": campaign.blocks, "FRFs": campaign.frfs}
    if len(held) == 1 and not there[held[0]]:
        raise DataError(f"there are no {_PARTS[held[0]]}, and {used.name} holds nothing else", remedy="export as uff")
    return [f"{used.name} holds {_PARTS[held[0]]} only; {_PARTS[p]} were left out" for p in others if held and there[p]]
