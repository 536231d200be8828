"""MATLAB files: versions 4 and 5 by SciPy, version 7.3, which is HDF5, by h5py."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy import io

from modallab.core.block import Campaign
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.formats.arrays.arrays_draft import draft_arrays
from modallab.formats.arrays.mapped import campaign_of_map
from modallab.formats.arrays.named import campaign_of_arrays
from modallab.formats.options import ImportOptions

MARKS = (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file")
_AGAIN = "save it again in MATLAB: save('file.mat', '-v7') or '-v7.3'"


def read_mat(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record, or one matrix of FRFs, from the variables of a MATLAB file.

    Fields of a structure are called structure.field. Numbers are in the rig's units, or volts if the options say so.

    Raises:
        FormatError: no whole MATLAB file.
        DataError: variables that are missing or do not fit.
    """
    if options.array_map is not None:
        return campaign_of_map(_arrays(path), options.array_map, path.stem, rig, options, str(path))
    return campaign_of_arrays(_arrays(path), path.stem, rig, options, str(path))


def draft_mat(path: Path, options: ImportOptions) -> Rig:
    """The rig that a MATLAB file's records or FRFs were made on, as far as its variables or the map say.

    Raises:
        FormatError: no whole MATLAB file.
        DataError: what a variable is cannot be known.
    """
    return draft_arrays(_arrays(path), options.array_map, path)


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    with path.open("rb") as source:
        newer = source.read(len(MARKS[1])) == MARKS[1]
    try:
        return dict(_of_hdf5(path) if newer else _flat("", io.loadmat(str(path), simplify_cells=True)))
    except Exception as error:  # On damaged files SciPy and HDF5 raise nearly every type there is.
        raise FormatError(f"is no whole MATLAB file: {error}", where=str(path), remedy=_AGAIN) from error


def _flat(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, NDArray[Any]]]:
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, dict):
            yield from _flat(f"{prefix}{name}.", value)
        elif isinstance(value, list | np.ndarray) and len(value) and all(isinstance(one, dict) for one in value):
            for k, one in enumerate(value, start=1):
                yield from _flat(f"{prefix}{name}({k}).", one)
        elif (array := np.asarray(value)).dtype.kind in "fiuc":
            yield f"{prefix}{name}", array


def _of_hdf5(path: Path) -> Iterator[tuple[str, NDArray[Any]]]:
    found: dict[str, NDArray[Any]] = {}

    def look(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("#") and "MATLAB_empty" not in item.attrs:
            values = item[()]
            if values.dtype.names == ("real", "imag"):
                values = values["real"] + 1j * values["imag"]
            if values.dtype.kind in "fiuc" and item.attrs.get("MATLAB_class", b"double") not in (b"char", b"cell"):
                # MATLAB stores columns first, HDF5 rows.
                found[name.replace("/", ".")] = np.squeeze(values.T)

    with h5py.File(path, "r") as source:
        source.visititems(look)
    yield from found.items()
