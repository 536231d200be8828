"""Closes the HDF5 file of a writer that was killed, so that it opens as any other.

HDF5 marks a file while it is written. A marked file opens in the mode for live files only, and in that mode a damaged
spot is not an error but read again and again for ever, in the hope that a writer is about to finish it. The mark and
the end of the file stand in the superblock (HDF5 File Format Specification 3.0, II.A, version 3), with a checksum.
"""

import os
import struct
from pathlib import Path

from modallab.storage.durable import sync_file

SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SIZE, _VERSION, _FLAGS = 48, 8, 11
_END = slice(28, 36)
_SUM = slice(44, 48)
_MASK = 0xFFFFFFFF


def seal_file(path: Path) -> bool:
    """Take the mark off a file nobody writes any more; samples are not touched. False if it is not such a file."""
    with path.open("r+b") as file:
        head = bytearray(file.read(_SIZE))
        if not _is_sound(head):
            return False
        head[_FLAGS] = 0
        head[_END] = struct.pack("<Q", os.fstat(file.fileno()).st_size)
        head[_SUM] = struct.pack("<I", lookup3_checksum(bytes(head[: _SUM.start])))
        file.seek(0)
        file.write(head)
        file.flush()
        sync_file(file.fileno())
    return True


def _is_sound(head: bytearray) -> bool:
    if len(head) < _SIZE or not head.startswith(SIGNATURE) or head[_VERSION] != 3:
        return False
    return struct.unpack("<I", head[_SUM])[0] == lookup3_checksum(bytes(head[: _SUM.start]))


def lookup3_checksum(data: bytes) -> int:
    """Checksum of HDF5's metadata: Bob Jenkins' lookup3, `hashlittle` with an initial value of 0."""
    a = b = c = (0xDEADBEEF + len(data)) & _MASK
    if not data:
        return c
    padded = data + bytes(-len(data) % 12)
    words = struct.unpack(f"<{len(padded) // 4}I", padded)
    for n in range(0, len(words), 3):
        a, b, c = (a + words[n]) & _MASK, (b + words[n + 1]) & _MASK, (c + words[n + 2]) & _MASK
        a, b, c = _mix_words(a, b, c) if n + 3 < len(words) else _final_mix(a, b, c)
    return c


def _mix_words(a: int, b: int, c: int) -> tuple[int, int, int]:
    for turn in (4, 6, 8, 16, 19, 4):
        a = ((a - c) & _MASK) ^ _rotate_left(c, turn)
        c = (c + b) & _MASK
        a, b, c = b, c, a
    return a, b, c


def _final_mix(a: int, b: int, c: int) -> tuple[int, int, int]:
    for turn in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _rotate_left(b, turn)) & _MASK
        a, b, c = b, c, a
    # Seven steps are two rounds and one: the three stand one place further.
    return c, a, b


def _rotate_left(value: int, bits: int) -> int:
    return ((value << bits) | (value >> (32 - bits))) & _MASK
