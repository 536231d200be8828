"""What the operating system must promise before a block may be called kept, on Linux, macOS and Windows."""

import ctypes
import os
import re
import shutil
import sys
from pathlib import Path

from modallab.core.errors import DiskFullError, StorageError
from modallab.core.plan import Plan

NETWORK_FILE_SYSTEMS = frozenset({"nfs", "nfs4", "cifs", "smb3", "smbfs", "afs", "ncpfs", "fuse.sshfs", "fuse.rclone"})
"""Where locks and shared mappings do not hold between machines, or a sync does not reach the disk."""

_DRIVE_REMOTE = 4


def sync_file(descriptor: int) -> None:
    """Wait until the data of an open file are on the disk."""
    if sys.platform == "linux":
        os.fdatasync(descriptor)
    else:
        os.fsync(descriptor)


def sync_folder(folder: Path) -> None:
    """Wait until the names in a folder are on the disk; Windows does so by itself and opens no folders."""
    if sys.platform == "win32":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def require_space(folder: Path, need_bytes: int) -> None:
    """Raise if there is too little room to go on.

    Raises:
        DiskFullError: fewer than `need_bytes` are free where `folder` is.
    """
    free = shutil.disk_usage(folder).free
    if free < need_bytes:
        raise DiskFullError(
            f"{free / 1e6:.1f} MB are free, {need_bytes / 1e6:.1f} MB are needed",
            where=str(folder),
            remedy="free space or choose another data folder; acknowledged blocks are kept",
        )


def require_local(folder: Path) -> None:
    """Reject a folder on a network share, as far as the system says.

    Raises:
        StorageError: the folder is on a share.
    """
    kind = _network_kind(folder.resolve())
    if kind is not None:
        raise StorageError(
            f"the data folder is on a network share ({kind})",
            where=str(folder),
            remedy="record on a local disk and copy the finished runs to the share",
        )


def storage_failure(error: Exception, where: str) -> StorageError:
    """The typed error for what HDF5, SQLite or the operating system said while writing."""
    text = str(error)
    # HDF5 raises RuntimeError as often as OSError, with the number in its text only.
    full = getattr(error, "errno", None) == 28 or re.search(r"errno = 28\b|database or disk is full", text)
    if full:
        return DiskFullError(
            "the disk is full; this block was not stored, but all acknowledged blocks are",
            where=where,
            remedy="free space and continue with a new run",
        )
    return StorageError(
        f"cannot be written: {text}", where=where, remedy="check the disk; all acknowledged blocks are kept"
    )


def _network_kind(folder: Path) -> str | None:
    if sys.platform == "win32":
        if str(folder).startswith("\\\\"):
            return "UNC path"
        remote = ctypes.windll.kernel32.GetDriveTypeW(folder.anchor) == _DRIVE_REMOTE
        return f"drive {folder.drive}" if remote else None
    mounts = Path("/proc/self/mountinfo")
    kind = file_system(folder, mounts.read_text(encoding="utf-8")) if mounts.exists() else ""
    return kind if kind in NETWORK_FILE_SYSTEMS else None


def file_system(folder: Path, mountinfo: str) -> str:
    """Type of the file system that holds an absolute path, by the text of Linux's `mountinfo`."""
    best, kind = "", ""
    for line in mountinfo.splitlines():
        left, _, right = line.partition(" - ")
        point = re.sub(r"\\(\d{3})", lambda octal: chr(int(octal[1], 8)), left.split()[4])
        if folder.is_relative_to(point) and len(point) >= len(best):
            best, kind = point, right.split()[0]
    return kind


MARGIN = 1.25
"""Hits that are rejected and bursts that are repeated are kept too."""


def planned_blocks(plan: Plan) -> int:
    """Blocks a plan asks for, if nothing need be repeated."""
    if plan.kind == "impact":
        return len(plan.points) * plan.hits
    if plan.kind == "broadband":
        return plan.blocks * len(plan.levels_v)
    return len(plan.frequencies_hz) * len(plan.levels_v)


def require_room(folder: Path, plan: Plan, block_bytes: int) -> None:
    """Reject to begin a run that cannot end.

    Args:
        folder: of the samples.
        plan: what will be recorded.
        block_bytes: of one block of all channels.

    Raises:
        DiskFullError: fewer bytes are free than the plan's blocks and a quarter more.
    """
    require_space(folder, int(MARGIN * planned_blocks(plan) * block_bytes))
