"""Modes of mass and stiffness matrices, whatever program assembled them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.formats.fem.node_modes import NodeModes

Whole = NDArray[np.int64]

MOST = 60
"""Modes that are computed."""
SMALL = 800
"""Rows up to which all modes are computed at once."""
BELOW = 1e-6
"""A shift below zero, over the mean ratio of the diagonals: a free structure's stiffness has no inverse."""
UNEVEN = 1e-6
"""Relative difference from the transpose from which a matrix is not symmetric."""


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
        if n <= SMALL:
            last = min(MOST, n) - 1
            squares, vectors = eigh(k.toarray(), m.toarray(), subset_by_index=(0, last))
        else:
            shift = -BELOW * float(np.mean(k.diagonal()) / np.mean(m.diagonal()))
            squares, vectors = eigsh(k, MOST, m, sigma=shift)
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
    if abs(found - found.T).max() > UNEVEN * size:
        raise DataError(f"the {what} matrix is not symmetric", where=title, remedy="give a conservative structure's")
    return found
