"""The maximum-likelihood search for the poles: Levenberg-Marquardt on the projected problem."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from modallab.core.arrays import Real
from modallab.core.errors import IdentificationError
from modallab.core.progress import report_progress
from modallab.identification.likelihood.equations import NormalEquations, ParameterCovariance
from modallab.identification.likelihood.normal_matrix import normal_equations
from modallab.identification.likelihood.projection import (
    LikelihoodPoint,
    LikelihoodProblem,
    SearchParameters,
    solve_at,
    with_own_noise,
)

MAX_ITERATIONS = 40
FIRST_LOOK = 12
"""Steps enough to distinguish a mode from a pole that fits noise, which need not settle at all."""
NOT_SETTLED = "The search for the poles had not settled when it was ended; the uncertainties may be too small."
LEAST_DAMPING = 1e-6
"""Of the search, not of a mode: less does not change a step, and takes many trials to become more."""
MAX_ZETA = 0.5
HIGHEST = 0.98
"""Share of half the sampling rate that no pole goes beyond."""
PRIOR_REACH = 2.0
"""Sigmas by which a damping ratio may leave its prior."""
MIN_ZETA = 1e-7
"""A pole that grows would overflow before a long block ends; no structure has one."""
MAX_MOVE = 0.1
"""Largest relative change of a frequency, or rise of a damping ratio, in one step."""
MAX_FALL = 0.75
"""Share of itself by which a damping ratio falls at most in one step: thrown to nothing it rings through the block."""


@dataclass(frozen=True, eq=False, slots=True)
class SearchEnd:
    """End of a search: the model there, the covariance of all parameters, steps taken, whether it settled."""

    point: LikelihoodPoint
    covariance: ParameterCovariance
    iterations: int
    settled: bool


@dataclass(frozen=True, slots=True)
class SearchLimits:
    """How long a search goes on.

    Attributes:
        max_iterations: at most so many steps.
        tolerance: it ends when a step would lower the cost, a sum of squares in noise units, by less than this: every
            parameter then stands within sqrt(tolerance) of its sigma.
        states_first: so many steps move only what each block has to itself, while the poles stay: rough poles would
            else be led astray by states that are rougher still.
    """

    max_iterations: int = MAX_ITERATIONS
    tolerance: float = 0.01
    states_first: int = 0


THOROUGH = SearchLimits()


def search_minimum(problem: LikelihoodProblem, start: SearchParameters, effort: SearchLimits = THOROUGH) -> SearchEnd:
    """Minimise the cost from `start`.

    The noise of each output is taken again from the residuals at every step.

    Args:
        problem: data and structure.
        start: where to begin.
        effort: how long it goes on.

    Raises:
        IdentificationError: the model's columns cannot be distinguished in these data.
    """
    point = solve_at(problem, start)
    held = 2 * start.omega.size
    for _ in range(effort.states_first):
        trial, _ = _descend_once(problem, point, normal_equations(problem, point), 1e-3, held)
        point = point if trial is None else with_own_noise(problem, trial)
    damping = 1e-3
    gains: list[float] = []
    for done in range(effort.max_iterations):
        report_progress(_share_done(gains, effort), f"step {done + 1}")
        equations = normal_equations(problem, point)
        trial, damping = _descend_once(problem, point, equations, damping, least_gain=effort.tolerance)
        if trial is None:
            return SearchEnd(point, equations.covariance(), done + 1, settled=True)
        gain = point.cost - trial.cost
        gains.append(gain)
        point = with_own_noise(problem, trial)
        if gain < effort.tolerance:
            return SearchEnd(point, normal_equations(problem, point).covariance(), done + 1, settled=True)
    return SearchEnd(point, normal_equations(problem, point).covariance(), effort.max_iterations, settled=False)


def _share_done(gains: list[float], effort: SearchLimits) -> float:
    """Of the way, on a logarithmic scale, from the first step's gain down to one that ends the search; and of steps."""
    steps = len(gains) / effort.max_iterations
    if not gains or min(gains) <= 0 or gains[0] <= effort.tolerance:
        return steps
    return max(steps, float(np.log(gains[0] / min(gains)) / np.log(gains[0] / effort.tolerance)))


