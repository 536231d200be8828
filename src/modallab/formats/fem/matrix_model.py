"""A finite-element model as matrices: what its parameters change of them, their modes, and files that hold such."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy import io, sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from modallab.core.arrays import Real
from modallab.core.errors import DataError, FormatError
from modallab.formats.modes import NodeModes, Units, in_si

Whole = NDArray[np.int64]

DIRECTIONS = {"x": 1, "y": 2, "z": 3, "rx": 4, "ry": 5, "rz": 6}
STIFFNESS, MASS = "stiffness", "mass"
"""Factors on the whole matrices, which every model has."""
_MOST = 60
"""Modes that are computed."""
_SMALL = 800
"""Rows up to which all modes are computed at once."""
_BELOW = 1e-6
"""A shift below zero, over the mean ratio of the diagonals: a free structure's stiffness has no inverse."""
_UNEVEN = 1e-6
"""Relative difference from the transpose from which a matrix is not symmetric."""
READ = (".mtx", ".npz", ".npy", ".mat")


@dataclass(frozen=True, eq=False, slots=True)
class MatrixModel:
    """K = stiffness K0 + sum of p K_p and M likewise, of parameters p by name.

    Attributes:
        stiffness: (n, n) K0, dense or sparse; N/m in the units of the model.
        mass: (n, n) M0.
        freedoms: (n,) node and direction of each row: x, y, z, rx, ry, rz or 1 to 6.
        stiffness_slopes: parameter -> (n, n) what one unit of it adds to K.
        mass_slopes: parameter -> (n, n) what one unit of it adds to M.
        places: node -> x, y and z in the unit of the model; empty where nodes have the numbers of points.
        points: node of a point of the rig, where numbers and places do not say it.
        units: of length; mm goes with tonnes.
        title: what it is of.
    """

    stiffness: Any
    mass: Any
    freedoms: Sequence[tuple[int, str | int]]
    stiffness_slopes: Mapping[str, Any] = field(default_factory=dict[str, Any])
    mass_slopes: Mapping[str, Any] = field(default_factory=dict[str, Any])
    places: Mapping[int, tuple[float, float, float]] = field(default_factory=dict[int, tuple[float, float, float]])
    points: Mapping[int, int] = field(default_factory=dict[int, int])
    units: Units = "m"
    title: str = "matrices"

    def __post_init__(self) -> None:
        """Take the matrices as whole ones, once.

        Raises:
            DataError: one is not square, not finite, zero or not symmetric, or a parameter's has another size.
        """
        for name in ("stiffness", "mass"):
            whole = symmetric(getattr(self, name), name, self.title)
            by = {n: symmetric(a, n, self.title) for n, a in getattr(self, f"{name}_slopes").items()}
            for n, matrix in by.items():
                if matrix.shape != whole.shape:
                    raise DataError(
                        f"the matrix of {n} is {matrix.shape}, the {name} {whole.shape}",
                        where=self.title,
                        remedy="give all matrices over the same freedoms",
                    )
            object.__setattr__(self, name, whole)
            object.__setattr__(self, f"{name}_slopes", by)

    @property
    def names(self) -> tuple[str, ...]:
        """Of its parameters."""
        return tuple(dict.fromkeys((STIFFNESS, MASS, *self.stiffness_slopes, *self.mass_slopes)))

    def modes(self, numbers: Mapping[str, float]) -> NodeModes:
        """The lowest modes, in SI units.

        Args:
            numbers: parameter -> its value; the factors `stiffness` and `mass` are 1 if left out, all others 0.

        Raises:
            DataError: no such parameter, or matrices that do not belong together.
        """
        unknown = [name for name in numbers if name not in self.names]
        if unknown:
            raise DataError(
                f"the model has no parameter {unknown[0]!r}", where=self.title, remedy=f"use {', '.join(self.names)}"
            )
        k = _sum(self.stiffness, numbers.get(STIFFNESS, 1.0), self.stiffness_slopes, numbers)
        m = _sum(self.mass, numbers.get(MASS, 1.0), self.mass_slopes, numbers)
        return in_si(modes_of(k, m, self._rows, dict(self.places), self.title), self.units)

    @property
    def _rows(self) -> Whole:
        rows = [(node, DIRECTIONS.get(str(direction), direction)) for node, direction in self.freedoms]
        return np.array(rows, np.int64).reshape(-1, 2)


