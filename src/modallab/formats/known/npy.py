"""NPY arrays."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    return head.startswith(b"\x93NUMPY") or (head.startswith(b"PK\x03\x04") and path.suffix.lower() == ".npz")


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
    read=deferred("npy.npy:read_npy"),
)
