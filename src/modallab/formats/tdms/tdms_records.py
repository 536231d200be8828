"""Groups of a TDMS file as records of a campaign: a file may hold slow channels or a log beside the test."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.axis_checks import nearest_whole_rate
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.block_facts import facts_or_options, read_facts
from modallab.formats.csv.csv_heads import is_time_name
from modallab.formats.draft import DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.starts import Start, cut_to_common_time, one_rate, rate_note
from modallab.formats.tdms.tdms_read import TdmsChannel, TdmsGroup, read_tdms_groups
from modallab.formats.unit_text import quantity_of, to_seconds

_SAME_NAMES = "say which is which with --variable CHANNEL=NAME, or choose a group with --group"


def read_tdms(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read the groups that hold the channels of the rig, each as a record, by their names in any order.

    Channels that stand in a group each, as every module of a chassis has its own, are one record. Other groups and
    channels are left out, and a note says so.

    Raises:
        FormatError: no TDMS file, cut off or damaged.
        DataError: channels of the rig that are missing, of unequal rate, or that were not recorded together.
    """
    where = str(path)
    groups = tuple(_called(group, options) for group in _chosen(read_tdms_groups(path), options.group, where))
    records = _records_of(groups, rig, where)
    notes = _left_out(groups, records, rig, path.name)
    blocks: list[Block] = []
    for order, group in enumerate(records):
        block, note = _block(group, order, rig, options, f"{where}, group {group.name}")
        blocks.append(block)
        notes += [f"{path.name}, group {group.name}: {note}"] if note else []
    return Campaign(rig, tuple(blocks), provenance={"notes": "\n".join(notes)} if notes else {}, source=where)


def _called(group: TdmsGroup, options: ImportOptions) -> TdmsGroup:
    """The group with its channels called as the user says, or without their units where that leaves them apart."""
    called = {c.name: options.channel_of(c.name) for c in group.channels.values()}
    apart = Counter(called.values())
    channels = [replace(c, name=new if apart[new := called[c.name]] == 1 else c.name) for c in group.channels.values()]
    return replace(group, channels={channel.name: channel for channel in channels})


def _left_out(groups: tuple[TdmsGroup, ...], records: tuple[TdmsGroup, ...], rig: Rig, name: str) -> list[str]:
    wanted = {channel.name for channel in rig.channels}
    kept = {id(channel) for record in records for channel in record.channels.values() if channel.name in wanted}
    notes: list[str] = []
    for group in groups:
        others = [c for c in group.channels.values() if id(c) not in kept and not _is_time(c)]
        if others:
            notes.append(f"{name}: left out of group {group.name}: {_listed(others)}")
    return notes


def _block(group: TdmsGroup, order: int, rig: Rig, options: ImportOptions, where: str) -> tuple[Block, str]:
    parts = [group.channels[channel.name] for channel in rig.channels]
    rate = _rate(group, parts, options, where)
    samples, note = cut_to_common_time(*_rows(parts, where), rate, [part.name for part in parts], where)
    facts = facts_or_options(read_facts(group.description, where), group.name, rate, options)
    scale = np.array([part.scale for part in parts])
    block = facts.block(samples, [part.unit for part in parts], rig, order=order, scale=scale)
    return block, "; ".join(filter(None, (rate_note(_rates(parts, where)), note)))


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
    return Start(_stamp(part) + Fraction(float(offset) * _seconds_of_x(part, where)))


def _rates(parts: Sequence[TdmsChannel], where: str) -> dict[str, float | None]:
    steps = {part.name: _step_of(part, where) for part in parts}
    return {name: 1 / step if step else None for name, step in steps.items()}


def _rate(group: TdmsGroup, parts: list[TdmsChannel], options: ImportOptions, where: str) -> float:
    said = one_rate(_rates(parts, where), where)
    if said:
        rate = check_rate(nearest_whole_rate(said, 1e-12 * said), where)
    elif times := [c for c in group.channels.values() if _is_time(c) and len(c.samples) == len(parts[0].samples)]:
        unit, place = times[0].unit, f"{where}, channel of times"
        return options.of_times(check_time(times[0].samples * to_seconds(unit, place), place), unit, place)
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
    groups = _chosen(read_tdms_groups(path), options.group, str(path))
    groups = tuple(g for g in groups if any(not _is_time(c) for c in g.channels.values()))
    if not groups:
        raise DataError("holds nothing but times", where=str(path), remedy="export the records again")
    fastest = _fastest(groups, str(path))
    drafts = [DraftChannel(options.channel_of(c.name), quantity_of(c.unit), c.unit) for c in fastest]
    return rig_of(select_channels(drafts, options), path)


