"""Normal matrix and gradient of the projected problem.

Gauss-Newton with Kaufman's derivative: by parameter i output o changes by P (sum over i's vectors v of v C[column, o]),
P the projector off the columns. With the Gram matrix M of all projected vectors and K their coefficients in noise
units, J^T J is the sum of M * (K K^T) over each parameter's vectors: the outputs enter through K alone, whatever
their number.
Source: Kaufman, "A variable projection method for solving separable nonlinear least squares problems", BIT 15 (1975).
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.basis import DerivativeVectors
from modallab.identification.likelihood.equations import BlockEquations, NormalEquations
from modallab.identification.likelihood.force_noise import force_equations
from modallab.identification.likelihood.projection import InputSolution, LikelihoodPoint, LikelihoodProblem


def normal_equations(problem: LikelihoodProblem, point: LikelihoodPoint) -> NormalEquations:
    """J^T J and J^T residual in noise units, priors included.

    Parameters: omega and zeta of every mode, then block by block its states and drive error, real and imaginary part
    next to each other, and the errors of its force samples.
    """
    n, n_local = 2 * point.parameters.omega.size, problem.n_local
    weight, pull = _prior_weights(problem, point)
    poles, gradient, inputs = np.diag(weight[:n]), -weight * pull, list[BlockEquations]()
    for group in point.groups:
        part, slope = _input_equations(problem, point, group)
        at = np.concatenate([n + n_local * i + np.arange(n_local) for i in group.members])
        part[np.arange(n, len(slope)), np.arange(n, len(slope))] += weight[at]
        poles += part[:n, :n]
        gradient[:n] += slope[:n]
        gradient[at] += slope[n:]
        inputs.append(BlockEquations(at, part[n:, n:], part[:n, n:]))
    return NormalEquations(poles, inputs, gradient)


def _input_equations(problem: LikelihoodProblem, point: LikelihoodPoint, group: InputSolution) -> tuple[Real, Real]:
    """Of one input: poles, then what each of its blocks has to itself."""
    width = 0 if problem.force_sigma is None else problem.force_sigma.shape[1]
    n, n_states = 2 * point.parameters.omega.size, problem.n_local - width
    part, slope = _group_equations(group, point.noise, n_states)
    if not width:
        return part, slope
    part, slope = force_equations(problem, point, group, (part, slope))
    members = len(group.members)
    states = n + np.arange(members * n_states).reshape(members, -1)
    forces = n + members * n_states + np.arange(members * width).reshape(members, -1)
    order = np.concatenate([np.arange(n), np.concatenate([states, forces], axis=1).ravel()])
    return part[np.ix_(order, order)], slope[order]


def _prior_weights(problem: LikelihoodProblem, point: LikelihoodPoint) -> tuple[Real, Real]:
    """Weight and distance from the prior's centre, per parameter."""
    at, n_blocks = point.parameters, len(problem.blocks)
    centre, sigma = problem.zeta_prior.T
    free = np.stack([np.zeros_like(sigma), np.full_like(sigma, np.inf)], axis=1)
    middle, width = (free if problem.omega_prior is None else problem.omega_prior).T
    weights = [np.stack([width**-2.0, sigma**-2.0], axis=1).ravel()]
    pulls = [np.stack([at.omega - middle, at.zeta - centre], axis=1).ravel()]
    local_weight, local_pull = [], []
    if problem.state_sigma is not None:
        local_weight.append(np.repeat(problem.state_sigma**-2.0, 2, axis=1))
        local_pull.append(_real_parts(at.state))
    if problem.drive_sigma is not None:
        local_weight.append(np.repeat(problem.drive_sigma[:, None] ** -2.0, 2, axis=1))
        local_pull.append(_real_parts(at.drive[:, None]))
    if problem.force_sigma is not None:
        local_weight.append(problem.force_sigma**-2.0)
        local_pull.append(at.force)
    if local_weight:
        weights.append(np.concatenate(local_weight, axis=1).reshape(n_blocks * problem.n_local))
        pulls.append(np.concatenate(local_pull, axis=1).reshape(n_blocks * problem.n_local))
    return np.concatenate(weights), np.concatenate(pulls)


def _real_parts(values: NDArray[np.complex128]) -> Real:
    return np.stack([values.real, values.imag], axis=-1).reshape(len(values), -1)


def _group_equations(group: InputSolution, noise: Real, n_local: int) -> tuple[Real, Real]:
    weighted = group.coefficients / noise
    gram, on_residual = _gram_of_group(group)
    pole, local = group.columns[0].poles, group.columns[0].local
    column = np.concatenate([pole.column, *[local.column for _ in group.members]])
    coefficient = weighted[column]
    starts = _first_columns(pole, local, len(group.members), n_local)
    product = gram * (coefficient @ coefficient.T)
    matrix = np.add.reduceat(np.add.reduceat(product, starts, axis=0), starts, axis=1)
    return matrix, np.add.reduceat(np.sum(on_residual * (coefficient / noise), axis=1), starts)


def _first_columns(pole: DerivativeVectors, local: DerivativeVectors, members: int, n_local: int) -> NDArray[np.int64]:
    """Where each parameter's vectors begin."""
    firsts = np.flatnonzero(np.diff(pole.parameter, prepend=-1))
    if n_local == 0:
        return firsts
    own = np.flatnonzero(np.diff(local.parameter, prepend=-1))
    width = local.parameter.size
    return np.concatenate([firsts, *[pole.parameter.size + m * width + own for m in range(members)]])


def _gram_of_group(group: InputSolution) -> tuple[Real, Real]:
    """Gram matrix of all projected vectors, and their products with the residual (vectors, outputs)."""
    rows, residual = group.columns[0].phi.shape[0], group.residual
    poles = np.concatenate([c.poles.values for c in group.columns])
    n_pole, width = poles.shape[1], group.columns[0].local.parameter.size
    size = n_pole + width * len(group.members)
    gram, on_q = np.zeros((size, size)), np.zeros((group.q.shape[1], size))
    on_residual = np.zeros((size, residual.shape[1]))
    gram[:n_pole, :n_pole] = poles.T @ poles
    on_q[:, :n_pole] = group.q.T @ poles
    on_residual[:n_pole] = poles.T @ residual
    for m, found in enumerate(group.columns if width else ()):
        here, part = slice(m * rows, (m + 1) * rows), slice(n_pole + m * width, n_pole + (m + 1) * width)
        values = found.local.values
        first = group.columns[0].local.values
        # Blocks whose states enter at the same sample share the very vectors.
        gram[part, part] = (
            gram[slice(n_pole, n_pole + width), slice(n_pole, n_pole + width)]
            if (m and values is first)
            else values.T @ values
        )
        gram[:n_pole, part] = poles[here].T @ values
        gram[part, :n_pole] = gram[:n_pole, part].T
        on_q[:, part] = group.q[here].T @ values
        on_residual[part] = values.T @ residual[here]
    return gram - on_q.T @ on_q, on_residual
