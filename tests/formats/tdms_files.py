"""TDMS files byte by byte after NI's published layout, in structures that npTDMS's own writer does not make."""

import struct
from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

META, NEW, RAW, INTERLEAVED, BIG = 2, 4, 8, 1 << 5, 1 << 6
_CODES = {"i2": 2, "u2": 6, "f4": 9, "f8": 10}
Properties = Mapping[str, Any]


def _text(s: str, order: str) -> bytes:
    return struct.pack(f"{order}I", len(s.encode())) + s.encode()


def _property(name: str, value: Any, order: str) -> bytes:
    head = _text(name, order)
    if isinstance(value, str):
        return head + struct.pack(f"{order}I", 0x20) + _text(value, order)
    if isinstance(value, tuple):  # Whole seconds and 2^-64 s since 1904; a fraction stands first.
        parts = (value[1], value[0]) if order == "<" else (value[0], value[1])
        return head + struct.pack(f"{order}I", 0x44) + struct.pack(f"{order}Qq" if order == "<" else ">qQ", *parts)
    return head + struct.pack(f"{order}Id", 10, value)


def channel(
    path: str, row: NDArray[Any] | None = None, said: Properties | None = None, order: str = "<", count: int = 0
) -> bytes:
    """An object of the metadata; `count` samples a chunk where a segment holds several."""
    index = struct.pack(f"{order}I", 0xFFFFFFFF)
    if row is not None:
        index = struct.pack(f"{order}IIIQ", 20, _CODES[row.dtype.str[1:]], 1, count or len(row))
    said = said or {}
    listed = b"".join(_property(name, value, order) for name, value in said.items())
    return _text(path, order) + index + struct.pack(f"{order}I", len(said)) + listed


def segment(objects: Sequence[bytes], raw: bytes = b"", *, flags: int = META | NEW | RAW) -> bytes:
    """A segment of these objects and samples."""
    order = ">" if flags & BIG else "<"
    metadata = struct.pack(f"{order}I", len(objects)) + b"".join(objects)
    lead = (
        b"TDSm" + struct.pack("<I", flags) + struct.pack(f"{order}IQQ", 4713, len(metadata) + len(raw), len(metadata))
    )
    return lead + metadata + raw
