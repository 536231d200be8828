"""NPY arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    return head.startswith(b"\x93NUMPY") or (head.startswith(b"PK\x03\x04") and path.suffix.lower() == ".npz")


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.npy.npy import read_npy

    return read_npy(path, rig, options)


FORMAT = Format(
    name="npy",
    title="NPY",
    description="arrays of NumPy (.npz: several): fields by name, or rows of times and then the channels in rig order",
    endings=(".npy", ".npz"),
    is_no="NPY file",
    holds=("records",),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "variables", "array_map"),
    priority=20,
    fits=_fits,
    read=_read,
)
