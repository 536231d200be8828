"""Recordings of others, of any known kind, as one campaign."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from modallab.core.array_checks import identical_channels
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, ErrorCollection
from modallab.core.frf import Frf
from modallab.core.progress import count_progress
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.formats.check_campaign import check_recordings, check_structure, check_values
from modallab.formats.draft import DraftChannel, select_channels, with_named_points
from modallab.formats.format import sniff
from modallab.formats.joined_frfs import joined_frfs
from modallab.formats.options import COUNTED_HZ, ImportOptions, options_of
from modallab.signals.faults.all_faults import find_faults

_VOLTS = ("V", "mV")


def import_recordings(paths: Sequence[Path], rig: Rig | None, said: Mapping[str, Any]) -> Campaign:
    """Read recordings as `import_sources` does, with what the user says; without a rig, on one drafted from the files.

    Where no force is measured, and the user says no test, records are taken as of the random test.

    Args:
        paths: files of any known kind, or folders with a campaign.
        rig: the rig they were made on; only the channels that the user takes are.
        said: by field of `ASKED`.

    Raises:
        ModallabError: an option that there is not, or one error with everything that is wrong in any of the files.
    """
    each = options_of(said, len(paths))
    known = _with_drive_points(_drafted(paths, each), each) if rig is None else _taken_of(rig, each[0])
    if known.force is None and said.get("test") is None:
        each = tuple(replace(one, test="random") for one in each)
    return import_sources(paths, known, each)


def import_sources(
    paths: Sequence[Path], rig: Rig, options: ImportOptions | Sequence[ImportOptions] | None = None
) -> Campaign:
    """Read recordings, in the order given, as one campaign on `rig`.

    Channels that agree to the last bit are not rejected, but noted in the provenance under "notes".

    Args:
        paths: files of any known kind, or folders with a campaign.
        rig: the rig they were made on.
        options: what the files do not say themselves; of each, or one for all.

    Raises:
        ModallabError: one error with everything that is wrong in any of the files.
    """
    one = options or ImportOptions()
    each = (one,) * len(paths) if isinstance(one, ImportOptions) else one
    for own in each:
        own.check(rig)
    errors, parts, held = ErrorCollection(), list[Campaign](), set[str]()
    for path, own in zip(count_progress(map(Path, paths), len(paths), "files"), each, strict=True):
        with errors:
            read = _read(path, rig, own)
            held |= {name for frf in read.frfs for name in frf.outputs} if sniff(path).name != "hdf5" else set()
            parts.append(_driven_at(_windowed(_checked(_living(read)), own), own))
    errors.raise_collected()
    if held:
        _require_outputs(held, [c.name for c in rig.responses if each[0].takes(c.name)], ", ".join(map(str, paths)))
    blocks = _in_order([block for part in parts for block in part.blocks])
    frfs = joined_frfs([frf for part in parts for frf in part.frfs])
    if not blocks and not frfs:
        raise DataError("no recordings were given", remedy="name at least one file")
    provenance = {key: value for part in parts for key, value in part.provenance.items()} | _said_of(parts, each)
    whole = Campaign(rig, blocks, frfs, provenance, ", ".join(part.source for part in parts))
    check_recordings(whole)
    return whole


def _require_outputs(held: set[str], responses: Sequence[str], where: str) -> None:
    """FRFs of all responses."""
    missing = [name for name in responses if name not in held]
    if missing:
        raise DataError(
            f"no FRF of channel {', '.join(missing)}",
            where=where,
            remedy="give the files of all channels together, or leave these channels out with --ignore",
        )


def _said_of(parts: Sequence[Campaign], each: Sequence[ImportOptions]) -> dict[str, str]:
    """Sources, notes and the set-up of all files together."""
    notes = [note for part in parts for note in _notes(part)]
    said = {"sources": "\n".join(Path(part.source).name for part in parts)}
    said |= {"notes": "\n".join(notes)} if notes else {}
    return said | ({"setup": each[0].set_up} if each[0].set_up else {})


def draft_rig(path: Path, options: ImportOptions | None = None) -> Rig:
    """The rig that a recording was made on, as far as its file says; for the user to complete.

    Args:
        path: of the recording.
        options: what the file does not say itself.

    Raises:
        DataError: files of this format say too little of their channels.
        ModallabError: the file cannot be read.
    """
    found = sniff(path)
    if found.draft is None:
        raise DataError(
            f"says nothing of its channels, as no file of this format ({found.name}) does",
            where=str(path),
            remedy="write a rig file and give it with --rig; docs/how-to/write-a-rig-file.md says how",
        )
    return found.draft(path, options or ImportOptions())


def _drafted(paths: Sequence[Path], each: Sequence[ImportOptions]) -> Rig:
    """The rig of the first file, with the responses and points of the others if each file has its own."""
    first, *others = [draft_rig(path, own) for path, own in zip(paths, each, strict=True)]
    responses = [channel for rig in (first, *others) for channel in rig.responses]
    if not others or len({channel.name for channel in responses}) < len(responses):
        return first
    points = {point.id: point for rig in (first, *others) for point in rig.points}
    channels = [channel for channel in first.channels if channel not in first.responses] + responses
    numbered = tuple(channel.model_copy(update={"index": k}) for k, channel in enumerate(channels))
    return first.model_copy(update={"points": tuple(points.values()), "channels": numbered})


def _with_drive_points(rig: Rig, each: Sequence[ImportOptions]) -> Rig:
    """The drafted rig with the points that the user says were driven."""
    driven = {one.drive_point for one in each if one.drive_point is not None and one.drive_point > 0}
    return rig.model_copy(update={"points": with_named_points(rig.points, driven)})


def _taken_of(rig: Rig, options: ImportOptions) -> Rig:
    """The rig with the channels that the user takes.

    Raises:
        DataError: a channel that is to be taken is not on the rig, or none is left.
    """
    names = [one.name for one in select_channels((DraftChannel(c.name) for c in rig.channels), options)]
    kept = [c for c in rig.channels if c.name in names]
    return rig.model_copy(update={"channels": tuple(c.model_copy(update={"index": k}) for k, c in enumerate(kept))})


def _driven_at(campaign: Campaign, options: ImportOptions) -> Campaign:
    """The campaign with the level that the user says, where the records say none."""
    if options.level is None:
        return campaign
    blocks = tuple(replace(b, level=options.level) if b.level is None else b for b in campaign.blocks)
    return replace(campaign, blocks=blocks)


def _windowed(campaign: Campaign, options: ImportOptions) -> Campaign:
    """The campaign with the exponential window that its FRFs were made with."""
    if options.window_s is None:
        return campaign
    if not campaign.frfs:
        raise DataError(
            "an exponential window is named, and there are no FRFs",
            where=campaign.source,
            remedy="leave it out: of time records everything is identified without a window",
        )
    frfs = tuple(replace(frf, damping_shift=frf.damping_shift or 1 / options.window_s) for frf in campaign.frfs)
    return replace(campaign, frfs=frfs)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    found = sniff(path)
    assert found.read is not None
    campaign = _with_units(found.read(path, rig, options), options)
    if rig.shakers and not found.several_forces and any(block.test in BROADBAND for block in campaign.blocks):
        raise DataError(
            f"the rig has {1 + len(rig.shakers)} shakers, and {found.name} does not say which of them drove",
            where=str(path),
            remedy="import the campaign file (hdf5), or give a rig file with the shaker that drove alone",
        )
    return campaign


def _with_units(campaign: Campaign, options: ImportOptions) -> Campaign:
    """The campaign with the units of the rig, or V, where its file writes none, and a note that says so."""
    rows = [list(zip(campaign.rig.channels, block.units, strict=True)) for block in campaign.blocks]
    bare = {c.name: options.unit(c) for row in rows for c, unit in row if not unit}
    if not bare:
        return campaign
    units = [tuple(unit or bare[c.name] for c, unit in row) for row in rows]
    blocks = tuple(replace(block, units=own) for block, own in zip(campaign.blocks, units, strict=True))
    taken = ", ".join(dict.fromkeys(bare.values()))
    note = f"{Path(campaign.source).name}: no unit is written of {', '.join(bare)}: taken in {taken}"
    notes = filter(None, (campaign.provenance.get("notes"), "" if options.volts else note))
    return replace(campaign, blocks=blocks, provenance=campaign.provenance | {"notes": "\n".join(notes)})


def _living(campaign: Campaign) -> Campaign:
    """The campaign without the outputs whose FRFs are zero at every line, where others are not."""
    frfs, notes = list[Frf](), [campaign.provenance["notes"]] if "notes" in campaign.provenance else []
    for frf in campaign.frfs:
        alive = [k for k, row in enumerate(frf.values) if row.any()]
        frfs.append(frf.of_rows(alive) if 0 < len(alive) < len(frf.outputs) else frf)
        dead = [name for k, name in enumerate(frf.outputs) if k not in alive]
        notes += [f"channel {name}: its FRF is zero at every line, and left out" for name in dead]
    said = {"notes": "\n".join(notes)} if notes else {}
    return replace(campaign, frfs=tuple(frfs), provenance={**campaign.provenance, **said})


def _checked(campaign: Campaign) -> Campaign:
    check_structure(campaign)
    check_values(campaign)
    _require_sensitivities(campaign)
    return campaign


def _require_sensitivities(campaign: Campaign) -> None:
    bare = {c.name: c for c in campaign.rig.channels if c.sensitivity_v_per_unit is None}
    for block in campaign.blocks:
        for name, unit in zip(block.channels, block.units, strict=True):
            if name in bare and unit in _VOLTS and bare[name].unit not in _VOLTS:
                raise DataError(
                    f"channel {name} is in {unit}, and the rig has no sensitivity of it",
                    where=campaign.source,
                    remedy=f"write its sensitivity_v_per_unit, in V per {bare[name].unit}, into the rig file",
                )


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
        if block.rate_hz == COUNTED_HZ:
            notes.append(f"{block.name}: taken as of 1 Hz; if its file only counts samples, give the rate with --rate")
        for first, second in identical_channels(block.samples, block.channels):
            notes.append(f"{block.name}: channels {first} and {second} agree in every bit; is one a copy?")
        notes += [f"{block.name}: {fault}" for fault in find_faults(block, part.rig)]
    return notes
