"""Clock times and dates in a column of times, as seconds."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

DAY_S = 86400
_DATE = r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.](?:\d{1,2}|[A-Za-z]{3})[-/.]\d{2,4}"
_CLOCK = r"(?P<h>\d{1,2}):(?P<m>\d\d)(?::(?P<s>\d\d))?(?:(?:[.,]|:(?=\d{3}))(?P<f>\d+))?\s*(?P<half>[AaPp][Mm])?"
_ZONE = r"\s*(?:Z|UTC|[+-]\d\d:?\d\d)?"
_DAYS = r"\d+ days?,?"
_TIME = re.compile(rf"\s*(?:(?P<date>{_DATE}|{_DAYS})[T\s]\s*)?{_CLOCK}{_ZONE}\s*")
_ONLY_DATE = re.compile(rf"\s*(?:{_DATE})\s*")


@dataclass(frozen=True, slots=True)
class _Moment:
    date: str
    seconds: int
    fraction: str


def is_time(cell: str) -> bool:
    """Whether a cell holds a time of the day or a date, or both: 10:00:01.5, 2026-11-26T10:00:01,5, 0 days 00:00:01."""
    return cell[:1].isdigit() and (_TIME.fullmatch(cell) or _ONLY_DATE.fullmatch(cell)) is not None


def is_clock(cell: str) -> bool:
    """Whether a cell holds a time of the day, with a date or without one."""
    return _TIME.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Whether a cell holds a date alone."""
    return _ONLY_DATE.fullmatch(cell) is not None


def seconds_of(cells: Sequence[str]) -> list[str]:
    """The cells as seconds after the whole second of the first one, with the digits that they have.

    A day begins where the date changes, and without a date where the clock falls by more than half a day. A cell that
    is no time stays as it is.
    """
    found: list[str] = []
    day, first, last = 0, 0, None
    for cell in cells:
        moment = _moment(cell)
        if moment is None:
            found.append(cell)
            continue
        if last is None:
            first = moment.seconds
        elif moment.date != last.date or last.seconds - moment.seconds > DAY_S // 2:
            day += 1
        last = moment
        found.append(f"{day * DAY_S + moment.seconds - first}.{moment.fraction}")
    return found


def _moment(cell: str) -> _Moment | None:
    at = _TIME.fullmatch(cell)
    if at is None:
        return None
    if at["s"] is None and at["f"] is not None:
        # Minutes and seconds, as spreadsheets show them.
        return _Moment(at["date"] or "", 60 * int(at["h"]) + int(at["m"]), at["f"])
    hour = int(at["h"])
    if at["half"]:
        hour = hour % 12 + (12 if at["half"].lower() == "pm" else 0)
    return _Moment(at["date"] or "", 3600 * hour + 60 * int(at["m"]) + int(at["s"] or 0), at["f"] or "")
