"""Recordings of others, of any known kind, as one campaign."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from modallab.core.array_checks import identical_channels
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.progress import counted
from modallab.core.rig import Rig
from modallab.formats.check_campaign import check_recordings, check_structure
from modallab.formats.error_list import Collected
from modallab.formats.options import ImportOptions
from modallab.formats.sniff import sniff


def import_sources(paths: Sequence[Path], rig: Rig, options: ImportOptions | None = None) -> Campaign:
    """Read recordings, in the order given, as one campaign on `rig`.

    Channels that agree to the last bit are not rejected, but noted in the provenance under "notes".

    Args:
        paths: files of any known kind, or folders with a campaign.
        rig: the rig they were made on.
        options: what the files do not say themselves.

    Raises:
        ModallabError: one error with everything that is wrong in any of the files.
    """
    options = options or ImportOptions()
    options.check(rig)
    errors, parts = Collected(), list[Campaign]()
    for path in counted(map(Path, paths), len(paths), "files"):
        with errors:
            parts.append(_checked(_read(path, rig, options)))
    errors.done()
    blocks = _in_order([block for part in parts for block in part.blocks])
    frfs = [frf for part in parts for frf in part.frfs]
    if not blocks and not frfs:
        raise DataError("no recordings were given", remedy="name at least one file")
    notes = [note for part in parts for note in _notes(part)]
    provenance = {key: value for part in parts for key, value in part.provenance.items()}
    provenance |= {"sources": "\n".join(Path(part.source).name for part in parts)}
    provenance |= {"notes": "\n".join(notes)} if notes else {}
    return Campaign(rig, blocks, tuple(frfs), provenance, ", ".join(part.source for part in parts))


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    read = sniff(path).read
    assert read is not None
    return read(path, rig, options)


def _checked(campaign: Campaign) -> Campaign:
    check_structure(campaign)
    check_recordings(campaign)
    return campaign


def _in_order(blocks: Sequence[Block]) -> tuple[Block, ...]:
    """The blocks numbered in the order given, each with a name of its own."""
    taken: set[str] = set()
    named: list[Block] = []
    for order, block in enumerate(blocks):
        name, count = block.name, 1
        while name in taken:
            count += 1
            name = f"{block.name}_{count}"
        taken.add(name)
        named.append(replace(block, name=name, order=order))
    return tuple(named)


def _notes(part: Campaign) -> list[str]:
    notes = [part.provenance["notes"]] if "notes" in part.provenance else []
    for block in part.blocks:
        for first, second in identical_channels(block.samples, block.channels):
            notes.append(f"{block.name}: channels {first} and {second} agree in every bit; is one a copy?")
    return notes
