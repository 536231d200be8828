"""Times in text files: clocks and dates, counts since a day, few digits, faults."""

import datetime as dt
from pathlib import Path

from known import RATE, Known, case, hit
from text_cases import HEAD, comma, lines_of, plain, save, seconds

START = dt.datetime(2026, 3, 29, 23, 59, 59, 800000, tzinfo=dt.UTC)


def at(i: int) -> dt.datetime:
    return START + dt.timedelta(microseconds=round(i * 1e6 / RATE))


@case("text")
def iso_with_zone(folder: Path) -> Known:
    """ISO times with an offset from UTC, across midnight."""
    record = hit()
    rows = lines_of(record, lambda i: at(i).isoformat(timespec="microseconds"), plain, ",")
    return Known(save(folder, ["timestamp,force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (record,))


@case("text")
def clock_am_pm(folder: Path) -> Known:
    """American date and clock, `03/29/2026 11:59:59.8000 PM`, across midnight."""
    record = hit()
    stamp = lambda i: f"{at(i):%m/%d/%Y %I:%M:%S.%f} {at(i):%p}"  # noqa: E731
    reason = r"(?i)(AM|PM|/2026).*(?s:.*)(time|date|clock)|(time|date|clock)(?s:.*)(AM|PM|/2026)"
    return Known(
        save(folder, ["Time,force [N],a1 [m/s^2],a2 [m/s^2]", *lines_of(record, stamp, plain, ",")]),
        (record,),
        rejected=reason,
    )


@case("text")
def clock_german(folder: Path) -> Known:
    """`29.03.2026 23:59:59,8000`, semicolons, across midnight."""
    record = hit()
    stamp = lambda i: f"{at(i):%d.%m.%Y %H:%M:%S},{at(i).microsecond // 100:04d}"  # noqa: E731
    reason = r"(?i)29\.03\.2026"
    return Known(
        save(folder, ["Zeit;force [N];a1 [m/s^2];a2 [m/s^2]", *lines_of(record, stamp, comma, ";")]),
        (record,),
        rejected=reason,
    )


@case("text")
def minutes_and_seconds(folder: Path) -> Known:
    """Elapsed `00:01.5000` in minutes and seconds, past the full minute."""
    record = hit()
    stamp = lambda i: f"{int((59.8 + i / RATE) // 60):02d}:{(59.8 + i / RATE) % 60:07.4f}"  # noqa: E731
    reason = r"(?i)00:59\.8"
    return Known(
        save(folder, [HEAD.replace(" [s]", ""), *lines_of(record, stamp, plain, ",")]), (record,), rejected=reason
    )


@case("text")
def epoch_seconds(folder: Path) -> Known:
    """Seconds since 1970 with four decimals."""
    record = hit()
    stamp = lambda i: f"{START.timestamp() + i / RATE:.4f}"  # noqa: E731
    return Known(save(folder, [HEAD, *lines_of(record, stamp, plain, ",")]), (record,))


@case("text")
def epoch_milliseconds(folder: Path) -> Known:
    """Milliseconds since 1970 with one decimal."""
    record = hit()
    stamp = lambda i: f"{1e3 * START.timestamp() + 1e3 * i / RATE:.1f}"  # noqa: E731
    return Known(save(folder, [HEAD.replace("[s]", "[ms]"), *lines_of(record, stamp, plain, ",")]), (record,))


@case("text")
def spreadsheet_days(folder: Path) -> Known:
    """Times as a spreadsheet counts them, in days: not seconds, and so named."""
    record = hit()
    stamp = lambda i: f"{46110 + i / RATE / 86400:.12f}"  # noqa: E731
    return Known(
        save(folder, [HEAD.replace("[s]", "[d]"), *lines_of(record, stamp, plain, ",")]),
        (record,),
        rejected=r"(?i)unit|\bd\b|day",
    )


@case("text")
def few_digits_of_a_binary_rate(folder: Path) -> Known:
    """2048 Hz, times in ms with two decimals."""
    record = hit(rate=2048.0)
    rows = lines_of(record, lambda i: f"{1e3 * i / 2048:.2f}", plain, ";")
    return Known(save(folder, [HEAD.replace("[s]", "[ms]").replace(",", ";"), *rows]), (record,))


@case("text")
def odd_rate(folder: Path) -> Known:
    """A converter's 1953.125 Hz, seven digits of time, half an hour after the start."""
    record = hit(rate=1953.125)
    rows = lines_of(record, lambda i: f"{1800 + i / 1953.125:.7f}", plain, ",")
    return Known(save(folder, [HEAD, *rows]), (record,))


@case("text")
def rate_that_contradicts(folder: Path) -> Known:
    """`--rate 1000` where the times say 2000: one of them is wrong."""
    rows = lines_of(hit(), seconds, plain, ",")
    return Known(
        save(folder, [HEAD, *rows]),
        (hit(),),
        options=("--drive-point", "1", "--rate", "1000"),
        rejected="(?is)1000.*2000|2000.*1000",
        says="1000|2000",
    )


@case("text")
def without_times(folder: Path) -> Known:
    """No column of times; the rate stands in a comment only."""
    rows = [",".join(plain(v) for v in row) for row in hit().rows.T]
    return Known(
        save(folder, ["# sampled at 2000 Hz", "force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), rejected="(?i)rate|time"
    )


@case("text")
def repeated_time(folder: Path) -> Known:
    """One row stands twice: a sample too many."""
    rows = lines_of(hit(), seconds, plain, ",")
    return Known(
        save(folder, [HEAD, *rows[:300], rows[299], *rows[300:]]), rejected=r"(?i)line 30[12]|0\.1495|ascend|even"
    )


@case("text")
def lost_samples(folder: Path) -> Known:
    """Twenty rows are missing in the middle."""
    rows = lines_of(hit(), seconds, plain, ",")
    return Known(save(folder, [HEAD, *rows[:300], *rows[320:]]), rejected=r"(?i)line 30[12]|0\.1[56]|even|lost|missing")
