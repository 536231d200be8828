"""TDMS files of LabVIEW and DIAdem."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.tdms.tdms_read import TAG

    return head.startswith(TAG)


FORMAT = Format(
    name="tdms",
    title="TDMS",
    description="files of LabVIEW and DIAdem: a group a record, counts with their scale",
    endings=(".tdms",),
    is_no="TDMS file",
    holds=("records",),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "variables", "group"),
    priority=30,
    fits=_fits,
    read=deferred("tdms.tdms_records:read_tdms"),
    draft=deferred("tdms.tdms_records:draft_tdms"),
    write=deferred("tdms.tdms_write:write_tdms"),
)
