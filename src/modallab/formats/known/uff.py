"""Universal files."""

import re
from pathlib import Path

from modallab.formats.format import Format, deferred

_MARK = re.compile(rb"(?:\A\s*| {4})-1 *[\r\n]+ *\d{1,6}(?!\d)")
"""What begins a dataset; words of a program may stand above the first."""


def _fits(head: bytes, path: Path) -> bool:
    return _MARK.search(head) is not None


FORMAT = Format(
    name="uff",
    title="UFF 58 or 58b",
    description="a universal file: functions of dataset 58 as text or binary, shapes of dataset 55",
    endings=(".uff", ".unv", ".bunv", ".uf"),
    is_no="universal file: it has no line '    -1'",
    holds=("records", "FRFs", "modes"),
    asks=("test", "drive_point", "volts", "frequency_hz", "window_s"),
    priority=50,
    fits=_fits,
    read=deferred("uff.uff_read:read_uff"),
    draft=deferred("uff.uff_read:draft_uff"),
    write=deferred("uff.uff_write:write_uff"),
)
