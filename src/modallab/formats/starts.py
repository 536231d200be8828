"""Channels of one record that begin at different times, brought onto the stretch of time that all of them cover."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.signals.alignment import HALF, align_channels

_WHOLE = 1e-3
"""Share of a sample within which channels stand whole samples apart: 0.04 degrees at a tenth of the rate."""
_SAME_RATE = 1e-9
"""Relative, of rates that are one."""
_COARSE = 0.25
"""Share of a sample to which starts must be known to say which sample belongs to which."""
_APART = "export channels that were recorded together, over the same time"
_ISO = re.compile(r"(\d{4}-?\d\d-?\d\d[T ]\d\d:?\d\d(?::?\d\d)?)(?:[.,](\d+))?(Z|[+-]\d\d:?\d\d)?")


@dataclass(frozen=True, slots=True)
class Start:
    """When the first sample of a channel was taken.

    Attributes:
        at_s: s since any moment that the channels of a record share.
        resolution_s: half of the last digit with which the file writes it; 0 if that is exact.
        timed: whether the file gives the time of each sample.
    """

    at_s: Fraction
    resolution_s: float = 0.0
    timed: bool = False


def start_of(seconds: float, resolution_s: float = 0.0, *, timed: bool = False) -> Start:
    """A start that a file gives as a number of s.

    Raises:
        DataError: it is no number.
    """
    if not np.isfinite(seconds):
        raise DataError(f"the record begins at {seconds} s", remedy="export the records again")
    return Start(Fraction(float(seconds)), resolution_s, timed)


def start_of_text(text: str, where: str) -> Start:
    """A start that a file gives as date and time of ISO 8601.

    Raises:
        DataError: it is none.
    """
    parts = _ISO.fullmatch(text.strip())
    try:
        moment = datetime.fromisoformat(f"{parts[1]}{parts[3] or ''}" if parts else text.strip())
    except ValueError as error:
        found = f"the start {text!r} is no date and time"
        raise DataError(found, where=where, remedy="write it as 2026-11-26T10:00:00.000500") from error
    digits = (parts[2] if parts else None) or ""
    # A moment without a zone is taken in the zone of the others, which makes no difference where all have none.
    since = moment.replace(tzinfo=UTC) - datetime(1970, 1, 1, tzinfo=UTC) - (moment.utcoffset() or timedelta())
    whole = since.total_seconds()
    return Start(Fraction(int(whole)) + Fraction(int(digits or 0), 10 ** len(digits)), 0.5 * 10.0 ** -len(digits))


def one_rate(rates_hz: Mapping[str, float | None], where: str) -> float | None:
    """The rate of one record, of what its channels say by name; None where none says it.

    Raises:
        DataError: they differ.
    """
    said = [rate for rate in rates_hz.values() if rate]
    if any(abs(rate - said[0]) > _SAME_RATE * said[0] for rate in said):
        text = ", ".join(f"{name} {f'{rate:g} Hz' if rate else 'unknown'}" for name, rate in rates_hz.items())
        raise DataError(
            f"the channels differ in rate: {text}",
            where=where,
            remedy="export channels of one rate, or leave some out with --ignore",
        )
    return said[0] if said else None


def rate_note(rates_hz: Mapping[str, float | None]) -> str:
    """Which channels say no rate and are taken at that of the others; "" for none."""
    bare = [name for name, rate in rates_hz.items() if not rate]
    return (
        f"no rate is written of {', '.join(bare)}: taken at that of the others" if 0 < len(bare) < len(rates_hz) else ""
    )


def cut_to_common_time(
    rows: Sequence[NDArray[Any]], starts: Sequence[Start | None], rate_hz: float, names: Sequence[str], where: str
) -> tuple[NDArray[Any], str]:
    """The rows (channels, n) over the time that all of them cover, and a note; "" where all begin together.

    Channels that stand a whole number of samples apart keep their samples. Of others the one that begins last keeps
    them, and the rest is moved by a part of a sample, as a delay in a rig file is taken off.

    Args:
        rows: of each channel (n,), of any length.
        starts: of each channel; None where the file does not say.
        rate_hz: of all.
        names: of the channels.
        where: file and record, for the message.

    Raises:
        DataError: records of the same start but of unequal length, that do not overlap, or whose starts are unknown or
            written too coarsely.
    """
    stamps = [start for start in starts if start is not None]
    if len({start.at_s for start in stamps}) < 2:
        if len({len(row) for row in rows}) > 1 and len(stamps) == len(rows) and all(start.timed for start in stamps):
            n = min(map(len, rows))
            return np.stack([row[:n] for row in rows]), f"channels differ in length; cut to the first {n} samples"
        return _same_length(rows, stamps[0] if stamps else None, rate_hz, names, where), ""
    if len(stamps) < len(starts):
        without = ", ".join(n for n, s in zip(names, starts, strict=True) if s is None)
        raise DataError(f"other channels begin at different times, and {without} says none", where=where, remedy=_APART)
    ahead = _samples_ahead(stamps, rate_hz, names, where)
    parts = [_from_sample(row, lead, rate_hz) for row, lead in zip(rows, ahead, strict=True)]
    n = min(len(part) for part in parts)
    if n < 2:
        raise DataError(_apart(rows, stamps, rate_hz, names), where=where, remedy=_APART)
    late = ", ".join(
        f"{name} {float(s.at_s - min(stamps, key=_at).at_s):.6g} s" for name, s in zip(names, stamps, strict=True)
    )
    note = f"channels begin at different times ({late}); cut to the {n / rate_hz:g} s that all of them cover"
    return np.stack([part[:n] for part in parts]), note


def _at(start: Start) -> Fraction:
    return start.at_s


def _same_length(
    rows: Sequence[NDArray[Any]], start: Start | None, rate_hz: float, names: Sequence[str], where: str
) -> NDArray[Any]:
    for row, name in zip(rows, names, strict=True):
        if len(row) != len(rows[0]):
            begin = f" from {float(start.at_s):g} s" if start is not None else ""
            raise DataError(
                f"channel {name} has {len(row)} samples at {rate_hz:g} Hz{begin}, "
                f"channel {names[0]} has {len(rows[0])}{begin}: which are missing is not said",
                where=where,
                remedy=_APART,
            )
    return np.stack(rows)


def _samples_ahead(stamps: Sequence[Start], rate_hz: float, names: Sequence[str], where: str) -> list[Fraction]:
    """By how many samples each channel begins before the last one; whole numbers where they are meant to be."""
    # A whole second is written without its zeros by some programs: a file's starts are as exact as the longest one.
    index = int(np.argmin([start.resolution_s for start in stamps]))
    coarse = stamps[index].resolution_s * rate_hz
    if coarse > _COARSE:
        raise DataError(
            f"channels begin at different times, and the start of {names[index]} is written to "
            f"{2 * stamps[index].resolution_s:g} s where a sample lasts {1 / rate_hz:g} s",
            where=where,
            remedy="export the starts with more digits, or channels that were recorded together",
        )
    last = max(start.at_s for start in stamps)
    exact = [(last - start.at_s) * Fraction(rate_hz) for start in stamps]
    return [Fraction(round(a)) if abs(a - round(a)) <= max(_WHOLE, 2 * coarse) else a for a in exact]


def _from_sample(row: NDArray[Any], lead: Fraction, rate_hz: float) -> NDArray[Any]:
    """A row from `lead` samples after its first one on."""
    whole = int(lead)
    if lead == whole:
        return row[whole:]
    if len(row) <= whole + 2 * HALF:
        return row[:0]
    lag = np.array([float(lead - whole) / rate_hz])
    # What is next to the end of the record would be made up.
    return align_channels(row[None].astype(np.float64), rate_hz, lag)[0, whole:-HALF]


def _apart(rows: Sequence[NDArray[Any]], stamps: Sequence[Start], rate_hz: float, names: Sequence[str]) -> str:
    first = min(start.at_s for start in stamps)
    begin = [float(start.at_s - first) for start in stamps]
    end = [b + len(row) / rate_hz for b, row in zip(begin, rows, strict=True)]
    late, early = int(np.argmax(begin)), int(np.argmin(end))
    return (
        f"the records do not overlap: {names[late]} begins {begin[late]:.6g} s after the first, "
        f"{names[early]} ends at {end[early]:.6g} s"
    )
