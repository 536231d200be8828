"""Which groups of a TDMS file are records: a file may hold slow channels or a log beside the test."""

from collections.abc import Iterable, Sequence

import numpy as np

from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.csv.csv_heads import is_time_name
from modallab.formats.tdms.tdms_read import TdmsChannel, TdmsGroup
from modallab.formats.unit_text import to_seconds

_SAME_NAMES = "say which is which with --variable CHANNEL=NAME, or choose a group with --group"


def chosen(groups: tuple[TdmsGroup, ...], name: str, where: str) -> tuple[TdmsGroup, ...]:
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


def records_of(groups: tuple[TdmsGroup, ...], rig: Rig, where: str) -> tuple[TdmsGroup, ...]:
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


def fastest(groups: Sequence[TdmsGroup], where: str) -> tuple[TdmsChannel, ...]:
    """The channels of the highest rate, or of most samples where no rate is said, in the first group that has them."""

    def speed(channel: TdmsChannel) -> tuple[float, int]:
        step = step_of(channel, where)
        return 1 / step if step else 0.0, len(channel.samples)

    every = [[c for c in g.channels.values() if not is_time(c)] for g in groups]
    # Spectra beside records are left out; where there is nothing else, the step says what they are.
    records = [[c for c in channels if _over_time(c)] for channels in every]
    signals = records if any(records) else every
    best = max((speed(c) for channels in signals for c in channels), default=(0.0, 0))
    found = [tuple(c for c in channels if speed(c)[0] == best[0]) for channels in signals]
    return max(found, key=lambda channels: max((len(c.samples) for c in channels), default=0))


def is_time(channel: TdmsChannel) -> bool:
    """Whether a channel holds the times of the others."""
    return is_time_name(channel.name)


def step_of(channel: TdmsChannel, where: str) -> float:
    """The time from sample to sample in s; 0 where the file does not say.

    Raises:
        FormatError: it is no number.
        DataError: it is no time.
    """
    step = channel.properties.get("wf_increment", 0.0)
    if not isinstance(step, int | float) or not (np.isfinite(step) and step >= 0):
        found = f"wf_increment of {channel.name} is {step!r}"
        raise FormatError(found, where=where, remedy="export the records again")
    return float(step) * seconds_of_x(channel, where)


def _over_time(channel: TdmsChannel) -> bool:
    try:
        return seconds_of_x(channel, "") > 0
    except DataError:
        return False


def seconds_of_x(channel: TdmsChannel, where: str) -> float:
    """What turns the abscissa of a channel into s.

    Raises:
        DataError: it is no time, as that of a spectrum.
    """
    return to_seconds(str(channel.properties.get("wf_xunit_string", "")), f"{where}, x of {channel.name}")


def listed(channels: Iterable[TdmsChannel]) -> str:
    """Names, with the rate where it is said."""
    steps = [(c.name, c.properties.get("wf_increment")) for c in channels]
    return ", ".join(f"{n} ({1 / s:g} Hz)" if isinstance(s, float) and s > 0 else n for n, s in steps)
