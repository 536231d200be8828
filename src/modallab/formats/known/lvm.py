"""LabVIEW measurement files."""

from pathlib import Path

from modallab.formats.format import Format, deferred

_FIRST = b"LabVIEW Measurement"


def _fits(head: bytes, path: Path) -> bool:
    if head.removeprefix(b"\xef\xbb\xbf").startswith(_FIRST):
        return True
    # LabVIEW can leave the headers out: the rest is a table.
    return path.suffix.lower() == ".lvm" and all(byte >= 32 or byte in b"\t\r\n" for byte in head)


FORMAT = Format(
    name="lvm",
    title="LabVIEW measurement file (.lvm)",
    description="a measurement file of LabVIEW as text: a segment a record",
    endings=(".lvm",),
    is_no="measurement file of LabVIEW",
    holds=("records",),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "variables", "columns"),
    priority=25,
    fits=_fits,
    read=deferred("lvm.lvm:campaign_of_lvm"),
    draft=deferred("lvm.lvm:draft_lvm"),
)
