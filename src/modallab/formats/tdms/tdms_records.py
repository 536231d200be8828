"""Groups of a TDMS file as records of a campaign."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.axis_checks import whole_rate
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Channel, Rig
from modallab.formats.block_facts import facts_or_options, read_facts
from modallab.formats.draft import DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.starts import Start, cut_to_common_time
from modallab.formats.tdms.tdms_groups import chosen, fastest, is_time, listed, records_of, seconds_of_x, step_of
from modallab.formats.tdms.tdms_read import TdmsChannel, TdmsGroup, read_tdms_groups
from modallab.formats.unit_text import normal_unit, quantity_of

_UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")


def read_tdms(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read the groups that hold the channels of the rig, each as a record, by their names in any order.

    Channels that stand in a group each, as every module of a chassis has its own, are one record. Other groups and
    channels are left out, and a note says so.

    Raises:
        FormatError: no TDMS file, cut off or damaged.
        DataError: channels of the rig that are missing, of unequal rate, or that were not recorded together.
    """
    where = str(path)
    groups = tuple(_called(group, options) for group in chosen(read_tdms_groups(path), options.group, where))
    records = records_of(groups, rig, where)
    notes = _left_out(groups, records, rig, path.name)
    blocks: list[Block] = []
    for order, group in enumerate(records):
        block, note = _block(group, order, rig, options, f"{where}, group {group.name}")
        blocks.append(block)
        notes += [f"{path.name}, group {group.name}: {note}"] if note else []
    return Campaign(rig, tuple(blocks), provenance={"notes": "\n".join(notes)} if notes else {}, source=where)


def _called(group: TdmsGroup, options: ImportOptions) -> TdmsGroup:
    """The group with its channels called as the user says."""
    channels = [replace(c, name=options.channel_of(c.name)) for c in group.channels.values()]
    return replace(group, channels={channel.name: channel for channel in channels})


def unit_in_properties(channel: TdmsChannel) -> str:
    """The unit that a channel's properties name; "" if they name none."""
    units = (normal_unit(str(channel.properties.get(name, ""))) for name in _UNIT_PROPERTIES)
    return next((unit for unit in units if unit), "")


def _left_out(groups: tuple[TdmsGroup, ...], records: tuple[TdmsGroup, ...], rig: Rig, name: str) -> list[str]:
    wanted = {channel.name for channel in rig.channels}
    kept = {id(channel) for record in records for channel in record.channels.values() if channel.name in wanted}
    notes: list[str] = []
    for group in groups:
        others = [c for c in group.channels.values() if id(c) not in kept and not is_time(c)]
        if others:
            notes.append(f"{name}: left out of group {group.name}: {listed(others)}")
    return notes


def _block(group: TdmsGroup, order: int, rig: Rig, options: ImportOptions, where: str) -> tuple[Block, str]:
    parts = [group.channels[channel.name] for channel in rig.channels]
    rate = _rate(group, parts, options, where)
    samples, note = cut_to_common_time(*_rows(parts, where), rate, [part.name for part in parts], where)
    facts = facts_or_options(read_facts(group.description, where), group.name, rate, options)
    units = [_unit(part, channel, options) for part, channel in zip(parts, rig.channels, strict=True)]
    scale = np.array([part.scale for part in parts])
    block = facts.block(samples, units, rig, order=order, scale=scale)
    return block, note


def _unit(part: TdmsChannel, channel: Channel, options: ImportOptions) -> str:
    return unit_in_properties(part) or options.unit(channel)


def _rows(parts: list[TdmsChannel], where: str) -> tuple[list[NDArray[Any]], list[Start | None]]:
    kind = np.result_type(*(part.samples.dtype for part in parts))
    stamped = any(_stamp(part) for part in parts)
    starts = [_start(part, where) if bool(_stamp(part)) == stamped else None for part in parts]
    return [part.samples.astype(kind, copy=False) for part in parts], starts


def _stamp(part: TdmsChannel) -> Fraction:
    """The time stamp in s since 1904, to 2^-64 s; 0 where there is none, which LabVIEW writes as 1904."""
    stamp = part.properties.get("wf_start_time")
    return getattr(stamp, "seconds", 0) + Fraction(getattr(stamp, "second_fractions", 0), 2**64)


def _start(part: TdmsChannel, where: str) -> Start:
    offset = part.properties.get("wf_start_offset", 0.0)
    if not isinstance(offset, int | float) or not np.isfinite(offset):
        raise FormatError(
            f"wf_start_offset of {part.name} is {offset!r}", where=where, remedy="export the records again"
        )
    return Start(_stamp(part) + Fraction(float(offset) * seconds_of_x(part, where)))


def _rate(group: TdmsGroup, parts: list[TdmsChannel], options: ImportOptions, where: str) -> float:
    steps = {part.name: step_of(part, where) for part in parts}
    if len(set(steps.values())) > 1:
        rates = ", ".join(f"{name} {1 / step:g} Hz" if step else f"{name} no rate" for name, step in steps.items())
        raise DataError(f"the channels differ in rate: {rates}", where=where, remedy="export channels of one rate")
    step = next(iter(steps.values()))
    if step > 0:
        rate = check_rate(whole_rate(1 / step, 1e-12 / step), where)
    elif times := [
        c.samples for c in group.channels.values() if is_time(c) and len(c.samples) == len(parts[0].samples)
    ]:
        rate = check_time(times[0], f"{where}, channel of times")
    elif options.rate_hz is not None:
        return check_rate(options.rate_hz, where)
    else:
        raise DataError("says no wf_increment and holds no times", where=where, remedy="give the rate with --rate")
    return options.agreed(rate, where)


def draft_tdms(path: Path, options: ImportOptions) -> Rig:
    """The rig of a TDMS file: the channels of its fastest group, or of the chosen one, by their names and units.

    Raises:
        FormatError: no TDMS file, cut off or damaged.
        DataError: it holds no samples.
    """
    groups = chosen(read_tdms_groups(path), options.group, str(path))
    groups = tuple(g for g in groups if any(not is_time(c) for c in g.channels.values()))
    if not groups:
        raise DataError("holds nothing but times", where=str(path), remedy="export the records again")
    drafts: list[DraftChannel] = []
    for channel in fastest(groups, str(path)):
        unit = unit_in_properties(channel)
        drafts.append(DraftChannel(channel.name, quantity_of(unit), unit))
    return rig_of(select_channels(drafts, options), path)