def _chosen(groups: tuple[TdmsGroup, ...], name: str, where: str) -> tuple[TdmsGroup, ...]:
    """The groups, or the one of this name if it is not empty.

    Raises:
        DataError: no samples, or no group of this name.
    """
    if not groups:
        raise DataError("holds no samples", where=where, remedy="export the records again")
    named = tuple(group for group in groups if name in ("", group.name))
    if not named:
        there = ", ".join(group.name for group in groups)
        raise DataError(f"has no group {name!r}", where=where, remedy=f"name one of {there}")
    return named


def _records_of(groups: tuple[TdmsGroup, ...], rig: Rig, where: str) -> tuple[TdmsGroup, ...]:
    """Each group that holds all channels of the rig; if none does, one record of all groups whose names differ.

    Raises:
        DataError: a channel of the rig is missing, or in several groups none of which is whole.
    """
    wanted = [channel.name for channel in rig.channels]
    whole = tuple(group for group in groups if set(wanted) <= set(group.channels))
    if whole:
        return whole
    at = {name: [group for group in groups if name in group.channels] for name in wanted}
    missing = [name for name, found in at.items() if not found]
    several = [name for name, found in at.items() if len(found) > 1]
    if missing or several:
        there = "; ".join(
            f"group {g.name}: {', '.join([*g.channels, *(f'{o} (no numbers)' for o in g.others)])}" for g in groups
        )
        found = f"no channel {', '.join(missing)}" if missing else f"{', '.join(several)} in several groups, none whole"
        raise DataError(f"{found}; there are {there}", where=where, remedy=_SAME_NAMES)
    parts = dict.fromkeys(found[0].name for found in at.values())
    channels = {c.name: c for group in groups if group.name in parts for c in group.channels.values()}
    return (TdmsGroup(" and ".join(parts), "", channels),)


def _fastest(groups: Sequence[TdmsGroup], where: str) -> tuple[TdmsChannel, ...]:
    """The channels of the highest rate, or of most samples where no rate is said, in the first group that has them."""

    def speed(channel: TdmsChannel) -> tuple[float, int]:
        step = _step_of(channel, where)
        return 1 / step if step else 0.0, len(channel.samples)

    every = [[c for c in g.channels.values() if not _is_time(c)] for g in groups]
    # Spectra beside records are left out; where there is nothing else, the step says what they are.
    records = [[c for c in channels if _over_time(c)] for channels in every]
    signals = records if any(records) else every
    best = max((speed(c) for channels in signals for c in channels), default=(0.0, 0))
    found = [tuple(c for c in channels if speed(c)[0] == best[0]) for channels in signals]
    return max(found, key=lambda channels: max((len(c.samples) for c in channels), default=0))


def _is_time(channel: TdmsChannel) -> bool:
    """Whether a channel holds the times of the others."""
    return is_time_name(channel.name)


def _step_of(channel: TdmsChannel, where: str) -> float:
    """The time from sample to sample in s; 0 where the file does not say.

    Raises:
        FormatError: it is no number.
        DataError: it is no time.
    """
    step = channel.properties.get("wf_increment", 0.0)
    if not isinstance(step, int | float) or not (np.isfinite(step) and step >= 0):
        found = f"wf_increment of {channel.name} is {step!r}"
        raise FormatError(found, where=where, remedy="export the records again")
    return float(step) * _seconds_of_x(channel, where)


def _over_time(channel: TdmsChannel) -> bool:
    try:
        return _seconds_of_x(channel, "") > 0
    except DataError:
        return False


def _seconds_of_x(channel: TdmsChannel, where: str) -> float:
    """What turns the abscissa of a channel into s.

    Raises:
        DataError: it is no time, as that of a spectrum.
    """
    return to_seconds(str(channel.properties.get("wf_xunit_string", "")), f"{where}, x of {channel.name}")


def _listed(channels: Iterable[TdmsChannel]) -> str:
    """Names, with the rate where it is said."""
    steps = [(c.name, c.properties.get("wf_increment")) for c in channels]
    return ", ".join(f"{n} ({1 / s:g} Hz)" if isinstance(s, float) and s > 0 else n for n, s in steps)
