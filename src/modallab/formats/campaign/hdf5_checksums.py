"""Arrays and texts in HDF5 with a checksum of their own."""

import zlib
from collections.abc import Sequence
from typing import Any, cast

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.campaign.hdf5_access import COPY_AGAIN, TypedAttributes, read_array

_CHUNK_BYTES = 1 << 20


def write_sealed(group: h5py.Group, name: str, values: NDArray[Any]) -> h5py.Dataset:
    """Write an array, packed, with its crc32 (of the little-endian bytes in C order) as attribute."""
    row_bytes = values.nbytes // values.shape[-1] if values.size else 1
    chunk = (*values.shape[:-1], max(1, min(values.shape[-1], _CHUNK_BYTES // max(1, row_bytes))))
    packed = {"chunks": chunk, "compression": "gzip", "shuffle": True, "fletcher32": True} if values.size else {}
    dataset = group.create_dataset(name, data=values, **cast("Any", packed))
    dataset.attrs["crc32"] = _crc32(values)
    return dataset


def read_sealed(dataset: h5py.Dataset, where: str) -> NDArray[Any]:
    """Read an array back.

    Raises:
        FormatError: it does not agree with its checksum.
    """
    values = read_array(dataset, where)
    if _crc32(values) != TypedAttributes.of(dataset, where).whole("crc32"):
        found = "does not agree with its checksum: it was changed or damaged after it was written"
        raise FormatError(found, where=where, remedy=COPY_AGAIN)
    return values


def write_text(target: h5py.File, name: str, text: str) -> None:
    """Write a text as an array of its UTF-8 bytes."""
    write_sealed(target, name, np.frombuffer(text.encode("utf-8"), dtype=np.uint8))


def read_text(source: h5py.File, name: str, where: str) -> str:
    """Read a text back, "" if there is none.

    Raises:
        FormatError: it is no text, or does not agree with its checksum.
    """
    if name not in source:
        return ""
    dataset = source[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype != np.uint8:
        raise FormatError(f"{name} is no text", where=where, remedy=COPY_AGAIN)
    return read_sealed(dataset, f"{where}, {name}").tobytes().decode("utf-8")


def get_group(parent: h5py.Group, name: str, where: str) -> h5py.Group:
    """A group by its name.

    Raises:
        FormatError: there is none.
    """
    group = parent.get(name)
    if not isinstance(group, h5py.Group):
        raise FormatError(f"has no group {name!r}", where=where, remedy=COPY_AGAIN)
    return group


def fixed(texts: Sequence[str]) -> NDArray[np.bytes_]:
    """Texts as an attribute may hold them."""
    # Text of fixed length lies in the object's header, which HDF5 protects by a checksum; other text does not.
    encoded = [text.encode("utf-8") for text in texts]
    return np.array(encoded, dtype=f"S{max(1, *(len(text) for text in encoded), 1)}")


def _crc32(values: NDArray[Any]) -> int:
    return zlib.crc32(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
