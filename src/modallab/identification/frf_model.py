"""Identification of FRFs that came as such, from a source without time records."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frf
from modallab.core.errors import IdentificationError
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.identification.estimate import estimate_poles
from modallab.identification.likelihood.basis import LineBlock
from modallab.identification.likelihood.excitation import Grid, UnitExcitation
from modallab.identification.likelihood.fit import Fit
from modallab.identification.likelihood.projection import Parameters, Problem, solve_at
from modallab.identification.likelihood.rows import stack, unstack
from modallab.identification.likelihood.search import FIRST_LOOK, MAX_ITERATIONS, NOT_SETTLED, Effort, search
from modallab.identification.model.modal_model import model_of_fit, without_sigma
from modallab.identification.options import Options
from modallab.identification.readings import half_power_readings
from modallab.identification.selection.operator_choice import chosen, start_poles

MANY = 2
"""From this many channels per column of the model on, a few mixed ones are searched first."""
NEARER = 6
"""Steps with the mixed ones: poles that fit noise would wander on for long."""
LINES = 20
"""Lines per column of the model that determine how to mix them."""


def identify_frf(frf: Frf, rig: Rig, options: Options) -> tuple[ModalModel, Fit]:
    """Modal model of measured FRFs, taken as those of the structure: how they were truncated is not known.

    Raises:
        DataError: the FRF is not finite, its lines do not ascend, or it has no phase.
        IdentificationError: no stable pole.
    """
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=False)
    inside = frf.frequency_hz > 0
    if options.band_hz is not None:
        inside &= (frf.frequency_hz >= options.band_hz[0]) & (frf.frequency_hz <= options.band_hz[1])
    # Lines ascend, so those of a band are neighbours, and looking at them needs no copy.
    lines = slice(int(np.argmax(inside)), int(np.argmax(inside)) + int(np.count_nonzero(inside)))
    used = replace(
        frf, frequency_hz=frf.frequency_hz[lines], values=frf.values[..., lines], coherence=None, variance=None
    )
    if used.frequency_hz.size < 8:
        raise IdentificationError(
            f"the band holds {used.frequency_hz.size} lines of the FRF", remedy="widen the band to at least 8 lines"
        )
    band = (float(used.frequency_hz[0]), float(used.frequency_hz[-1]))
    estimate = estimate_poles(used, options.method, options.max_order)
    poles = start_poles(estimate.poles, estimate.orders, options)
    if poles.size == 0:
        raise IdentificationError(
            f"no pole of {options.estimator.called} between {band[0]:.4g} and {band[1]:.4g} Hz is stable",
            remedy="widen the band, or look at the FRFs: is there a resonance in them at all?",
        )
    fit = _refined(used, poles, FIRST_LOOK if options.refined else 0)
    keep = chosen(fit, band, options, first=True)
    if options.refined and np.any(keep) and not (np.all(keep) and fit.refined.settled):
        at = fit.point.parameters
        fit = _refined(used, -at.zeta[keep] * at.omega[keep] + 1j * at.omega[keep])
        keep = chosen(fit, band, options, first=False)
    if not np.any(keep):
        raise IdentificationError(
            f"no mode stands out of the noise between {band[0]:.4g} and {band[1]:.4g} Hz", remedy="widen the band"
        )
    found = np.sort(fit.point.parameters.omega[keep]) / (2 * np.pi)
    read = half_power_readings(used, found)
    notes = (
        "Identified from FRFs, not from time records: what a block's end cut off could not be modelled.",
        *(() if fit.refined.settled or not options.refined else (NOT_SETTLED,)),
    )
    floor = np.full(found.size, np.nan)
    model = model_of_fit(fit, keep, rig, None, band, (read, floor), notes, options.method)
    return model if options.refined else without_sigma(model), fit


def _refined(frf: Frf, poles: NDArray[np.complex128], max_iterations: int = MAX_ITERATIONS) -> Fit:
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
        zeta_prior=np.tile([0.0, np.inf], (omega.size, 1)),
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
