"""The likelihood's fit of FRFs that came as such: every FRF is a channel of its own.

An accelerometer's noise is even in the inertance, and falls with the square of the frequency in the receptance that is
made of it. What a fit leaves shows it, by the likelihood of noise that goes with each power of the frequency.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Real
from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity
from modallab.frf.estimate import variance_by_coherence
from modallab.identification.likelihood.basis import RESIDUAL_POWERS, STAND_INS, LineBlock, with_stand_ins
from modallab.identification.likelihood.excitation import BlockLines, Excitation, UnitExcitation
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.orthonormal import complex_lines, real_rows
from modallab.identification.likelihood.projection import LikelihoodProblem, SearchParameters, solve_at
from modallab.identification.likelihood.search import MAX_ITERATIONS, SearchLimits, search_minimum

WORDS = "The noise is taken as even over the lines in the {quantity}, by what the fit leaves of it."


def quantity_of_even_noise(fit: LikelihoodFit) -> FrfQuantity:
    """The quantity in which a fit of FRFs leaves what is most likely even noise, of each FRF its own.

    Args:
        fit: of FRFs whose lines are not weighted.
    """
    (group,), grid = fit.point.groups, fit.problem.blocks[0].excitation.grid
    square = np.sum(group.residual.reshape(grid.omega.size, 2, -1) ** 2, axis=1)
    square = np.maximum(square, np.finfo(float).tiny)
    costs = {q: _likelihood_cost(square, np.log(grid.omega) * 2 * (DERIVATIVES[q] - grid.p)) for q in DERIVATIVES}
    return min(DERIVATIVES, key=lambda quantity: costs[quantity])


def _likelihood_cost(square: NDArray[np.float64], log_factor: NDArray[np.float64]) -> float:
    """Minus the log likelihood of residuals whose squares (lines, FRFs) are even times a factor."""
    level = log_factor - log_factor.mean()
    return float(len(level) * np.sum(np.log(np.mean(square * np.exp(level)[:, None], axis=0))))


NEIGHBOURS = 5
"""Lines over whose median a variance is at least taken: by chance a coherence of few averages is near 1."""
RANGE = 1e-4
"""A line counts for at least this share of the best known one."""


def line_weights(frf: Frf) -> Real | None:
    """(lines,) by which residuals are multiplied, of mean square 1; None where nothing is known of the lines.

    All FRFs share the model's columns, and so the weights: a line's are those of the geometric mean of its variances,
    each relative to its own FRF's. How large the noise of each FRF is, its residuals say.

    Args:
        frf: with `variance`, or with `coherence`.
    """
    variance = frf.variance if frf.variance is not None else variance_by_coherence(frf)
    if variance is None or not np.isfinite(variance).all():
        return None
    variance = np.maximum(variance, ndimage.median_filter(variance, size=(1, 1, NEIGHBOURS), mode="nearest"))
    relative = np.log(np.maximum(variance, np.finfo(float).tiny))
    mean = np.mean(relative - np.median(relative, axis=-1, keepdims=True), axis=(0, 1))
    weight = np.exp(-mean / 2)
    weight = np.maximum(weight, np.sqrt(RANGE) * weight.max())
    return np.asarray(weight / np.sqrt(np.mean(weight**2)), np.float64)


MANY = 2
"""From this many channels per column of the model on, a few mixed ones are searched first."""
NEARER = 6
"""Steps with the mixed ones: poles that fit noise would wander on for long."""
START_ZETA = (1e-5, 0.2)
"""Damping ratios that a search may begin at."""
LINES = 20
"""Lines per column of the model that determine how to mix them."""


def fit_frf(
    frf: Frf,
    poles: NDArray[np.complex128],
    max_iterations: int = MAX_ITERATIONS,
    priors: NDArray[np.float64] | None = None,
    stand_ins: tuple[float, ...] = STAND_INS,
) -> LikelihoodFit:
    """The fit of FRFs after a search from these poles; those that stand for modes above the band come last in it.

    Args:
        frf: lines ascending; its variance or coherence, where there is one, weighs them.
        poles: (modes,) rad/s.
        max_iterations: at most so many steps; none leaves the poles where they are.
        priors: (modes, 2, 2) of omega in rad/s and zeta, each a centre and a sigma; with them stand-ins do not move.
        stand_ins: multiples of the upper edge at which the poles begin that stand for the modes above.

    Raises:
        IdentificationError: poles that cannot be distinguished in these lines.
    """
    grid = BlockLines(2 * np.pi * frf.frequency_hz, 0, 0.0, DERIVATIVES[frf.quantity])
    # Every FRF is a channel of its own: all share the columns, whatever the input.
    channels = frf.values.reshape(-1, frf.frequency_hz.size)
    begin, weight = with_stand_ins(poles, float(frf.frequency_hz[-1]), stand_ins, START_ZETA), line_weights(frf)
    excitation = UnitExcitation(grid, frf.damping_shift, weight)
    problem = LikelihoodProblem(
        blocks=[LineBlock(excitation, channels if weight is None else channels * weight, 0)],
        powers=RESIDUAL_POWERS,
        n_inputs=1,
        state_sigma=None,
        drive_sigma=None,
        zeta_prior=begin.zeta_prior,
    )
    problem = problem if priors is None else _with_priors(problem, priors)
    start = SearchParameters(begin.omega, begin.zeta, np.zeros((1, begin.omega.size), complex), np.zeros(1, complex))
    start = _start_from_few_channels(problem, start) if max_iterations else start
    return LikelihoodFit(
        problem, search_minimum(problem, start, SearchLimits(max_iterations)), frf.input_points, frf.values.shape[:2]
    )


def left_by(frf: Frf, poles: NDArray[np.complex128]) -> Frf:
    """What modes with these poles (modes,) in rad/s leave of FRFs.

    Raises:
        IdentificationError: as `fit_frf`.
    """
    (group,), weight = fit_frf(frf, poles, 0).point.groups, line_weights(frf)
    left = complex_lines(group.residual) / (1.0 if weight is None else weight)
    return replace(frf, values=left.reshape(frf.values.shape), coherence=None, variance=None)


def _with_priors(problem: LikelihoodProblem, priors: NDArray[np.float64]) -> LikelihoodProblem:
    """The same with priors of the first poles; the others stay where they are."""
    n = len(priors)
    free, rest = np.tile([0.0, np.inf], (problem.zeta_prior.shape[0] - n, 1)), problem.zeta_prior[n:]
    return replace(
        problem,
        omega_prior=np.concatenate([priors[:, 0], free]),
        zeta_prior=np.concatenate([priors[:, 1], rest]),
        fixed=np.arange(len(problem.zeta_prior)) >= n,
    )


def _excitation_at_lines(excitation: Excitation, grid: BlockLines, thin: int) -> UnitExcitation:
    assert isinstance(excitation, UnitExcitation)
    weight = None if excitation.weight is None else excitation.weight[::thin]
    return UnitExcitation(grid, excitation.shift, weight)


def _start_from_few_channels(problem: LikelihoodProblem, start: SearchParameters) -> SearchParameters:
    """A start at the optimum of a few channels in which all modes of many show.

    The gradient needs the data only along the residues, so as many mixed channels as the model has columns hold nearly
    all that hundreds do. For the residues themselves some of the lines will do.
    """
    response, excitation = problem.blocks[0].response, problem.blocks[0].excitation
    n_columns = 2 * start.omega.size + len(problem.powers)
    if len(response) < MANY * n_columns:
        return start
    thin = max(1, response.shape[1] // (LINES * n_columns))
    grid = replace(excitation.grid, omega=excitation.grid.omega[::thin])
    some = [LineBlock(_excitation_at_lines(excitation, grid, thin), response[:, ::thin], 0)]
    point = solve_at(replace(problem, blocks=some), start)
    mix, _ = np.linalg.qr((point.groups[0].coefficients / point.noise).T)
    few = complex_lines(real_rows(response) @ (mix / point.noise[:, None]))
    small = replace(problem, blocks=[LineBlock(excitation, few, 0)])
    return search_minimum(small, start, SearchLimits(NEARER)).point.parameters
