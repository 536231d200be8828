"""MATLAB files."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.arrays.mat import MARKS

    # Version 4 has no mark; SciPy knows it by a zero where the others have text.
    return head.startswith(MARKS) or (path.suffix.lower() == ".mat" and 0 in head[:4])


FORMAT = Format(
    name="mat",
    title="MATLAB (.mat)",
    description="variables of MATLAB, version 4, 5 or 7.3: one for each channel, or one for all",
    endings=(".mat",),
    is_no="MATLAB file of version 4, 5 or 7.3",
    holds=("records", "FRFs"),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "window_s", "variables", "array_map"),
    priority=5,
    fits=_fits,
    read=deferred("arrays.mat:read_mat"),
    draft=deferred("arrays.mat:draft_mat"),
)
