"""The likelihood's fit of FRFs that came as such: every FRF is a channel of its own."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import DERIVATIVES, Frf
from modallab.identification.likelihood.basis import LineBlock
from modallab.identification.likelihood.excitation import Grid, UnitExcitation
from modallab.identification.likelihood.fit import Fit
from modallab.identification.likelihood.projection import Parameters, Problem, solve_at
from modallab.identification.likelihood.rows import stack, unstack
from modallab.identification.likelihood.search import MAX_ITERATIONS, Effort, search

MANY = 2
"""From this many channels per column of the model on, a few mixed ones are searched first."""
NEARER = 6
"""Steps with the mixed ones: poles that fit noise would wander on for long."""
LINES = 20
"""Lines per column of the model that determine how to mix them."""


def fit_frf(
    frf: Frf,
    poles: NDArray[np.complex128],
    max_iterations: int = MAX_ITERATIONS,
    omega_prior: NDArray[np.float64] | None = None,
    zeta_prior: NDArray[np.float64] | None = None,
) -> Fit:
    """The fit of FRFs after a search from these poles.

    Args:
        frf: lines ascending.
        poles: (modes,) rad/s.
        max_iterations: at most so many steps; none leaves the poles where they are.
        omega_prior: (modes, 2) centre and sigma, rad/s; None for none.
        zeta_prior: (modes, 2) likewise.

    Raises:
        IdentificationError: poles that cannot be distinguished in these lines.
    """
    grid = Grid(2 * np.pi * frf.frequency_hz, 0, 0.0, DERIVATIVES[frf.quantity])
    # Every FRF is a channel of its own: all share the columns, whatever the input.
    channels = frf.values.reshape(-1, frf.frequency_hz.size)
    omega = np.abs(poles)
    problem = Problem(
        blocks=[LineBlock(UnitExcitation(grid), channels, 0)],
        powers=(-2, 0, 2),
        n_inputs=1,
        state_sigma=None,
        drive_sigma=None,
        zeta_prior=np.tile([0.0, np.inf], (omega.size, 1)) if zeta_prior is None else zeta_prior,
        omega_prior=omega_prior,
    )
    start = Parameters(
        omega,
        np.clip(-poles.real / omega, 1e-5, 0.2),
        np.zeros((1, omega.size), complex),
        np.zeros(1, complex),
    )
    begin = _nearer(problem, start) if max_iterations else start
    return Fit(problem, search(problem, begin, Effort(max_iterations)), frf.input_points, frf.values.shape[:2])


def _nearer(problem: Problem, start: Parameters) -> Parameters:
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
    some = [LineBlock(UnitExcitation(grid), response[:, ::thin], 0)]
    point = solve_at(replace(problem, blocks=some), start)
    mix, _ = np.linalg.qr((point.groups[0].coefficients / point.noise).T)
    few = unstack(stack(response) @ (mix / point.noise[:, None]))
    small = replace(problem, blocks=[LineBlock(excitation, few, 0)])
    return search(small, start, Effort(NEARER)).point.parameters
