"""Repeated roots: one pole whose modal constants are those of several modes at once.

Modes of equal frequency and damping have one pole, and their modal constants add up to a matrix of as many ranks. Seen
from one force it is one mode. From several forces its rank shows how many modes there are; their shapes are known as a
plane, in which any two that span it will do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from modallab.core.arrays import Complex128, Real
from modallab.identification.model.modal_mass import check_constants

SIGMAS = 5.0
"""A second rank stands above what noise alone gives by this many sigmas."""
SHARE = 0.02
"""And is this share of the first at least: less is the residual of the model of the pole."""
MORE = 2.0
"""And so many times what misfit and scatter can produce, and, where sensors stand at two driven points or more, what is
not reciprocal there."""
OUT_OF_PHASE = 0.4
"""Share of a further rank that may be in quadrature to the first (23 degrees): poles that differ from set-up to set-up,
and what neighbours leave, are as much out of phase as in phase; the shapes of modes are not."""
FEWEST, TENTH = 3.0, 0.1
"""A further rank lives on at least this many points, or this share of them where there are few: what one or two points
misread of a strong mode has a rank of its own as well."""
ALIKE = 1e3
"""Condition from which the driven points move alike in all modes of a pole, which leaves the plane's division open."""


@dataclass(frozen=True, eq=False, slots=True)
class SplitConstants:
    """Modal constants with repeated roots split up.

    Attributes:
        pole: (modes,) which pole each mode has, ascending.
        constants: (modes, outputs, inputs), each of one rank where it was split.
        sigma: (modes, outputs, inputs) of the constants; of a split one, that of the sum.
    """

    pole: NDArray[np.int64]
    constants: Complex128
    sigma: Real


def split_repeated(
    constants: Complex128,
    sigma: Real,
    output_points: Sequence[int | None],
    input_points: Sequence[int | None],
    apparent: Real | None = None,
) -> SplitConstants:
    """Each pole's modal constants as those of one mode, or of several if their rank is higher.

    An error of the model raises the rank too, but is not what modes are: in phase or opposite, as the first rank is but
    for its own complexity, on several points, and reciprocal, with positive constants at the driving points. Only such
    a rank counts, the last of these where sensors stand at two driven points or more.

    Where sensors stand at as many driven points, the parts are reciprocal, A_k = phi_k phi_k^T at the driven points,
    with phi_k orthogonal to one another; else they are the terms of a singular value decomposition.

    Args:
        constants: (poles, outputs, inputs) kg^-1.
        sigma: (poles, outputs, inputs) of the complex numbers.
        output_points: point of each output.
        input_points: point of each input.
        apparent: (poles,) share of the first rank that misfit and scatter between set-ups can pass off as a second.

    Raises:
        DataError: constants that are not finite, or do not fit sigma or points.
    """
    check_constants(constants, sigma, output_points, input_points)
    pole: list[int] = []
    parts: list[Complex128] = []
    for r, (a, s) in enumerate(zip(constants, sigma, strict=True)):
        driven = _driven_pairs(output_points, input_points)
        share = SHARE if apparent is None else max(SHARE, MORE * float(apparent[r]))
        rank = _reciprocal_rank(a, _rank_above_noise(a, s, share), driven)
        found = [a] if rank == 1 else _rank_one_parts(a, rank, driven)
        pole += [r] * len(found)
        parts += found
    index = np.array(pole, dtype=np.int64)
    return SplitConstants(index, np.array(parts).reshape(-1, *constants.shape[1:]), sigma[index])


def _rank_above_noise(a: Complex128, sigma: Real, share: float) -> int:
    """How many singular values stand above noise, whose largest is about sigma (sqrt(rows) + sqrt(columns))."""
    if min(a.shape) < 2 or not np.isfinite(sigma).all():
        return 1
    u, values, vh = np.linalg.svd(a, full_matrices=False)
    each = float(np.sqrt(np.mean(sigma**2)))
    noise = each * (np.sqrt(a.shape[0]) + np.sqrt(a.shape[1]) + SIGMAS)
    rank = max(1, int(np.sum((values > noise) & (values > share * values[0]))))
    # The first that is no mode is misfit: no mode stands out that is not clear of it.
    while rank > 1 and values[rank - 1] < MORE * np.append(values, 0.0)[rank]:
        rank -= 1
    parts = u.T[:rank, :, None] * values[:rank, None, None] * vh[:rank, None]
    # Noise turns about as many numbers of a part as the matrix has rows and columns, half of it in quadrature.
    by_noise = MORE * each**2 * sum(a.shape) / 2
    return 1 + min(_parts_in_phase(parts, by_noise), _parts_on_many_points(parts))


