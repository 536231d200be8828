"""HDF5 files of which nothing is taken on trust.

Text of variable length lies in global heaps without a checksum. The HDF5 library walks them trusting their sizes: an
entry of size 0 keeps it there for ever, and for a text that claims 4 GB it first clears 4 GB. So they are walked here
first. Layout: HDF5 file format specification, section III.E.
"""

import mmap
import re
import struct
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError, ModallabError

MAGIC = b"\x89HDF\r\n\x1a\n"
COPY_AGAIN = "copy the file again from where it was recorded"

# Deflate packs at most 1032 to 1: a file that claims more holds nothing of the kind.
_MOST_PACKED = 1100
_SPARE_BYTES = 1 << 20
_PLAIN_TYPES = (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.STRING)
_SIGNATURE = b"GCOL\x01\x00\x00\x00"
_HEADER = struct.Struct("<8sQ")
_ENTRY = struct.Struct("<HHIQ")
_REFERENCE = struct.Struct("<IQI")
_ADDRESS = struct.Struct("<Q")
_MOST_ENTRIES = 0xFFFF


@contextmanager
def open_hdf5(file: Path) -> Generator[h5py.File]:
    """An HDF5 file, to be read.

    Raises:
        FormatError: missing, a folder, empty, no HDF5, cut off or damaged.
    """
    _check_magic(file)
    _check_heaps(file, COPY_AGAIN)
    try:
        with h5py.File(file, "r") as source:
            yield source
    except ModallabError:
        raise
    except Exception as error:  # On damaged bytes HDF5 raises nearly every type there is.
        raise FormatError(_damage(error), where=str(file), remedy=COPY_AGAIN) from error


def is_hdf5(head: bytes) -> bool:
    """Whether a file that begins with these bytes is HDF5."""
    return head.startswith(MAGIC)


def is_campaign(path: Path) -> bool:
    """Whether HDF5 says that it is a campaign, or cannot say what it is."""
    try:
        with h5py.File(path, "r") as source:
            return "format_version" in source.attrs or "volts_per_count" in source.attrs
    except OSError:
        return True


def read_array(dataset: h5py.Dataset, where: str) -> NDArray[Any]:
    """The whole of a dataset, in the byte order of this machine.

    Raises:
        FormatError: it claims more than its file can hold.
    """
    shape, dtype = cast("tuple[int, ...]", dataset.shape), cast("np.dtype[Any]", dataset.dtype)
    claimed = int(np.prod([int(n) for n in shape], dtype=object)) * dtype.itemsize
    held = int(dataset.file.id.get_filesize())
    if claimed > _MOST_PACKED * held + _SPARE_BYTES:
        raise FormatError(f"claims {claimed} bytes in a file of {held}", where=where, remedy=COPY_AGAIN)
    _check_chunks(dataset, where)
    values = np.asarray(dataset[()])
    return values.astype(dtype.newbyteorder("="), copy=False)


def datasets(group: h5py.Group, where: str) -> Iterator[tuple[str, h5py.Dataset]]:
    """The datasets of a group with their names.

    Raises:
        FormatError: something else stands among them.
    """
    for key in group:
        name = str(key)
        member = group.get(name)
        if not isinstance(member, h5py.Dataset):
            raise FormatError(f"{name!r} is no dataset", where=where, remedy=COPY_AGAIN)
        yield name, member


def _check_chunks(dataset: h5py.Dataset, where: str) -> None:
    # HDF5 takes a lost chunk for one never written, and reads it as zeros.
    if dataset.chunks is None:
        return
    found: set[tuple[int, ...]] = set()

    def note(chunk: Any) -> None:
        found.add(tuple(chunk.chunk_offset))

    dataset.id.chunk_iter(note)
    spans = [range(0, n, step) for n, step in zip(dataset.shape, dataset.chunks, strict=True)]
    expected = set(product(*spans))
    if found != expected:
        raise FormatError(
            f"{len(expected - found)} of {len(expected)} pieces of its samples are lost", where=where, remedy=COPY_AGAIN
        )


@dataclass(frozen=True)
class TypedAttributes:
    """The attributes of an object, each with its type.

    Every method raises FormatError if the attribute is missing (without a default) or of another type.
    """

    values: dict[str, Any]
    where: str

    @classmethod
    def of(cls, target: h5py.Group | h5py.Dataset, where: str) -> "TypedAttributes":
        """The attributes of a group or dataset; `where` names it in messages."""
        names = [str(key) for key in target.attrs]
        for name in names:
            _check_type(target, name, where)
        return cls({name: target.attrs[name] for name in names}, where)

    def text(self, name: str) -> str:
        """A text."""
        return _text(self._get(name))

    def texts(self, name: str) -> tuple[str, ...]:
        """A list of texts."""
        return tuple(_text(value) for value in np.atleast_1d(self._get(name)))

    def real(self, name: str) -> float:
        """A number."""
        return float(self._get(name))

    def reals(self, name: str) -> NDArray[np.float64]:
        """A list of numbers."""
        return np.atleast_1d(np.asarray(self._get(name), dtype=np.float64))

    def whole(self, name: str) -> int:
        """A whole number."""
        value = self._get(name)
        if int(value) != value:
            raise FormatError(f"{name} is {value}, not whole", where=self.where, remedy=COPY_AGAIN)
        return int(value)

    def choice(self, name: str, *allowed: str) -> str:
        """One of some texts."""
        value = self.text(name)
        if value not in allowed:
            raise FormatError(
                f"{name} is {value!r}, not one of {', '.join(allowed)}", where=self.where, remedy=COPY_AGAIN
            )
        return value

    def has(self, name: str) -> bool:
        """Whether there is such an attribute."""
        return name in self.values

    def _get(self, name: str) -> Any:
        if name not in self.values:
            raise FormatError(f"has no attribute {name!r}", where=self.where, remedy="write it as the format says")
        return self.values[name]


def _check_type(target: h5py.Group | h5py.Dataset, name: str, where: str) -> None:
    # Reading an attribute whose type was damaged crashes the HDF5 library, so its type is looked at first.
    attribute = h5py.h5a.open(target.id, name.encode("utf-8"))
    if attribute.get_type().get_class() not in _PLAIN_TYPES:
        raise FormatError(f"attribute {name!r} is neither text nor number", where=where, remedy=COPY_AGAIN)


def _text(value: object) -> str:
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)


def _check_magic(file: Path) -> None:
    try:
        with file.open("rb") as source:
            head = source.read(len(MAGIC))
    except OSError as error:
        found = "is a folder" if file.is_dir() else f"cannot be read: {error.strerror or error}"
        raise FormatError(found, where=str(file), remedy="name a campaign file") from error
    if not head:
        raise FormatError("is empty", where=str(file), remedy=COPY_AGAIN)
    if not is_hdf5(head):
        raise FormatError("is no HDF5 file", where=str(file), remedy="name a campaign file, or import it first")


def _damage(error: Exception) -> str:
    sizes = re.search(r"truncated file: eof = (\d+).*stored_eof = (\d+)", str(error))
    if sizes:
        return f"is cut off: {sizes[1]} of {sizes[2]} bytes are there"
    return f"is damaged: HDF5 says {type(error).__name__}: {error}"


def _check_heaps(file: Path, remedy: str) -> None:
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
