"""Rate and start that a file says of one channel: its own times, or numbers beside its samples.

Either stands in the structure that holds the samples, as force.t0 beside force.data, or goes by the channel's name, as
force_t0 or t0_force.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.errors import DataError
from modallab.formats.starts import Start, start_of
from modallab.formats.time_names import RATES, STARTS, STEPS, TIMES, plain_name

Arrays = Mapping[str, NDArray[Any]]

_DAYS = (6e5, 9e5)
"""Dates as MATLAB counts them, in days since the year 0."""


@dataclass(frozen=True, slots=True)
class ChannelTimes:
    """What a file says of one channel; None where it says nothing."""

    rate_hz: float | None
    start: Start | None


def channel_times(arrays: Arrays, key: str, n: int, where: str) -> ChannelTimes:
    """Rate and start of a channel.

    Args:
        arrays: of the file, by name.
        key: name of the channel's samples.
        n: of its samples.
        where: file, for the message.

    Raises:
        DataError: times that are uneven or not as many as samples, a rate that is none, or two that disagree.
    """
    place = f"{where}, {key}"
    own = _beside(arrays, key, TIMES)
    if own is not None and own.size > 1:
        times = np.ravel(own)
        if times.size != n:
            raise DataError(f"has {times.size} times and {n} samples", where=place, remedy="export both together")
        return ChannelTimes(check_time(times, f"{place}, times"), start_of(float(times[0]), timed=True))
    rate, step, start = (_number(arrays, key, names) for names in (RATES, STEPS, STARTS))
    if step is not None and rate is None:
        rate = 1 / step if step > 0 else 0.0
    if start is not None and _DAYS[0] < start < _DAYS[1]:
        found = f"begins at {start:g}, and whether these are days or seconds is not said"
        raise DataError(found, where=place, remedy="give the start in s from the first sample of all channels")
    return ChannelTimes(None if rate is None else check_rate(rate, place), None if start is None else start_of(start))


def _number(arrays: Arrays, key: str, names: tuple[str, ...]) -> float | None:
    found = _beside(arrays, key, names)
    return None if found is None or found.size != 1 or found.dtype.kind not in "fiu" else float(np.ravel(found)[0])


def _beside(arrays: Arrays, key: str, names: tuple[str, ...]) -> NDArray[Any] | None:
    """The one array of such a name: an attribute of `key`, in its structure or the one around, or called after it."""
    parent, _, last = key.lower().rpartition(".")
    lowered = {name.lower(): name for name in arrays}
    affixed = {low: {low.removeprefix(f"{last}_"), low.removesuffix(f"_{last}")} - {low} for low in lowered}
    inside = [lowered[low] for low, parts in affixed.items() if any(plain_name(part) in names for part in parts)]
    for around in (key.lower(), parent, parent.rpartition(".")[0]):
        if around and not inside:
            own = {name: low.rpartition(".")[2] for low, name in lowered.items() if low.startswith(f"{around}.")}
            inside = [name for name, low in own.items() if plain_name(low) in names]
    return arrays[inside[0]] if len(inside) == 1 else None
