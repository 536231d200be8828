"""The global heaps of an HDF5 file, where text of variable length lies without a checksum.

The HDF5 library walks them trusting their sizes: an entry of size 0 keeps it there for ever, and for a text that claims
4 GB it first clears 4 GB. So they are walked here first. Layout: HDF5 file format specification, section III.E.
"""

import mmap
import struct
from pathlib import Path

from modallab.core.errors import FormatError

_SIGNATURE = b"GCOL\x01\x00\x00\x00"
_HEADER = struct.Struct("<8sQ")
_ENTRY = struct.Struct("<HHIQ")
_REFERENCE = struct.Struct("<IQI")
_ADDRESS = struct.Struct("<Q")
_MOST_ENTRIES = 0xFFFF


def check_heaps(file: Path, remedy: str) -> None:
    """Reject a file, not empty, with a heap that does not add up.

    Raises:
        FormatError: the heap's place in the file.
    """
    with file.open("rb") as source, mmap.mmap(source.fileno(), 0, access=mmap.ACCESS_READ) as content:
        at = content.find(_SIGNATURE)
        while at >= 0:
            if not _adds_up(content, at) or not _references_fit(content, at):
                raise FormatError(f"is damaged: the text at byte {at} does not add up", where=str(file), remedy=remedy)
            at = content.find(_SIGNATURE, at + 1)


def _adds_up(content: mmap.mmap, start: int) -> bool:
    if start + _HEADER.size > len(content):
        return False
    end = start + int(_HEADER.unpack_from(content, start)[1])
    if end > len(content):
        return False
    at = start + _HEADER.size
    while at + _ENTRY.size <= end:
        index, _, _, size = _ENTRY.unpack_from(content, at)
        if index == 0:  # The rest is free; its size counts this entry's own head.
            return bool(at + size == end)
        at += _ENTRY.size + (size + 7) // 8 * 8
    return at <= end


def _references_fit(content: mmap.mmap, start: int) -> bool:
    # A text is referred to by its length, the place of its heap, and its index in the heap.
    address, before = _ADDRESS.pack(start), 4
    at = content.find(address)
    while at >= 0:
        if before <= at <= len(content) - _REFERENCE.size + before:
            length, _, index = _REFERENCE.unpack_from(content, at - before)
            if 0 < index <= _MOST_ENTRIES and length > len(content):
                return False
        at = content.find(address, at + 1)
    return True
