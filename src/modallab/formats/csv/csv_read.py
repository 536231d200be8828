"""CSV files: a column of times and one column per channel, by the names of the rig; or FRFs."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from modallab.core.array_checks import check_rate, check_time
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Direction, Rig
from modallab.core.units import Quantity
from modallab.formats.block_facts import facts_or_options, read_facts
from modallab.formats.csv.csv_frf import frf_of, is_frf
from modallab.formats.csv.csv_frf_table import columns_of, frf_of_table, holds_frfs
from modallab.formats.csv.csv_heads import BY_OPTION, is_frequency, time_column, unit_of_time
from modallab.formats.csv.csv_join import records_of, side_by_side
from modallab.formats.csv.csv_table import Table, read_tables
from modallab.formats.csv.frf_heading import FrfHeading, pair_of
from modallab.formats.draft import MEASURED, DraftChannel, rig_of, select_channels
from modallab.formats.frf_file import OF_THE_RIG
from modallab.formats.options import ImportOptions, units_of
from modallab.formats.unit_text import frf_unit, quantity_of, to_seconds

_DIRECTIONS: dict[str, Direction] = {"+x": "+x", "-x": "-x", "+y": "+y", "-y": "-y", "+z": "+z", "-z": "-z"}


def read_csv(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read one block for each table, or one matrix of FRFs.

    Columns are known by the names in the header, whatever their order, or by those that the options name; others are
    left out with a note. Units stand in brackets after the name or in a line of their own, else numbers are in each
    channel's own unit (or volts, if the options say so). Without a header, columns are times and then the channels in
    rig order.

    Raises:
        FormatError: no table, or cut off.
        DataError: uneven times, wrong units, or not the channels of the rig.
    """
    where = str(path)
    tables = read_tables(path, options.columns)
    table = tables[-1]
    if is_frf(table) or holds_frfs(table):
        table = side_by_side(tables, where)
        frf = frf_of(table, rig, where) if is_frf(table) else frf_of_table(table, rig, options, where)
        bare = not is_frf(table) and any(c.is_bare for c in columns_of(table, rig, where))
        return Campaign(rig, (), (frf,), _provenance(path, [table.note, OF_THE_RIG * bare]), where)
    tables = records_of(tables, where)
    names = [path.stem] if len(tables) == 1 else [f"{path.stem}_{k}" for k in range(1, len(tables) + 1)]
    found = [record_of(one, rig, options, name, where) for one, name in zip(tables, names, strict=True)]
    blocks = tuple(replace(block, order=order) for order, (block, _) in enumerate(found))
    notes = tuple(dict.fromkeys(note for _, remarks in found for note in remarks))
    notes = (*notes, table.note)
    if not table.ended:
        notes = (*notes, "the last line has no end; if the file was cut off there, its last number is wrong")
    return Campaign(rig, blocks, provenance=_provenance(path, notes), source=where)


def _provenance(path: Path, notes: Iterable[str]) -> dict[str, str]:
    said = [f"{path.name}: {note}" for note in notes if note]
    return {"notes": "\n".join(said)} if said else {}


def record_of(table: Table, rig: Rig, options: ImportOptions, name: str, where: str) -> tuple[Block, tuple[str, ...]]:
    """The record that a table holds, and notes on it.

    Args:
        table: with a column of times, or without one where the options give the rate.
        rig: its channels are looked for by name.
        options: what the table does not say.
        name: of the record, if the table says none.
        where: file and record, for messages.

    Raises:
        FormatError, DataError: as `read_csv`.
    """
    names = table.names or _names_by_place(table, rig, options, where)
    time = time_column(names, table.units)
    places, left = _places(names, time, rig, options, where)
    order = [places[channel.name] for channel in rig.channels]
    table.require(order if time is None else [time, *order])
    rate = _rate(table, names, time, options, where)
    units = [table.units[place] if table.units else "" for place in order]
    facts = facts_or_options(read_facts(table.remark, where), name, rate, options)
    samples = np.ascontiguousarray(table.values[:, order].T)
    block = facts.block(samples, units_of(rig.channels, units, table.elsewhere, where), rig)
    notes = [f"columns {', '.join(left)} are no channels of the rig, and left out"] if left else []
    if time is None and options.rate_hz is None:
        notes.append(f"the rate of {rate:g} Hz is that of the lines above the table")
    return block, tuple(notes)


def _names_by_place(table: Table, rig: Rig, options: ImportOptions, where: str) -> tuple[str, ...]:
    channels = tuple(channel.name for channel in rig.channels)
    columns = table.values.shape[1]
    if columns == len(channels) + 1:
        return ("time", *channels)
    if columns == len(channels) and (options.rate_hz or table.facts.rate_hz) is not None:
        return channels
    raise DataError(
        f"has {columns} columns and no header; the rig has {len(channels)} channels ({', '.join(channels)})",
        where=where,
        remedy=BY_OPTION,
    )


