"""The likelihood's fit of FRFs that came as such: every FRF is a channel of its own."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import DERIVATIVES, Frf
from modallab.identification.likelihood.basis import LineBlock
from modallab.identification.likelihood.even_noise import line_weights
from modallab.identification.likelihood.excitation import BlockLines, Excitation, UnitExcitation
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.orthonormal import complex_lines, real_rows
from modallab.identification.likelihood.out_of_band import RESIDUAL_POWERS, STAND_INS, with_stand_ins
from modallab.identification.likelihood.projection import LikelihoodProblem, SearchParameters, solve_at
from modallab.identification.likelihood.search import MAX_ITERATIONS, SearchLimits, search_minimum

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