def _sum(whole: Any, factor: float, by: Mapping[str, Any], numbers: Mapping[str, float]) -> Any:
    return sum((numbers.get(name, 0.0) * matrix for name, matrix in by.items()), factor * whole)


def modes_of(k: Any, m: Any, freedoms: Whole, places_m: dict[int, tuple[float, float, float]], title: str) -> NodeModes:
    """The lowest modes.

    Args:
        k: (n, n) stiffness in the units of the model, sparse, known to be symmetric.
        m: (n, n) mass, likewise.
        freedoms: (n, 2) node and direction of each row: 1, 2, 3 along x, y, z; 4 to 6 about them.
        places_m: node -> where it is, in the unit of the model; may be empty.
        title: what they are of.

    Raises:
        DataError: sizes that do not fit, or matrices that are no mass and stiffness.
    """
    n = k.shape[0]
    if m.shape != k.shape or freedoms.shape != (n, 2):
        raise DataError(
            f"stiffness {k.shape}, mass {m.shape} and {len(freedoms)} freedoms do not belong together",
            where=title,
            remedy="give a row of freedoms (node, direction) for each row of the matrices",
        )
    squares, vectors = _solved(k, m, title)
    at: dict[int, Real] = {}
    for row, (node, direction) in enumerate(freedoms.tolist()):
        if 1 <= direction <= 3:
            at.setdefault(node, np.zeros((squares.size, 3)))[:, direction - 1] = vectors[row]
    hz = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
    return NodeModes(title, hz, at, places_m, np.full(hz.size, np.nan))


def _solved(k: Any, m: Any, title: str) -> tuple[Real, Real]:
    """(modes,) eigenvalues and (rows, modes) vectors at unit modal mass."""
    n = k.shape[0]
    try:
        if n <= _SMALL:
            last = min(_MOST, n) - 1
            squares, vectors = eigh(k.toarray(), m.toarray(), subset_by_index=(0, last))
        else:
            shift = -_BELOW * float(np.mean(k.diagonal()) / np.mean(m.diagonal()))
            squares, vectors = eigsh(k, _MOST, m, sigma=shift)
    except (np.linalg.LinAlgError, RuntimeError) as error:
        raise DataError(
            f"its modes cannot be computed: {error}",
            where=title,
            remedy="the mass must be positive for every motion: leave out rows without mass, or condense them",
        ) from error
    order = np.argsort(squares)
    vectors = vectors[:, order]
    return squares[order], vectors / np.sqrt(np.sum(vectors * (m @ vectors), axis=0))


def symmetric(matrix: Any, what: str, title: str) -> Any:
    """A matrix as a sparse one, whole where one triangle alone was given.

    Raises:
        DataError: it is zero, not square, not finite or not symmetric.
    """
    try:
        given: Any = matrix if sparse.issparse(matrix) else np.array(matrix, np.float64)
        found = sparse.csc_array(given)
    except (TypeError, ValueError) as error:
        raise DataError(f"the {what} matrix is none: {error}", where=title, remedy="give rows of numbers") from error
    size = abs(found).max() if found.nnz else 0.0
    if found.ndim != 2 or found.shape[0] != found.shape[1] or not size:
        raise DataError(f"the {what} matrix is {found.shape}, or zero", where=title, remedy="give a square matrix")
    if not np.isfinite(found.data).all():
        raise DataError(f"the {what} matrix holds NaN or infinite values", where=title, remedy="write it again")
    half = sparse.triu(found, 1).nnz == 0 or sparse.tril(found, -1).nnz == 0
    if half and found.nnz > found.shape[0]:
        # One triangle alone stands for both, as programs write symmetric matrices.
        return sparse.csc_array(found + found.T - sparse.diags_array(found.diagonal()))
    if abs(found - found.T).max() > _UNEVEN * size:
        raise DataError(f"the {what} matrix is not symmetric", where=title, remedy="give a conservative structure's")
    return found


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
