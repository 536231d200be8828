"""CSV tables."""

from pathlib import Path

from modallab.formats.format import Format, deferred

_ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc")


def _fits(head: bytes, path: Path) -> bool:
    return path.suffix.lower() in _ENDINGS or all(byte >= 32 or byte in b"\t\r\n\f" for byte in head)


FORMAT = Format(
    name="csv",
    title="CSV",
    description="a table as text: a column of times and one for each channel; a folder of them when written",
    endings=_ENDINGS,
    is_no="table as text",
    holds=("records", "FRFs", "modes"),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "window_s", "variables", "columns"),
    priority=60,
    certain=False,
    fits=_fits,
    read=deferred("csv.csv_read:read_csv"),
    draft=deferred("csv.csv_read:draft_csv"),
    write=deferred("csv.csv_write:write_csv"),
)