def _parts_on_many_points(parts: Complex128) -> int:
    """How many of the parts after the first live on several points, up to the first that does not."""
    # The side on which there are more points; participation is 1 for a single one and their number for all alike.
    longer = 2 if parts.shape[1] >= parts.shape[2] else 1
    square = np.sum(np.abs(parts[1:]) ** 2, axis=longer)
    points = square.sum(axis=1) ** 2 / np.sum(square**2, axis=1)
    kept = points >= min(FEWEST, TENTH * square.shape[1])
    return int(kept.size if kept.all() else np.argmin(kept))


def _parts_in_phase(parts: Complex128, by_noise: float) -> int:
    """How many of the parts after the first are modes by their phases, up to the first that is not."""
    first = parts[0]
    turned = parts * np.exp(-0.5j * np.angle(np.sum(first**2)))
    off = np.sum(turned.imag**2, axis=(1, 2))
    power = np.sum(np.abs(parts) ** 2, axis=(1, 2))
    # A structure whose modes are complex may have others that are.
    allowed = max(OUT_OF_PHASE**2, MORE**2 * off[0] / power[0])
    kept = off[1:] <= allowed * power[1:] + by_noise
    return int(kept.size if kept.all() else np.argmin(kept))


def _reciprocal_rank(a: Complex128, rank: int, driven: list[tuple[int, int]]) -> int:
    """As many of them as positive eigenvalues stand clear of what is not reciprocal among the driven points."""
    if rank == 1 or len(driven) < 2:
        return rank
    at = a[[o for o, _ in driven]][:, [k for _, k in driven]]
    values = np.linalg.eigvalsh((at.real + at.real.T) / 2)
    # Sensors that all look the other way turn every sign.
    values = values * np.sign(values[np.argmax(np.abs(values))])
    odd = float(np.linalg.norm(at - at.T, 2)) / 2
    return max(1, min(rank, int(np.sum(values > max(MORE * odd, 1e-9 * values.max())))))


def _driven_pairs(output_points: Sequence[int | None], input_points: Sequence[int | None]) -> list[tuple[int, int]]:
    """(output, input) at each driven point that has a sensor."""
    outputs = list(output_points)
    return [(outputs.index(p), k) for k, p in enumerate(input_points) if p is not None and p in outputs]


def _rank_one_parts(a: Complex128, rank: int, driven: list[tuple[int, int]]) -> list[Complex128]:
    u, values, vh = np.linalg.svd(a, full_matrices=False)
    u, right = u[:, :rank], values[:rank, None] * vh[:rank]
    mix = _make_reciprocal(u, right, driven)
    left = u if mix is None else u @ mix
    forces = right if mix is None else np.linalg.solve(mix, right)
    return [np.asarray(np.outer(left[:, k], forces[k]), np.complex128) for k in range(rank)]


def _make_reciprocal(u: Complex128, right: Complex128, driven: list[tuple[int, int]]) -> Complex128 | None:
    """X with (U X) and (X^-1 right)^T the same at the driven points: X X^T = G, G from U_d G = right_d^T."""
    if len(driven) < u.shape[1]:
        return None
    at = u[[o for o, _ in driven]]
    if np.linalg.cond(at) > ALIKE:
        return None
    found = np.asarray(np.linalg.lstsq(at, right[:, [k for _, k in driven]].T, rcond=None)[0], np.complex128)
    root: NDArray[Any] = linalg.sqrtm((found + found.T) / 2)
    shapes = u @ root
    # Turned by a real rotation the product stays what it is, and the shapes become orthogonal.
    _, turn = np.linalg.eigh(np.real(shapes.conj().T @ shapes))
    mix = np.asarray(root @ turn[:, ::-1], np.complex128)
    return mix if np.isfinite(mix).all() and np.linalg.cond(mix) < ALIKE else None