def _places(
    names: tuple[str, ...], time: int | None, rig: Rig, options: ImportOptions, where: str
) -> tuple[dict[str, int], tuple[str, ...]]:
    """The column of each channel, and the names of other columns. Rejects channels that are missing or there twice."""
    lowered = [name.lower() for name in names]
    if time is None and is_frequency(names[0], ""):
        raise DataError(
            f"its first column is {names[0]!r}, and the others hold neither complex numbers nor Re and Im, nor a phase",
            where=where,
            remedy="name two columns for each FRF, as Re a1 and Im a1; spectra without a phase hold no modes",
        )
    called = dict(options.variables)
    requested = {called.get(channel.name, channel.name).lower(): channel.name for channel in rig.channels}
    missing = [name for low, name in requested.items() if low not in lowered]
    channels = [name for place, name in enumerate(names) if place != time]
    other = tuple(name for name in channels if name and name.lower() not in requested)
    twice = sorted({name for name in names if lowered.count(name.lower()) > 1 and name.lower() in requested})
    parts = [f"no column for channel {', '.join(missing)}"] if missing else []
    parts += [f"column {', '.join(map(repr, other))} is no channel of the rig"] if missing and other else []
    parts += [f"column {', '.join(twice)} is there twice"] if twice else []
    if parts:
        example = f"{missing[0]}={other[0]!r}" if missing and other else "force=F"
        raise DataError(
            "; ".join(parts),
            where=where,
            remedy=f"say which column is which with --variable {example}; or name the columns time, "
            f"{', '.join(requested.values())}; or correct the rig",
        )
    return {name: lowered.index(low) for low, name in requested.items()}, other


def _rate(table: Table, names: tuple[str, ...], time: int | None, options: ImportOptions, where: str) -> float:
    if time is None:
        said = table.facts.rate_hz if options.rate_hz is None else options.rate_hz
        if said is None:
            raise DataError(
                f"has no column of times among {', '.join(names)}, and no rate is given",
                where=where,
                remedy="add a column named time, or give the rate with --rate",
            )
        return check_rate(said, where)
    unit = unit_of_time(names[time], table.units[time] if table.units else "")
    factor = to_seconds(unit, f"{where}, column {names[time]}")
    resolution = table.resolution * factor if time == 0 else np.zeros(1)
    rate = check_time(table.values[:, time] * factor, f"{where}, column {names[time]}", resolution_s=resolution)
    return options.of_times(rate, unit, f"{where}, column {names[time]}", table.facts.rate_hz)


def draft_csv(path: Path, options: ImportOptions) -> Rig:
    """The rig of a table: a channel for each column but the times, by its name and unit; for each response of an FRF.

    Raises:
        FormatError: no table, or cut off.
        DataError: the table has no header.
    """
    tables = read_tables(path, options.columns)
    table = side_by_side(tables, str(path)) if holds_frfs(tables[-1]) else records_of(tables, str(path))[0]
    if not table.names:
        raise DataError(
            "has no header, so that its columns have no names",
            where=str(path),
            remedy=f"{BY_OPTION}; or give a rig file with --rig",
        )
    if holds_frfs(table):
        return _of_frfs(table, path, options)
    units = table.units or ("",) * len(table.names)
    time = time_column(table.names, table.units)
    columns = [(n, u) for k, (n, u) in enumerate(zip(table.names, units, strict=True)) if k != time and n]
    drafts = select_channels((DraftChannel(n, quantity_of(unit), unit) for n, unit in columns), options)
    numbers = [one for one in drafts if table.names.index(one.name) not in table.no_numbers]
    if not numbers:
        table.require([table.names.index(one.name) for one in drafts])
    return rig_of(numbers, path)


def _of_frfs(table: Table, path: Path, options: ImportOptions) -> Rig:
    headings = [c.heading for c in columns_of(table, None, str(path)) if c.heading.part not in ("phase", "coherence")]
    pairs = [pair_of(h.of) for h in headings]
    drives = {p.input for p in pairs if p.input is not None}
    responses: dict[str, DraftChannel] = {}
    for heading, pair in zip(headings, pairs, strict=True):
        name = pair.name or "response" if pair.point is None else f"p{pair.point}{pair.axis}"
        if name not in responses or responses[name].quantity is None:
            responses[name] = DraftChannel(name, _quantity(heading), "", pair.point, _DIRECTIONS.get(pair.axis))
    force = DraftChannel("force", "force", "N", min(drives) if len(drives) == 1 else None)
    return rig_of([force, *select_channels(responses.values(), options)], path, driven=drives)


def _quantity(heading: FrfHeading) -> Quantity | None:
    pair = frf_unit(heading.unit, "")
    return None if pair is None else MEASURED[pair[0]]
