"""The searches of an impact test: once from the start poles, and again with the modes that were kept.

A beam that looks at rest need not be. The slowest mode may still move as much as one sample's noise and not be seen
before the hit, yet hundreds of samples after it give its phase to a hundredth of that. How long the last hit is ago
at least follows from that mode, and how much of all others can be left then from their decay: hardly anything, as a
rule.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.basis import (
    RESIDUAL_POWERS,
    STAND_INS,
    StartPoles,
    edges_of_stand_ins,
    poles_of,
    with_stand_ins,
)
from modallab.identification.likelihood.excitation import BlockLines
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.hit_blocks import Groups, HitBlocks
from modallab.identification.likelihood.projection import LikelihoodProblem, SearchParameters
from modallab.identification.likelihood.search import FIRST_LOOK, SearchLimits, search_minimum

LEAST = 1e-9
"""Share of the impulse; a prior of zero would divide by zero."""


def residual_motion_sigma(fit: LikelihoodFit, grid: BlockLines, impulse: Real) -> Real:
    """Prior (blocks, modes) in N s of each part of every mode's state at a block's start.

    Args:
        fit: of the blocks as if they began at rest.
        grid: of the blocks.
        impulse: (blocks,) N s of each hit.
    """
    at = fit.point.parameters
    poles = poles_of(at.omega, at.zeta)
    constants, _ = fit.modal_constants
    residue = np.abs(constants) / (2 * poles.imag[:, None, None])
    # (modes, inputs): rms over outputs and time of the motion that a unit state is.
    motion = np.sqrt(2 * np.mean(residue**2, axis=1)) * np.abs(poles[:, None]) ** grid.p
    noise = float(np.sqrt(np.mean(fit.point.noise**2) * 2 / grid.n))
    struck = float(impulse.max()) * motion.max(axis=1)
    decay = at.zeta * at.omega
    slowest = int(np.argmin(np.where(struck > noise, decay, np.inf)))
    ago = max(0.0, float(np.log(struck[slowest] / noise))) / max(float(decay[slowest]), 1e-12)
    left = np.minimum(struck, noise) if ago == 0.0 else struck * np.exp(-decay * ago)
    group = np.array([block.group for block in fit.problem.blocks])
    unit = np.maximum(motion, np.finfo(float).tiny)
    sigma = left[:, None] / unit
    return np.maximum(sigma.T[group], LEAST * impulse[:, None])


START_ZETA, ANY_ZETA = (1e-4, 0.1), (1e-6, 0.5)
"""Damping ratios that a search may begin at, and those that an estimator may have found."""
STATES_FIRST = 4
"""Steps that move only what each block has to itself, where the poles are to stay as an estimator gave them."""


def first_look(
    unknown: HitBlocks, poles: NDArray[np.complex128], groups: Groups, band: tuple[float, float]
) -> LikelihoodFit:
    """The fit after a search from these poles that distinguishes modes from poles that fit noise, and goes no further.

    It ends when a step gains less than one for each pole: on average they then stand within their sigmas. From there on
    poles that fit noise would only wander.

    Args:
        unknown: the blocks, and what each has to itself.
        poles: (modes,) rad/s.
        groups: the hits by point.
        band: of the lines.
    """
    begin = with_stand_ins(poles, band[1], STAND_INS, START_ZETA)
    return _search_from(unknown, begin, groups, SearchLimits(FIRST_LOOK, float(begin.omega.size)))


def fit_of_estimate(
    unknown: HitBlocks, poles: NDArray[np.complex128], groups: Groups, band: tuple[float, float]
) -> LikelihoodFit:
    """The fit with the poles where the estimator has put them; all else by least squares."""
    begin = with_stand_ins(poles, band[1], STAND_INS, ANY_ZETA)
    return _search_from(unknown, begin, groups, SearchLimits(0, states_first=0 if unknown.at_rest else STATES_FIRST))


def _search_from(unknown: HitBlocks, begin: StartPoles, groups: Groups, effort: SearchLimits) -> LikelihoodFit:
    known = unknown.state_sigma
    sigma = None if known is None else np.repeat(known[:, None], begin.omega.size, axis=1)
    points = tuple(g[0].block.drive_point for g in groups)
    force = np.zeros((0, 0)) if unknown.force_sigma is None else np.zeros_like(unknown.force_sigma)
    state = np.zeros((len(unknown.blocks), begin.omega.size), complex)
    return _search_fit(unknown, begin, sigma, (state, force), points, effort)


def search_again(
    unknown: HitBlocks, fit: LikelihoodFit, keep: NDArray[np.bool_], band: tuple[float, float]
) -> LikelihoodFit:
    """The kept modes once more; of a beam that looked at rest with what its sensors cannot have seen."""
    at = fit.point.parameters
    poles = -at.zeta[keep] * at.omega[keep] + 1j * at.omega[keep]
    begin = with_stand_ins(poles, band[1], edges_of_stand_ins(at.omega, band[1]), START_ZETA)
    if unknown.state_sigma is None:
        kept = residual_motion_sigma(fit, unknown.grid, unknown.impulse)[:, keep]
        nothing = LEAST * np.repeat(unknown.impulse[:, None], begin.stand_ins, axis=1)
        sigma = np.concatenate([kept, nothing], axis=1)
    else:
        sigma = np.repeat(unknown.state_sigma[:, None], begin.omega.size, axis=1)
    # The states found so far belong to the kept modes still; to begin at nothing again costs many steps.
    state = np.concatenate([at.state[:, keep], np.zeros((len(at.state), begin.stand_ins), np.complex128)], axis=1)
    return _search_fit(unknown, begin, sigma, (state, at.force), fit.input_points, SearchLimits())


def _search_fit(
    unknown: HitBlocks,
    begin: StartPoles,
    state_sigma: NDArray[np.float64] | None,
    local: tuple[NDArray[np.complex128], NDArray[np.float64]],
    points: tuple[int | None, ...],
    effort: SearchLimits,
) -> LikelihoodFit:
    problem = LikelihoodProblem(
        blocks=unknown.blocks,
        powers=RESIDUAL_POWERS,
        n_inputs=len(points),
        state_sigma=state_sigma,
        drive_sigma=None,
        zeta_prior=begin.zeta_prior,
        force_sigma=unknown.force_sigma,
    )
    state, force = local
    start = SearchParameters(begin.omega, begin.zeta, state, np.zeros(len(unknown.blocks), complex), force)
    return LikelihoodFit(problem, search_minimum(problem, start, effort), points)
