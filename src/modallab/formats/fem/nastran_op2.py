"""Real eigenvectors in Nastran's binary results (.op2), as pyYeti reads them.

Sources: MSC Nastran DMAP Programmer's Guide, data blocks OUG, LAMA, BGPDT; pyYeti (BSD-3), `pyyeti.nastran.op2`.
Eigenvectors are divided by the root of the modal mass where the file says it (LAMA), else taken at unit modal mass, as
the EIGRL entry has them unless it says otherwise.
"""

import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.discovery import require_package
from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.formats.fem.nastran import read_grids
from modallab.formats.modes import NodeModes

VECTORS = ("OUGV1", "BOUGV1", "OUG1", "BOPHIG", "OPHIG")
"""Names that Nastrans give the table of eigenvectors."""
PACKAGE = "pyyeti"
WORD = 4
"""Bytes of a word. Files of eight are read by pyYeti as if they were of four."""
MODAL_MASS = 5
"""Column of LAMA."""
_DO = "write eigenvectors into it: DISPLACEMENT(PLOT) = ALL with PARAM,POST,-1 in SOL 103, or print them (.f06)"

Places = dict[int, tuple[float, float, float]]


def read_op2(path: Path) -> NodeModes:
    """Modes of a binary result file; grid points from the file, else from the model beside it, if there is one.

    Raises:
        MissingPackageError: pyYeti is not installed.
        FormatError: it is no such file, is damaged, or has words of eight bytes.
        DataError: it holds no real eigenvectors, those of several subcases, or in other coordinate systems than the
            basic one.
    """
    _require_words_of_four(path)
    package = _reader()
    try:
        # Of tables that are no eigenvectors it warns; what there is of them is said below.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            vectors, params = _tables(package, path)
    except ModallabError:
        raise
    except Exception as error:  # pyYeti has no error of its own: what is damaged dies of what it meets first
        why = f"is damaged: {error}"
        raise FormatError(why, where=str(path), remedy="write it again, or print it (.f06)") from error
    if vectors is None:
        raise DataError("holds no real eigenvectors", where=str(path), remedy=_DO)
    hz = np.array([float(f) for _, f in vectors.columns])
    if np.any(np.diff(hz) < -1e-6 * hz[:-1] - 1e-3):
        raise DataError(
            "holds eigenvectors of several subcases", where=str(path), remedy="compute one, or print them (.f06)"
        )
    scale = 1 / np.sqrt(_masses(params, hz.size))
    places = _places(params, path) or read_grids(path)
    return NodeModes(path.stem, hz, _motions(vectors, scale), places, np.full(hz.size, np.nan))


def _reader() -> Any:
    require_package(PACKAGE, "a Nastran .op2 file")
    # pyYeti sets how NumPy prints, of the whole process.
    with np.printoptions():
        return import_module(f"{PACKAGE}.nastran.op2")


def _require_words_of_four(path: Path) -> None:
    try:
        with path.open("rb") as source:
            first = source.read(WORD)
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror}", where=str(path), remedy="name an .op2 file") from error
    # The first record is a key: one word.
    size = {int.from_bytes(first, order) for order in ("little", "big")}
    if WORD not in size:
        what = "has words of eight bytes" if 2 * WORD in size else "is no .op2 file"
        raise FormatError(
            what, where=str(path), remedy="print the eigenvectors (.f06), or punch them (.pch), and name that file"
        )


def _tables(package: Any, path: Path) -> tuple[Any, dict[str, Any]]:
    """The table of eigenvectors, a row a freedom and a column a mode, None without one; and what belongs to it."""
    with package.OP2(str(path)) as source:
        there = [name for name in VECTORS if name in source.dbnames]
    vectors = None
    for name in there:
        with package.OP2(str(path)) as source:
            vectors = source.rdop2oug(name)
        if vectors is not None:
            break
    with package.OP2(str(path)) as source:
        try:
            params: dict[str, Any] = source.rdparampost(get_mats=False, get_dr_tables=False)
        except ValueError:
            # Of a part of a model, whose grid points are elsewhere.
            params = {}
    return vectors, params


def _masses(params: dict[str, Any], modes: int) -> Real:
    lama = params.get("lama")
    if lama is None or len(lama) != modes:
        return np.ones(modes)
    masses = np.asarray(lama, np.float64)[:, MODAL_MASS]
    return np.where(masses > 0, masses, 1.0)


def _motions(vectors: Any, scale: Real) -> dict[int, Real]:
    """Node -> (modes, 3), of grid points: a scalar point has one freedom, and no direction."""
    nodes, freedoms = (np.asarray(vectors.index.get_level_values(n)) for n in (0, 1))
    rows = np.asarray(vectors, np.float64) * scale
    first = np.flatnonzero(freedoms == 1)
    grids = [n for n in first if n + 2 < len(nodes) and nodes[n + 2] == nodes[n]]
    return {int(nodes[n]): rows[n : n + 3].T for n in grids}


def _places(params: dict[str, Any], path: Path) -> Places:
    table = params.get("uset")
    if table is None:
        return {}
    nodes, freedoms = (np.asarray(table.index.get_level_values(n)) for n in (0, 1))
    rows = np.asarray(table[["x", "y", "z"]], np.float64)
    systems = rows[freedoms == 2, 0]
    if np.any(systems != 0):
        odd = int(nodes[freedoms == 2][systems != 0][0])
        raise DataError(
            f"grid point {odd} moves along the axes of coordinate system {int(systems[systems != 0][0])}",
            where=str(path),
            remedy="give displacements in the basic system: leave the CD field of GRID entries empty",
        )
    at = freedoms == 1
    return {int(n): (float(x), float(y), float(z)) for n, (x, y, z) in zip(nodes[at], rows[at], strict=True)}
