"""LabVIEW measurement files as records: a segment a record, its channels by their names."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from modallab.core.axis_checks import check_time, nearest_whole_rate
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.csv.csv_read import draft_csv, read_csv, record_of
from modallab.formats.csv.csv_table import Table
from modallab.formats.draft import DraftChannel, rig_of, select_channels
from modallab.formats.lvm.lvm_read import LvmChannel, has_header, read_lvm
from modallab.formats.options import ImportOptions
from modallab.formats.starts import Start, cut_to_common_time, one_rate, start_of, start_of_text
from modallab.formats.unit_text import normal_unit, quantity_of, to_seconds, unit_in_name

_SPECTRUM = re.compile(r"\((?:FFT|PSD|Power Spectr|Spectr|Magnitude|Phase)", re.IGNORECASE)
"""What LabVIEW writes behind the name of a channel over frequency, even where X_Dimension says Time."""
_SAME = 1e-4
"""Relative, of steps: columns of x are written with few digits too."""


def campaign_of_lvm(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read the records of a file; one that was written without headers is a table.

    Raises:
        FormatError: cut off or damaged.
        DataError: not the channels of the rig, rates that differ, or records that do not overlap.
    """
    if not has_header(path):
        return read_csv(path, rig, options)
    where, segments, chosen = str(path), read_lvm(path), replace(options, variables=())
    blocks: list[Block] = []
    notes: dict[str, None] = {}
    for k, segment in enumerate(segments, start=1):
        name = path.stem if len(segments) == 1 else f"{path.stem}_{k}"
        place = f"{where}, segment {k}"
        called = [_called(channel, options) for channel in segment]
        table, note = _table(called, rig, options, place)
        block, more = record_of(table, rig, chosen, name, place)
        blocks.append(block)
        notes |= dict.fromkeys([*([note] if note else []), *more])
    provenance = {"notes": "\n".join(f"{path.name}: {note}" for note in notes)} if notes else {}
    return Campaign(rig, tuple(blocks), provenance=provenance, source=where)


def draft_lvm(path: Path, options: ImportOptions) -> Rig:
    """The rig of a file: the channels of its first segment, by their names and units.

    Raises:
        FormatError: cut off or damaged.
        DataError: none of the channels that are to be taken.
    """
    if not has_header(path):
        return draft_csv(path, options)
    called = (_called(c, options) for c in read_lvm(path)[0])
    return rig_of(select_channels((DraftChannel(c.name, quantity_of(c.unit), c.unit) for c in called), options), path)


def _called(channel: LvmChannel, options: ImportOptions) -> LvmChannel:
    """The channel as the user calls it, with the unit that the file says, or that its name ends with."""
    unit = normal_unit(channel.unit) or unit_in_name(channel.name)
    over = "Frequency" if _SPECTRUM.search(channel.name) else channel.dimension
    return replace(channel, name=options.channel_of(channel.name), unit=unit, dimension=over)


def _table(segment: Sequence[LvmChannel], rig: Rig, options: ImportOptions, where: str) -> tuple[Table, str]:
    """The channels of the rig, over the time that all of them cover, and a note."""
    needed = {c.name.lower() for c in rig.channels}
    used = [c for c in segment if c.name.lower() in needed] or list(segment)
    used = [_in_seconds(c, where) for c in used]
    taken = {c.name for c in used}
    rates = {c.name: _rate(c, options, where) for c in used}
    rate = one_rate(rates, where) or 0.0
    rows = [c.samples for c in used]
    samples, note = cut_to_common_time(rows, _starts(used, where), rate, list(rates), where)
    n = samples.shape[1]
    left = [c for c in segment if c.name not in taken]
    values = np.column_stack([np.arange(n) / rate, samples.T, np.full((n, len(left)), np.nan)])
    names = ("time", *(c.name for c in used), *(c.name for c in left))
    units = ("s", *(c.unit for c in used), *("" for _ in left))
    return Table(names, units, values, np.zeros(n), ended=True), note


def _in_seconds(channel: LvmChannel, where: str) -> LvmChannel:
    """The channel with its abscissa in s.

    Raises:
        DataError: it is no time.
    """
    if channel.dimension.lower() not in ("", "time"):
        found = f"channel {channel.name} is over {channel.dimension}, and no record of time"
        raise DataError(found, where=where, remedy="export the time signal, or leave the channel out with --ignore")
    factor = to_seconds(channel.x_unit, f"{where}, x of {channel.name}")
    return replace(
        channel,
        x0=channel.x0 * factor,
        step=channel.step * factor,
        step_error=channel.step_error * factor,
        x=channel.x * factor,
        x_error=channel.x_error * factor,
    )


def _rate(channel: LvmChannel, options: ImportOptions, where: str) -> float:
    step_rate = nearest_whole_rate(1 / channel.step, channel.step_error / channel.step**2) if channel.step > 0 else 0.0
    if channel.x.size > 1 and not (step_rate and 2 * channel.x_error.max() > channel.step / 4):
        rate = check_time(channel.x, f"{where}, x of {channel.name}", resolution_s=channel.x_error)
        if step_rate and abs(1 / rate - channel.step) > max(channel.step_error, _SAME * channel.step):
            found = f"channel {channel.name}: Delta_X says {step_rate:g} Hz, the column of x {rate:g} Hz"
            raise DataError(found, where=where, remedy="export the record again, or correct Delta_X")
        return options.agreed(rate, where)
    if step_rate:
        return options.agreed(step_rate, where)
    if options.rate_hz is None:
        found = f"channel {channel.name} has neither Delta_X nor a column of x"
        raise DataError(found, where=where, remedy="give the rate with --rate")
    return options.rate_hz


def _starts(used: Sequence[LvmChannel], where: str) -> list[Start]:
    offsets = [start_of(float(c.x[0]) if c.x.size else c.x0, timed=c.x.size > 0) for c in used]
    if len({c.start for c in used}) < 2:
        return offsets
    days = [start_of_text(c.start, where) for c in used]
    return [
        Start(o.at_s + d.at_s, o.resolution_s + d.resolution_s, o.timed) for o, d in zip(offsets, days, strict=True)
    ]
