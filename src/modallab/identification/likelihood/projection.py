"""The modal model's least squares with residues and residual terms solved for (variable projection).

All outputs share the columns, so one QR per input serves them all. For white noise of one variance per output the cost
is the squared residual in units of that noise.
Source: Golub and Pereyra, "Separable nonlinear least squares: the variable projection method", Inverse Problems 19
(2003).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import IdentificationError
from modallab.identification.likelihood.basis import BlockColumns, LineBlock, SharedKernels, columns_of_block, poles_of
from modallab.identification.likelihood.excitation import Excitation, HitExcitation
from modallab.identification.likelihood.orthonormal import qr_decomposition, real_rows


@dataclass(frozen=True, eq=False, slots=True)
class SearchParameters:
    """The unknowns that the search varies; residues follow from them by least squares.

    Attributes:
        omega: (modes,) rad/s.
        zeta: (modes,)
        state: (blocks, modes) unknown modal states; zero where none is free.
        drive: (blocks,) relative error of the drive's complex amplitude; zero where none is free.
        force: (blocks, width) error in N of each sample of the hit; no width where none is free.
    """

    omega: Real
    zeta: Real
    state: Complex128
    drive: Complex128
    force: Real = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True, eq=False, slots=True)
class LikelihoodProblem:
    """The data and the model's structure.

    Attributes:
        blocks: all on one grid of lines.
        powers: powers of s of the residual terms.
        n_inputs: number of groups.
        state_sigma: (blocks, modes) prior of each part of an unknown state; None where states are known to be zero.
        drive_sigma: (blocks,) prior of each part of the drive's relative error; None where there is none.
        zeta_prior: (modes, 2) centre and sigma of a prior on zeta, sigma inf for none.
        force_sigma: (blocks, width) prior of the error of each sample of the hit; None if none is searched.
        fixed: (modes,) poles that stay where they are; None where all move.
        omega_prior: (modes, 2) centre and sigma of a prior on omega, rad/s; None for none.
    """

    blocks: Sequence[LineBlock]
    powers: tuple[int, ...]
    n_inputs: int
    state_sigma: Real | None
    drive_sigma: Real | None
    zeta_prior: Real
    force_sigma: Real | None = None
    fixed: NDArray[np.bool_] | None = None
    omega_prior: Real | None = None

    @property
    def n_local(self) -> int:
        """Parameters that each block has to itself."""
        states = 0 if self.state_sigma is None else 2 * self.state_sigma.shape[1]
        forces = 0 if self.force_sigma is None else self.force_sigma.shape[1]
        return states + (0 if self.drive_sigma is None else 2) + forces


@dataclass(frozen=True, eq=False, slots=True)
class InputSolution:
    """One input's linear solution.

    Attributes:
        members: blocks of this input.
        coefficients: (columns, outputs).
        residual: (rows, outputs).
        q: (rows, columns) orthonormal.
        r: (columns, columns) with phi = q r.
        columns: per member.
    """

    members: tuple[int, ...]
    coefficients: Real
    residual: Real
    q: Real
    r: Real
    columns: tuple[BlockColumns, ...]


@dataclass(frozen=True, eq=False, slots=True)
class LikelihoodPoint:
    """The model at one set of parameters: each input's solution, noise (outputs,) of a DFT line's real part, cost."""

    parameters: SearchParameters
    groups: tuple[InputSolution, ...]
    noise: Real
    cost: float


def solve_at(problem: LikelihoodProblem, parameters: SearchParameters, noise: Real | None = None) -> LikelihoodPoint:
    """Residues for given poles; noise from the residuals unless given.

    Raises:
        IdentificationError: two columns of the model cannot be distinguished in these data.
    """
    # All blocks are on one grid, whichever their input.
    shared = SharedKernels(problem.blocks[0].excitation.grid, poles_of(parameters.omega, parameters.zeta))
    groups = tuple(_solve_group(problem, parameters, g, shared) for g in range(problem.n_inputs))
    return _point_of_parameters(problem, parameters, groups, noise)


def with_own_noise(problem: LikelihoodProblem, point: LikelihoodPoint) -> LikelihoodPoint:
    """The same point, its noise taken from its residuals: all outputs share the columns, so nothing else changes."""
    return _point_of_parameters(problem, point.parameters, point.groups, None)


def _point_of_parameters(
    problem: LikelihoodProblem, parameters: SearchParameters, groups: tuple[InputSolution, ...], noise: Real | None
) -> LikelihoodPoint:
    squares = np.sum([sum_of_squares(g.residual) for g in groups], axis=0)
    if noise is None:
        rows = sum(g.residual.shape[0] - g.r.shape[0] for g in groups)
        searched = (2 * parameters.omega.size + problem.n_local * len(problem.blocks)) / squares.size
        raw = np.asarray(np.sqrt(squares / max(rows - searched, 1)), dtype=np.float64)
        noise = np.maximum(raw, 1e-9 * raw.max() + np.finfo(float).tiny)
    cost = float(np.sum(squares / noise**2)) + _prior_cost(problem, parameters)
    return LikelihoodPoint(parameters, groups, noise, cost)


def sum_of_squares(rows: Real) -> Real:
    """Sum of squares (outputs,) of (rows, outputs), without an array of the squares."""
    return np.einsum("ro,ro->o", rows, rows)


def _prior_cost(problem: LikelihoodProblem, parameters: SearchParameters) -> float:
    centre, sigma = problem.zeta_prior.T
    cost = float(np.sum(((parameters.zeta - centre) / sigma) ** 2))
    if problem.omega_prior is not None:
        middle, width = problem.omega_prior.T
        cost += float(np.sum(((parameters.omega - middle) / width) ** 2))
    if problem.state_sigma is not None:
        cost += float(np.sum(np.abs(parameters.state / problem.state_sigma) ** 2))
    if problem.drive_sigma is not None:
        cost += float(np.sum(np.abs(parameters.drive / problem.drive_sigma) ** 2))
    if problem.force_sigma is not None:
        cost += float(np.sum((parameters.force / problem.force_sigma) ** 2))
    return cost


def true_excitation(
    problem: LikelihoodProblem, parameters: SearchParameters, block: int, excitation: Excitation
) -> Excitation:
    """What drove a block, the errors of its force samples taken into account."""
    if problem.force_sigma is None or not isinstance(excitation, HitExcitation):
        return excitation
    return excitation.corrected(parameters.force[block])


def _block_columns(
    problem: LikelihoodProblem, parameters: SearchParameters, i: int, shared: SharedKernels
) -> BlockColumns:
    return columns_of_block(
        true_excitation(problem, parameters, i, problem.blocks[i].excitation),
        parameters.omega,
        parameters.zeta,
        None if problem.state_sigma is None else parameters.state[i],
        None if problem.drive_sigma is None else complex(parameters.drive[i]),
        problem.powers,
        shared,
    )


def _solve_group(
    problem: LikelihoodProblem, parameters: SearchParameters, group: int, shared: SharedKernels
) -> InputSolution:
    members = tuple(i for i, block in enumerate(problem.blocks) if block.group == group)
    found = tuple(_block_columns(problem, parameters, i, shared) for i in members)
    phi = np.concatenate([c.phi for c in found])
    parts = [real_rows(problem.blocks[i].response) for i in members]
    response = parts[0] if len(parts) == 1 else np.concatenate(parts)
    scale = np.linalg.norm(phi, axis=0)
    q, r = qr_decomposition(phi / np.where(scale > 0, scale, 1))
    diagonal = np.abs(np.diag(r))
    if not np.all(np.isfinite(r)) or diagonal.min() < 1e-13:
        raise IdentificationError(
            f"{phi.shape[1]} columns of the model cannot be distinguished in {phi.shape[0]} lines of data",
            remedy="narrow the band to where the force has content, or ask for fewer modes",
        )
    projected = q.T @ response
    coefficients = np.linalg.solve(r, projected) / scale[:, None]
    # Laid out as the response is, and written once: with hundreds of outputs fresh memory costs more than the product.
    residual = projected.T @ q.T
    np.subtract(response.T, residual, out=residual)
    return InputSolution(members, coefficients, residual.T, q, r * scale, found)
