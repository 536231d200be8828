"""A refined fit, its modal constants with their covariance, and what it says of each block."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.identification.basis import columns, poles_of, stack
from modallab.identification.excitation import Excitation
from modallab.identification.projection import GroupSolution, Point, Problem
from modallab.identification.search import Refined

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """The end of an identification, with what is needed to regenerate every block."""

    problem: Problem
    refined: Refined
    input_points: tuple[int | None, ...]

    @property
    def point(self) -> Point:
        """The model at its optimum."""
        return self.refined.point

    @property
    def pole_sigma(self) -> Real:
        """(modes, 2) sigma of omega (rad/s) and zeta."""
        n = 2 * self.point.parameters.omega.size
        return np.sqrt(np.diag(self.refined.covariance)[:n]).reshape(-1, 2)

    def regenerated(self, block: int, excitation: Excitation) -> NDArray[np.complex128]:
        """The model's response (outputs, lines) in a block, at the lines of `excitation`'s grid."""
        at, problem = self.point.parameters, self.problem
        found = columns(
            excitation,
            at.omega,
            at.zeta,
            None if problem.state_sigma is None else at.state[block],
            None if problem.drive_sigma is None else complex(at.drive[block]),
            problem.powers,
        )
        coefficients = self.point.groups[problem.blocks[block].group].coefficients
        rows = (found.phi @ coefficients).T
        half = rows.shape[1] // 2
        return rows[:, :half] + 1j * rows[:, half:]


def modal_constants(fit: Fit) -> tuple[NDArray[np.complex128], Real]:
    """Modal constants A = 2 j omega_d R and their sigma, each (modes, outputs, inputs).

    The receptance of a mode is R / (s - lambda) + conj(R) / (s - conj(lambda)): for a real A this is eq. 13 with
    viscous damping.
    """
    at = fit.point.parameters
    n = at.omega.size
    values, sigmas = [], []
    for group in fit.point.groups:
        parts = group.coefficients[: 2 * n].reshape(n, 2, -1)
        values.append(parts[:, 0] + 1j * parts[:, 1])
        variance = np.stack([_coefficient_variance(fit, group, o) for o in range(parts.shape[-1])], axis=-1)
        sigmas.append(np.sqrt(variance[: 2 * n].reshape(n, 2, -1).sum(axis=1)))
    scale = 2 * poles_of(at.omega, at.zeta).imag[:, None, None]
    constants = np.asarray(1j * scale * np.stack(values, axis=-1), dtype=np.complex128)
    return constants, scale * np.stack(sigmas, axis=-1)


def residuals(fit: Fit) -> Real:
    """Coefficients (terms, outputs, inputs) of the receptance's residual terms."""
    n = 2 * fit.point.parameters.omega.size
    return np.stack([group.coefficients[n:] for group in fit.point.groups], axis=-1)


def _coefficient_variance(fit: Fit, group: GroupSolution, output: int) -> Real:
    """Variance (columns,) of one output's coefficients: their own noise, and what the searched parameters add."""
    noise = fit.point.noise[output]
    inverse = np.linalg.inv(group.r)
    own = noise**2 * np.sum(inverse**2, axis=1)
    coefficient = group.coefficients[:, output]
    rows = group.columns[0].phi.shape[0]
    slope = np.zeros((group.r.shape[0], fit.refined.covariance.shape[0]))
    n_poles = 2 * fit.point.parameters.omega.size
    for m, (i, found) in enumerate(zip(group.members, group.columns, strict=True)):
        part = group.q[m * rows : (m + 1) * rows].T
        for vectors, offset in ((found.poles, 0), (found.local, n_poles + fit.problem.n_local * i)):
            if vectors.parameter.size:
                np.add.at(
                    slope.T, offset + vectors.parameter, (part @ (vectors.values * coefficient[vectors.column])).T
                )
    change = inverse @ slope
    return own + np.einsum("ci,ij,cj->c", change, fit.refined.covariance, change, optimize=True)


def response_misfit(fit: Fit) -> Real:
    """Share (outputs,) of the measured response's energy that the model leaves over."""
    left = np.sum([np.sum(g.residual**2, axis=0) for g in fit.point.groups], axis=0)
    there = np.sum([np.sum(stack(b.response) ** 2, axis=0) for b in fit.problem.blocks], axis=0)
    return left / np.maximum(there, np.finfo(float).tiny)
