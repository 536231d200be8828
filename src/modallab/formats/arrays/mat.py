"""MATLAB files: versions 4 and 5 by SciPy, version 7.3, which is HDF5, by h5py."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy import io

from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.arrays.array_map import without_singleton_axes
from modallab.formats.arrays.named import Arrays, Texts
from modallab.formats.arrays.variables import campaign_of_variables, rig_of_variables
from modallab.formats.options import ImportOptions

Variable = NDArray[Any] | tuple[str, ...] | str
"""Numbers, the rows of a text, or the class of an object such as a timetable."""
MARKS = (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file")
_OF_OBJECT = "save numbers, as t = seconds(x.Time) and y = x.Variables of a timetable x"
_AGAIN = "save it again in MATLAB: save('file.mat', '-v7') or '-v7.3'"


def read_mat(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record, or one matrix of FRFs, from the variables of a MATLAB file.

    Fields of a structure are called structure.field. Numbers are in the rig's units, or volts if the options say so.

    Raises:
        FormatError: no whole MATLAB file.
        DataError: variables that are missing or do not fit.
    """
    return campaign_of_variables(*_variables(path), path, rig, options)


def draft_mat(path: Path, options: ImportOptions) -> Rig:
    """The rig that a MATLAB file's records or FRFs were made on, as far as its variables or the map say.

    Raises:
        FormatError: no whole MATLAB file.
        DataError: what a variable is cannot be known.
    """
    return rig_of_variables(*_variables(path), path, options)


def _variables(path: Path) -> tuple[Arrays, Texts]:
    """The arrays of numbers, and the variables of text with a string for each row or cell."""
    with path.open("rb") as source:
        newer = source.read(len(MARKS[1])) == MARKS[1]
    try:
        held = dict(_of_hdf5(path) if newer else _of_scipy(path))
    except Exception as error:  # On damaged files SciPy and HDF5 raise nearly every type there is.
        raise FormatError(f"is no whole MATLAB file: {error}", where=str(path), remedy=_AGAIN) from error
    texts = {name: value for name, value in held.items() if isinstance(value, tuple)}
    arrays = {name: value for name, value in held.items() if isinstance(value, np.ndarray)}
    objects = [f"{name} ({value})" for name, value in held.items() if isinstance(value, str)]
    if objects and not arrays:
        raise DataError(
            f"holds objects that only MATLAB reads: {', '.join(objects)}", where=str(path), remedy=_OF_OBJECT
        )
    return arrays, texts


def _of_scipy(path: Path) -> Iterator[tuple[str, Variable]]:
    """SciPy drops axes of one element, which say whose FRFs there are; they are put back."""
    shapes = {name: shape for name, shape, _ in io.whosmat(str(path))}
    for name, value in _flat("", io.loadmat(str(path), simplify_cells=True)):
        if isinstance(value, np.ndarray) and value.size == np.prod(shapes.get(name, (0,))):
            value = without_singleton_axes(value.reshape(shapes[name]))
        yield name, value


def _flat(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, Variable]]:
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, dict):
            yield from _flat(f"{prefix}{name}.", value)
        elif isinstance(value, list | np.ndarray) and len(value) and all(isinstance(one, dict) for one in value):
            for k, one in enumerate(value, start=1):
                yield from _flat(f"{prefix}{name}({k}).", one)
        elif _is_cell(value):
            yield from _flat(prefix, {f"{name}({k})": one for k, one in enumerate(value, start=1)})
        elif texts := _texts(value):
            yield f"{prefix}{name}", texts
        elif isinstance(value, io.matlab.MatlabOpaque):
            yield f"{prefix}{name}", "object"
        elif (array := np.asarray(value)).dtype.kind in "fiuc":
            yield f"{prefix}{name}", array


def _is_cell(value: object) -> bool:
    """Whether a cell holds arrays."""
    cells = value if isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object) else ()
    return len(cells) > 0 and all(isinstance(one, np.ndarray) for one in cells)


def _texts(value: object) -> tuple[str, ...]:
    """The strings of a cell or of an array of characters; () if it holds something else."""
    cells = [value] if isinstance(value, str) else list(np.ravel(np.asarray(value, object)))
    return tuple(str(cell).strip() for cell in cells) if all(isinstance(cell, str) for cell in cells) else ()


def _of_hdf5(path: Path) -> Iterator[tuple[str, Variable]]:
    with h5py.File(path, "r") as source:
        yield from _of_group("", source)


def _of_group(prefix: str, group: Mapping[str, h5py.Dataset | h5py.Group]) -> Iterator[tuple[str, Variable]]:
    for key, item in group.items():
        if key.startswith("#"):
            continue
        if isinstance(item, h5py.Group):
            yield from _of_group(f"{prefix}{key}.", item)
        elif item.dtype == h5py.ref_dtype and not _hdf5_texts(item):
            # A field of an array of structures, and a cell, hold a reference for each of them.
            for k, one in enumerate(np.ravel(item[()].T), start=1):
                at = (f"{prefix}", f"{key}({k})") if _class_of(item) else (f"{prefix.removesuffix('.')}({k}).", key)
                yield from _of_group(at[0], {at[1]: item.file[one]})
        else:
            yield from _of_dataset(f"{prefix}{key}", item)


def _of_dataset(name: str, item: h5py.Dataset) -> Iterator[tuple[str, Variable]]:
    if "MATLAB_empty" in item.attrs:
        return
    if "MATLAB_object_decode" in item.attrs:
        yield name, _class_of(item).decode()
        return
    values = item[()]
    if text := _hdf5_texts(item):
        yield name, text
    if values.dtype.names == ("real", "imag"):
        values = values["real"] + 1j * values["imag"]
    if values.dtype.kind in "fiuc" and _class_of(item) not in (b"char", b"cell"):
        # MATLAB stores columns first, HDF5 rows.
        yield name, without_singleton_axes(values.T)


def _class_of(item: h5py.Dataset) -> bytes:
    return bytes(item.attrs.get("MATLAB_class", b""))


def _hdf5_texts(item: h5py.Dataset) -> tuple[str, ...]:
    """The strings of a cell, whose elements HDF5 holds by reference, or of an array of characters; () else."""
    kind, values = item.attrs.get("MATLAB_class", b""), item[()]
    if kind == b"char":
        return tuple("".join(map(chr, row)).strip() for row in np.atleast_2d(values.T))
    if kind != b"cell" or values.dtype.kind != "O":
        return ()
    parts = [_hdf5_texts(item.file[reference]) for reference in np.ravel(values.T)]
    return tuple(part[0] for part in parts) if all(len(part) == 1 for part in parts) else ()