def _descend_once(
    problem: LikelihoodProblem,
    point: LikelihoodPoint,
    equations: NormalEquations,
    damping: float,
    held: int = 0,
    least_gain: float = 0.0,
) -> tuple[LikelihoodPoint | None, float]:
    """One step, with the first `held` parameters held; the point it leads to, or None if none is better.

    `equations` are the normal equations there. A step that promises a gain below `least_gain` is not taken.
    """
    n_poles = 2 * point.parameters.omega.size
    scale = 1 / np.sqrt(np.maximum(equations.diagonal, 1e-300))
    scale[:held] = 0
    if problem.fixed is not None:
        scale[: 2 * problem.fixed.size][np.repeat(problem.fixed, 2)] = 0
    scale[1:n_poles:2][_damping_at_limit(problem, point.parameters, equations.pull[1:n_poles:2])] = 0
    scaled = equations.scaled(scale)
    factor = 4.0
    for _ in range(10):
        try:
            move = scaled.step(damping)
        except linalg.LinAlgError:
            # Rounding has made it indefinite: two poles hardly differ.
            damping = max(10 * damping, 1e-6)
            continue
        if move @ scaled.pull < least_gain and damping <= 1e-3:
            return None, damping
        after = _try_parameters(problem, _move_parameters(problem, point.parameters, scale * move), point.noise)
        if after is not None and after.cost <= point.cost:
            share = (point.cost - after.cost) / max(move @ (scaled.pull + damping * move), 1e-300)
            return after, max(damping * _damping_factor(float(share)), LEAST_DAMPING)
        damping, factor = damping * factor, 4 * factor
    return None, damping


def _damping_factor(share: float) -> float:
    """What damping is multiplied by after a step that gave this share of what the quadratic model promised.

    Source: Nielsen, "Damping parameter in Marquardt's method", report IMM-REP-1999-05 (1999).
    """
    return max(0.1, 1 - (2 * share - 1) ** 3)


def _try_parameters(problem: LikelihoodProblem, trial: SearchParameters, noise: Real) -> LikelihoodPoint | None:
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return solve_at(problem, trial, noise)
    except IdentificationError:
        # Two poles have run into each other: a step too far, not the end.
        return None


def _move_parameters(problem: LikelihoodProblem, at: SearchParameters, step: Real) -> SearchParameters:
    n, n_blocks = at.omega.size, len(problem.blocks)
    move = step[: 2 * n].reshape(n, 2)
    # Each pole is held back by itself: one that hardly matters must not slow the others down.
    omega = at.omega * np.clip(1 + move[:, 0] / at.omega, 1 - MAX_MOVE, 1 + MAX_MOVE)
    dt = problem.blocks[0].excitation.grid.dt
    if dt > 0:
        # Samples cannot show a pole above half the rate, nor distinguish it from its own alias.
        omega = np.minimum(omega, HIGHEST * np.pi / dt)
    low, high = _ends_of_zeta(problem)
    zeta = np.clip(at.zeta + np.clip(move[:, 1], -MAX_FALL * at.zeta, MAX_MOVE), low, high)
    local = step[2 * n :].reshape(n_blocks, problem.n_local)
    width = at.force.shape[1]
    force = at.force + local[:, problem.n_local - width :] if width else at.force
    parts = local[:, : problem.n_local - width].reshape(n_blocks, -1, 2)
    parts = parts[..., 0] + 1j * parts[..., 1]
    n_state = 0 if problem.state_sigma is None else n
    state = at.state + parts[:, :n] if n_state else at.state
    drive = at.drive if problem.drive_sigma is None else at.drive + parts[:, n_state]
    return SearchParameters(omega, zeta, state, drive, force)


def _ends_of_zeta(problem: LikelihoodProblem) -> tuple[Real, Real]:
    # Thrown far below its prior a stand-in rings through the block, and creeps back for as many steps as there are.
    centre, sigma = problem.zeta_prior.T
    return np.maximum(centre - PRIOR_REACH * sigma, MIN_ZETA), np.minimum(centre + PRIOR_REACH * sigma, MAX_ZETA)


def _damping_at_limit(problem: LikelihoodProblem, at: SearchParameters, pull: Real) -> NDArray[np.bool_]:
    """Of each damping ratio (modes,): it stands at an end of what it may be, and is pulled beyond it.

    Such a one is held for the step: one computed with a move that is then cut off is none of the others' best, gains
    less than it promises, and the search creeps.
    """
    low, high = _ends_of_zeta(problem)
    return ((at.zeta <= low) & (pull < 0)) | ((at.zeta >= high) & (pull > 0))
