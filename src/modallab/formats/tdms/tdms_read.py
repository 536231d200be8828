"""Reads TDMS files of plain, contiguous samples: our own and those of LabVIEW; segments add to one another."""

import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.tdms.tdms_types import (
    BIG_ENDIAN,
    DAQMX,
    HAS_METADATA,
    HAS_RAW,
    INTERLEAVED,
    NEW_OBJECTS,
    RAW_TYPES,
    TAG,
)

_COPY_AGAIN = "copy the file again, or export it again"
_NO_RAW, _AS_BEFORE = 0xFFFFFFFF, 0
_LEAD = 28
_PLAIN = {1: "<b", 2: "<h", 3: "<i", 4: "<q", 5: "<B", 6: "<H", 7: "<I", 8: "<Q", 9: "<f", 10: "<d", 0x21: "<?"}
_STRING, _TIME = 0x20, 0x44


@dataclass
class TdmsObject:
    """A root, a group or a channel: its properties, and the samples that were found for it."""

    properties: dict[str, Any] = field(default_factory=dict[str, Any])
    index: tuple[str, int] | None = None
    parts: list[NDArray[Any]] = field(default_factory=list[NDArray[Any]])

    @property
    def samples(self) -> NDArray[Any]:
        """(n,) samples of all segments."""
        return np.concatenate(self.parts) if self.parts else np.empty(0)


def read_tdms_objects(path: Path) -> dict[str, TdmsObject]:
    """Objects by their path, such as `/'group'/'channel'`, in the order of the file.

    Raises:
        FormatError: no TDMS file, cut off, or with what is not read here: interleaved or big-endian samples, raw data
            of NI-DAQmx.
    """
    content, where = path.read_bytes(), str(path)
    objects: dict[str, TdmsObject] = {}
    active: list[str] = []
    at = 0
    try:
        while at < len(content):
            at = _Segment(content, at, where).read(objects, active)
    except (struct.error, IndexError, UnicodeError, ValueError, OverflowError, MemoryError) as error:
        raise FormatError(f"is damaged near byte {at}: {error}", where=where, remedy=_COPY_AGAIN) from error
    if not objects:
        raise FormatError("is no TDMS file", where=where, remedy=_COPY_AGAIN)
    return objects


class _Segment:
    def __init__(self, content: bytes, at: int, where: str) -> None:
        self._content = content
        self._where = where
        if content[at : at + 4] != TAG:
            raise FormatError(f"has no segment at byte {at}", where=where, remedy=_COPY_AGAIN)
        self._toc, _, self._length, self._raw = struct.unpack_from("<IIQQ", content, at + 4)
        self._begin = self._at = at + _LEAD
        if self._toc & (BIG_ENDIAN | INTERLEAVED | DAQMX):
            raise FormatError(
                "holds interleaved, big-endian or DAQmx raw samples",
                where=where,
                remedy="save it again with LabVIEW or DIAdem as plain samples, or export CSV",
            )
        if self._begin + self._length > len(content) or self._raw > self._length:
            raise FormatError("is cut off", where=where, remedy=_COPY_AGAIN)

    def read(self, objects: dict[str, TdmsObject], active: list[str]) -> int:
        if self._toc & HAS_METADATA:
            if self._toc & NEW_OBJECTS:
                active.clear()
            for _ in range(self._number("<I")):
                self._object(objects, active)
        if self._toc & HAS_RAW:
            self._samples([objects[name] for name in active if objects[name].index is not None])
        return self._begin + self._length

    def _object(self, objects: dict[str, TdmsObject], active: list[str]) -> None:
        name = self._text()
        found = objects.setdefault(name, TdmsObject())
        self._index(found)
        if name not in active:
            active.append(name)
        for _ in range(self._number("<I")):
            key = self._text()
            found.properties[key] = self._value(self._number("<I"))

    def _index(self, found: TdmsObject) -> None:
        length = self._number("<I")
        if length == _NO_RAW:
            found.index = None
        elif length != _AS_BEFORE:
            code, dimension, count = self._number("<I"), self._number("<I"), self._number("<Q")
            if length != 20 or dimension != 1 or code not in RAW_TYPES:
                raise FormatError(
                    f"holds samples of type {code:#x}", where=self._where, remedy="save them as integers or floats"
                )
            found.index = (RAW_TYPES[code], count)

    def _samples(self, found: list[TdmsObject]) -> None:
        at, end = self._begin + self._raw, self._begin + self._length
        chunk = sum(np.dtype(kind).itemsize * count for kind, count in (o.index for o in found if o.index))
        if not chunk or (end - at) % chunk:
            raise FormatError("holds part of a chunk of samples", where=self._where, remedy=_COPY_AGAIN)
        while at < end:
            for one in found:
                assert one.index is not None
                kind, count = one.index
                one.parts.append(np.frombuffer(self._content, kind, count, at))
                at += np.dtype(kind).itemsize * count

    def _value(self, code: int) -> Any:
        if code == _STRING:
            return self._text()
        if code == _TIME:
            fraction, seconds = self._number("<Q"), self._number("<q")
            return seconds + fraction / 2**64
        if code not in _PLAIN:
            raise FormatError(f"has a property of type {code:#x}", where=self._where, remedy="save it again, plainly")
        return self._number(_PLAIN[code])

    def _number(self, kind: str) -> Any:
        (value,) = struct.unpack_from(kind, self._content, self._at)
        self._at += struct.calcsize(kind)
        return value

    def _text(self) -> str:
        length = self._number("<I")
        raw = self._content[self._at : self._at + length]
        if len(raw) != length:
            raise FormatError("is cut off within a text", where=self._where, remedy=_COPY_AGAIN)
        self._at += length
        return raw.decode("utf-8")
