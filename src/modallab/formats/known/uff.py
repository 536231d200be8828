"""Universal files."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.uff.uff_functions import DELIMITER

    return head.lstrip().splitlines()[0].strip() == DELIMITER


FORMAT = Format(
    name="uff",
    title="UFF 58 or 58b",
    description="a universal file: functions of dataset 58 as text or binary, shapes of dataset 55",
    endings=(".uff", ".unv", ".bunv", ".uf"),
    is_no="universal file: it does not begin with a line '    -1'",
    holds=("records", "FRFs", "modes"),
    asks=("test", "drive_point", "volts", "frequency_hz", "window_s"),
    priority=50,
    fits=_fits,
    read=deferred("uff.uff_read:read_uff"),
    draft=deferred("uff.uff_read:draft_uff"),
    write=deferred("uff.uff_write:write_uff"),
)
