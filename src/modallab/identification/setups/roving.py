"""Each point of a roving test as a set-up of its own: its poles, and what it shares with the others.

A hammer or a sensor that goes from point to point changes the structure a little each time. The side of the FRF matrix
that is larger is the one that roved; the other side's channels are common to all points. What a mode does at the common
channels is its signature: however its pole moves, its signature stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.identification.estimate import estimate_poles
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import fit_frf

STEPS = 8
"""Of a point's search, which begins close to its end."""


def roved_axis(frf: Frf) -> int:
    """0 where the outputs roved, 1 where the inputs did."""
    return 0 if frf.values.shape[0] >= frf.values.shape[1] else 1


def frf_of_point(frf: Frf, k: int) -> Frf:
    """The FRFs of one roving point."""
    rows, columns = (slice(k, k + 1), slice(None)) if roved_axis(frf) == 0 else (slice(None), slice(k, k + 1))

    def at(values: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        return None if values is None else np.ascontiguousarray(values[rows, columns])

    frf = replace(frf, coherence=at(frf.coherence), variance=at(frf.variance), averages=frf.averages[columns])
    if roved_axis(frf) == 0:
        return replace(
            frf,
            values=frf.values[k : k + 1],
            outputs=frf.outputs[k : k + 1],
            output_points=frf.output_points[k : k + 1],
        )
    return replace(frf, values=np.ascontiguousarray(frf.values[:, k : k + 1]), input_points=frf.input_points[k : k + 1])


def point_name(frf: Frf, k: int) -> str:
    """What a roving point is called."""
    point = (frf.output_points, frf.input_points)[roved_axis(frf)][k]
    return f"point {point}" if point is not None else frf.outputs[k] if roved_axis(frf) == 0 else f"input {k + 1}"


@dataclass(frozen=True, eq=False, slots=True)
class ModesOfPoint:
    """Poles that points found by themselves.

    Attributes:
        point: (seen,) which point.
        pole: (seen,) rad/s.
        signature: (seen, common channels) modal constants, of norm 1.
    """

    point: NDArray[np.int64]
    pole: Complex128
    signature: Complex128


def modes_of_each_point(frf: Frf, points: Sequence[int], method: str, order: int, significance: float) -> ModesOfPoint:
    """What each of these points finds by itself, whatever the others say.

    Args:
        frf: all FRFs.
        points: which to ask.
        method: the estimator.
        order: its highest order at one point.
        significance: sigmas that a pole's loudest modal constant stands above.
    """
    which: list[int] = []
    poles: list[complex] = []
    signatures: list[Complex128] = []
    for k in points:
        here = frf_of_point(frf, k)
        try:
            found = estimate_poles(here, method, order).poles
            fit = fit_frf(here, found, 0) if found.size else None
        except IdentificationError:
            continue
        if fit is None:
            continue
        constants, sigma = (v[: found.size].reshape(found.size, -1) for v in fit.modal_constants)
        for r in np.flatnonzero(np.max(np.abs(constants) / np.maximum(np.abs(sigma), 1e-300), axis=1) > significance):
            which.append(k)
            poles.append(complex(found[r]))
            signatures.append(constants[r] / np.linalg.norm(constants[r]))
    common = min(frf.values.shape[:2])
    return ModesOfPoint(
        np.array(which, np.int64), np.array(poles, np.complex128), np.array(signatures).reshape(-1, common)
    )


@dataclass(frozen=True, eq=False, slots=True)
class PointPoles:
    """Every point's own poles, with what the point itself knows of them.

    Attributes:
        values: (points, modes, 2) omega in rad/s and zeta, by the point's data alone.
        variance: (points, modes, 2) of them; inf where the point does not see the mode.
        fits: (points,) each with its poles drawn to the common ones where it does not know better.
    """

    values: Real
    variance: Real
    fits: tuple[LikelihoodFit, ...]


def poles_at_points(frf: Frf, centre: Real, spread: Real, stand_ins: tuple[float, ...]) -> PointPoles:
    """The poles of every point, free to move from the common ones by as much as the points scatter.

    Args:
        frf: all FRFs.
        centre: (modes, 2) common omega and zeta.
        spread: (modes, 2) standard deviation of a point's about them.
        stand_ins: multiples of the upper edge where the poles stand that all points have for the modes above.

    Raises:
        IdentificationError: poles that cannot be distinguished in a point's lines.
    """
    n_points = frf.values.shape[roved_axis(frf)]
    priors = np.stack([centre, spread], axis=-1)
    start = -centre[:, 1] * centre[:, 0] + 1j * centre[:, 0]
    fits = tuple(fit_frf(frf_of_point(frf, k), start, STEPS, priors, stand_ins) for k in range(n_points))
    at = np.array([np.stack([f.point.parameters.omega, f.point.parameters.zeta], axis=1) for f in fits])
    at, posterior = at[:, : len(centre)], np.array([f.pole_sigma[: len(centre)] ** 2 for f in fits])
    # What the prior said is taken off again: it is the same for all points, and would count as often as there are any.
    known = np.maximum(1 / posterior - 1 / spread**2, 0.0)
    sees = known > 0.05 / spread**2
    safe = np.where(sees, known, 1.0)
    values = np.where(sees, (at / posterior - centre / spread**2) / safe, centre)
    return PointPoles(values, np.where(sees, 1 / safe, np.inf), fits)
