"""SEP005 time series of SDyPy, as JSON."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    return head.lstrip().startswith(b"[") and path.suffix.lower() == ".json"


FORMAT = Format(
    name="sep005",
    title="SEP005 in JSON",
    description="a list of time series with name, unit and rate, as SDyPy has it",
    endings=(".json",),
    is_no="JSON list of time series",
    holds=("records",),
    asks=("test", "drive_point", "volts", "frequency_hz", "variables"),
    priority=40,
    fits=_fits,
    read=deferred("sep005.sep005:read_sep005"),
    draft=deferred("sep005.sep005:draft_sep005"),
    write=deferred("sep005.sep005:write_sep005"),
)
