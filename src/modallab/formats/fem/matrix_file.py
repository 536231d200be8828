"""Matrices of files: Matrix Market, NumPy, SciPy's sparse ones, MATLAB version 5 and 7.3."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np
from scipy import io, sparse

from modallab.core.errors import DataError, FormatError

READ = (".mtx", ".npz", ".npy", ".mat")


def read_matrix(path: Path, names: Sequence[str]) -> Any:
    """A matrix of a file, sparse where the file has it so.

    Args:
        path: one of `READ`; a file of Matrix Market or NumPy's .npy holds one matrix.
        names: under which it may stand in a file that holds several.

    Raises:
        FormatError: the file cannot be read.
        DataError: it holds none of these names.
    """
    try:
        if path.suffix == ".mtx":
            return io.mmread(str(path))
        if path.suffix == ".npy":
            return np.load(path, allow_pickle=False)
        held = _mat(path) if path.suffix == ".mat" else _npz(path)
    except Exception as error:  # On damaged files NumPy, SciPy and HDF5 raise nearly every type there is.
        raise FormatError(f"holds no matrices: {error}", where=str(path), remedy="write it again") from error
    if len(held) == 1 and names:
        return next(iter(held.values()))
    for name in names:
        if name in held:
            return held[name]
    raise DataError(
        f"holds no {' or '.join(names)}, but {', '.join(sorted(held)) or 'nothing'}",
        where=str(path),
        remedy="call the matrices K and M",
    )


def holds(path: Path, names: Sequence[str]) -> bool:
    """Whether a file of several arrays holds one of these names."""
    if path.suffix not in (".npz", ".mat"):
        return False
    held = _mat(path) if path.suffix == ".mat" else _npz(path)
    return any(name in held for name in names)


def _npz(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as content:
        names = set(content.files)
        if {"format", "shape", "data"} <= names:
            return {"": sparse.load_npz(path)}
        return {name: content[name] for name in names}


def _mat(path: Path) -> dict[str, Any]:
    with path.open("rb") as source:
        newer = source.read(19) == b"MATLAB 7.3 MAT-file"
    if not newer:
        return {name: value for name, value in io.loadmat(str(path)).items() if not name.startswith("__")}
    with h5py.File(path, "r") as content:
        return {name: _of_hdf5(item) for name, item in content.items() if not name.startswith("#")}


def _of_hdf5(item: Any) -> Any:
    if isinstance(item, h5py.Group):
        # A sparse matrix, column by column: where each begins, rows, values.
        rows = int(cast("Any", item.attrs["MATLAB_sparse"]))
        starts, found, values = (np.asarray(item[name]).ravel() for name in ("jc", "ir", "data"))
        return sparse.csc_array((values, found, starts), shape=(rows, starts.size - 1))
    return np.asarray(item).T
