"""A refined fit, its modal constants with their covariance, and what it says of each block."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.basis import DerivativeVectors, columns_of_block, poles_of
from modallab.identification.likelihood.excitation import Excitation
from modallab.identification.likelihood.force_noise import force_parts
from modallab.identification.likelihood.orthonormal import complex_lines
from modallab.identification.likelihood.projection import (
    InputSolution,
    LikelihoodPoint,
    LikelihoodProblem,
    true_excitation,
)
from modallab.identification.likelihood.search import SearchEnd


@dataclass(frozen=True, eq=False)
class LikelihoodFit:
    """The end of an identification, with what is needed to regenerate every block.

    `channels`, of a fit of FRFs, says how one group's outputs unfold into (outputs, inputs). `by_scatter` (modes, 2)
    are factors of the poles' sigmas, where what was measured says by its own scatter how well it is known.
    """

    problem: LikelihoodProblem
    refined: SearchEnd
    input_points: tuple[int | None, ...]
    channels: tuple[int, int] | None = None
    by_scatter: Real | None = None

    @property
    def point(self) -> LikelihoodPoint:
        """The model at its optimum."""
        return self.refined.point

    @property
    def pole_sigma(self) -> Real:
        """(modes, 2) sigma of omega (rad/s) and zeta."""
        own = np.sqrt(np.diag(self.refined.covariance.poles)).reshape(-1, 2)
        return own if self.by_scatter is None else own * self.by_scatter

    def inside(self, band_hz: tuple[float, float]) -> NDArray[np.bool_]:
        """(modes,) which poles lie within a band."""
        hz = self.point.parameters.omega / (2 * np.pi)
        return (hz > band_hz[0]) & (hz < band_hz[1])

    @cached_property
    def modal_constants(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Modal constants A = 2 j omega_d R and their sigma, each (modes, outputs, inputs).

        The receptance of a mode is R / (s - lambda) + conj(R) / (s - conj(lambda)): for a real A this is eq. 13 with
        viscous damping. The sigma of the real part stands in the real part, that of the imaginary part in the
        imaginary part; the absolute value is the sigma of the complex number. The two differ: a hit is known less
        well in its size than in its time.
        """
        return _modal_constants(self)

    def regenerated(self, block: int, excitation: Excitation) -> NDArray[np.complex128]:
        """The model's response (outputs, lines) in a block, at the lines of `excitation`'s grid."""
        at, problem = self.point.parameters, self.problem
        found = columns_of_block(
            true_excitation(problem, at, block, excitation),
            at.omega,
            at.zeta,
            None if problem.state_sigma is None else at.state[block],
            None if problem.drive_sigma is None else complex(at.drive[block]),
            problem.powers,
        )
        coefficients = self.point.groups[problem.blocks[block].group].coefficients
        return complex_lines(found.phi @ coefficients)


def _modal_constants(fit: LikelihoodFit) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    at = fit.point.parameters
    n = at.omega.size
    values: list[NDArray[np.complex128]] = []
    sigmas: list[NDArray[np.complex128]] = []
    for group, covariance in zip(fit.point.groups, fit.refined.covariance.inputs, strict=True):
        parts = group.coefficients[: 2 * n].reshape(n, 2, -1)
        values.append(parts[:, 0] + 1j * parts[:, 1])
        sigma = np.sqrt(_coefficient_variance(fit, group, covariance)[: 2 * n]).reshape(n, 2, -1)
        # A stands a quarter turn off R.
        sigmas.append(np.asarray(sigma[:, 1] + 1j * sigma[:, 0], dtype=np.complex128))
    scale = 2 * poles_of(at.omega, at.zeta).imag[:, None, None]
    found = (
        1j * scale * _unfold_channels(fit, np.stack(values, axis=-1)),
        scale * _unfold_channels(fit, np.stack(sigmas, axis=-1)),
    )
    return found[0].astype(np.complex128), found[1].astype(np.complex128)


def _unfold_channels(fit: LikelihoodFit, values: NDArray[Any]) -> NDArray[Any]:
    """(rows, outputs, inputs) from (rows, channels, 1) of FRFs."""
    return values if fit.channels is None else values.reshape(len(values), *fit.channels)


def residual_coefficients(fit: LikelihoodFit) -> Real:
    """Coefficients (terms, outputs, inputs) of the receptance's residual terms."""
    n = 2 * fit.point.parameters.omega.size
    return _unfold_channels(fit, np.stack([group.coefficients[n:] for group in fit.point.groups], axis=-1))


def _coefficient_variance(fit: LikelihoodFit, group: InputSolution, covariance: Real) -> Real:
    """Variance (columns, outputs) of the coefficients: their own noise, and what the searched parameters add."""
    inverse = np.linalg.inv(group.r)
    own = np.sum(inverse**2, axis=1)[:, None] * fit.point.noise**2
    slopes = _slopes_on_q(fit, group)
    added = np.empty_like(own)
    for o in range(own.shape[1]):
        change = inverse @ slopes(o)
        added[:, o] = np.sum((change @ covariance) * change, axis=1)
    return own + added


def _slopes_on_q(fit: LikelihoodFit, group: InputSolution) -> Callable[[int], Real]:
    """Q^T (slope of an output) by the poles and by what the blocks of this input have to themselves."""
    problem, n_poles = fit.problem, 2 * fit.point.parameters.omega.size
    rows, width = group.columns[0].phi.shape[0], problem.n_local
    parts = [group.q[m * rows : (m + 1) * rows].T for m in range(len(group.members))]
    poles = np.sum([p @ c.poles.values for p, c in zip(parts, group.columns, strict=True)], axis=0)
    forces = force_parts(problem, fit.point, group).slopes_in_columns if problem.force_sigma is not None else None
    local = [p @ c.local.values if c.local.parameter.size else None for p, c in zip(parts, group.columns, strict=True)]

    def of_output(o: int) -> Real:
        coefficient = group.coefficients[:, o]
        found = [_sum_columns(poles, group.columns[0].poles, coefficient, n_poles)]
        for m, columns_of in enumerate(group.columns):
            values = local[m]
            if values is not None:
                found.append(_sum_columns(values, columns_of.local, coefficient, width))
            if forces is not None:
                found.append(forces[m][:, o] * fit.point.noise[o])
        return np.concatenate(found, axis=1)

    return of_output


def _sum_columns(values: Real, vectors: DerivativeVectors, coefficient: Real, size: int) -> Real:
    """Columns of `values`, each times its coefficient, summed by parameter: (rows, size)."""
    if size == 0:
        return np.zeros((len(values), 0))
    starts = np.flatnonzero(np.diff(vectors.parameter, prepend=-1))
    return np.add.reduceat(values * coefficient[vectors.column], starts, axis=1)
