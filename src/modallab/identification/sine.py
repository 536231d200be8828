"""Identification of a sine test: forced response and the decay that is still there, all blocks at once.

A lightly damped mode still rings when a block begins, so an amplitude read off the block is wrong by up to tens of
per cent. Here every block has its own free decay of every mode, and the force's own noise, which near a resonance
weighs more than the responses', is estimated along.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError, IdentificationError
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.frf.estimate import lines_of_band, output_quantity
from modallab.frf.stepped import stepped_frf
from modallab.identification.estimate import estimate_poles
from modallab.identification.likelihood.basis import LineBlock, StartPoles, poles_of, with_stand_ins
from modallab.identification.likelihood.excitation import BlockLines
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.projection import LikelihoodProblem, SearchParameters
from modallab.identification.likelihood.search import (
    FIRST_LOOK,
    MAX_ITERATIONS,
    NOT_SETTLED,
    SearchLimits,
    search_minimum,
)
from modallab.identification.likelihood.sine_block import tone_excitation
from modallab.identification.model.modal_model import model_of_fit, without_sigma
from modallab.identification.options import IdentificationOptions
from modallab.identification.readings import floor_of_steps, half_power_readings
from modallab.identification.selection.operator_choice import chosen_modes, poles_to_search, start_poles
from modallab.identification.start.refine_start import add_missing_poles, polish_poles
from modallab.identification.start.stabilisation import StabilityLimits
from modallab.signals.block_sets import check_test
from modallab.signals.signals import Signals

LOWEST_LINE = 2
LEAST_LINES = 3
"""A resonance has a frequency, a damping and a size: fewer sines hold none."""
STAND_INS = (2.0,)
"""A pole that begins at this multiple of the upper edge stands for all modes above the band."""
STATES_FIRST = 4
START_ZETA, ANY_ZETA = (1e-3, 0.05), (1e-6, 0.5)
"""Damping ratios that a search may begin at, and those that an estimator may have found."""
BAND_MARGIN = 1.05
CLOCK_PPM = 5.0
"""Two good clocks differ by less than this; it changes no frequency by more than its sigma."""
START = StabilityLimits(frequency=0.02, damping=0.03, max_zeta=0.06, min_zeta=2e-4, min_run=2, min_share=0.15)
"""Few frequencies and decaying blocks: the start poles are rough."""


def identify_sine(
    signals: Sequence[Signals], rig: Rig, options: IdentificationOptions
) -> tuple[ModalModel, LikelihoodFit]:
    """Modal model of a stepped sine test.

    Args:
        signals: blocks of the test, equal in rate and length, all driven at one point.
        rig: channels and points.
        options: the estimator and whether its poles are refined; band and order.

    Raises:
        DataError: a block without a sine in the force, or more than one drive point.
        IdentificationError: no stable pole.
    """
    check_test(signals)
    _require_one_point(signals)
    band = options.band_hz or default_band(signals)
    # From 0 Hz on means from where the data begin: poles are sought on a logarithmic scale.
    band = (band[0] or default_band(signals)[0], band[1])
    used = [s for s in signals if band[0] <= s.tone.frequency_hz <= band[1]]
    frf = stepped_frf(used, rig)
    _require_lines(frf, band)
    start = _start_poles(frf, options, band)
    fit = _refine_model(used, rig, start, band, FIRST_LOOK if options.refined else 0)
    keep = chosen_modes(fit, band, options, first=True)
    if not options.refined:
        readings = _sine_readings(frf, fit, keep)
        model = model_of_fit(fit, keep, rig, "sine", band, readings, clock_notes(used), options.method)
        return without_sigma(model), fit
    inside = fit.point.parameters.omega < 2 * np.pi * band[1]
    if np.any(keep) and not (np.array_equal(keep, inside) and fit.refined.settled):
        at, stay = fit.point.parameters, poles_to_search(fit, keep, band, options)
        fit = _refine_model(used, rig, -at.zeta[stay] * at.omega[stay] + 1j * at.omega[stay], band)
        keep = chosen_modes(fit, band, options, first=False)
    if not np.any(keep):
        raise IdentificationError(
            f"no mode stands out of the noise between {band[0]:.4g} and {band[1]:.4g} Hz",
            remedy="add frequencies near the resonances, or drive harder",
        )
    readings = _sine_readings(frf, fit, keep)
    notes = (*(() if fit.refined.settled else (NOT_SETTLED,)), *clock_notes(used))
    return model_of_fit(fit, keep, rig, "sine", band, readings, notes, options.method), fit


def _require_one_point(signals: Sequence[Signals]) -> None:
    points = {s.block.drive_point for s in signals}
    if len(points) > 1:
        raise DataError(
            f"the sine blocks are driven at points {sorted(map(str, points))}", remedy="identify each point apart"
        )


def _require_lines(frf: Frf, band: tuple[float, float]) -> None:
    if frf.frequency_hz.size < LEAST_LINES:
        raise IdentificationError(
            f"the sines between {band[0]:.4g} and {band[1]:.4g} Hz are of {frf.frequency_hz.size} frequencies only",
            remedy=f"record at least {LEAST_LINES}, some on either side of each resonance, or widen the band",
        )


def stepped_start(signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float]) -> Frf:
    """The stepped FRF that the estimators see, of the blocks driven within a band."""
    return stepped_frf([s for s in signals if band_hz[0] <= s.tone.frequency_hz <= band_hz[1]], rig)


def highest_order(frf: Frf) -> int:
    """Highest order that as few lines as a stepped test has can carry."""
    return max(2, frf.frequency_hz.size // 2 - 1)


def _start_poles(frf: Frf, options: IdentificationOptions, band: tuple[float, float]) -> NDArray[np.complex128]:
    estimate = estimate_poles(frf, options.method, options.max_order or highest_order(frf), START)
    found = estimate.poles
    inside = found[(np.abs(found) > 2 * np.pi * band[0]) & (np.abs(found) < 2 * np.pi * band[1])]
    if options.refined:
        # Only a start that is to be refined is moved, and looked at for what it has missed.
        inside = add_missing_poles(frf, polish_poles(frf, inside, band), band)
    start = start_poles(inside, estimate.orders, options)
    if start.size == 0:
        raise IdentificationError(
            f"no stable pole among {frf.frequency_hz.size} drive frequencies from {band[0]:.4g} to {band[1]:.4g} Hz",
            remedy="drive at more frequencies, closer together about each resonance",
        )
    return start


def _refine_model(
    signals: Sequence[Signals],
    rig: Rig,
    start: NDArray[np.complex128],
    band: tuple[float, float],
    max_iterations: int = MAX_ITERATIONS,
) -> LikelihoodFit:
    first = signals[0]
    n, rate = first.force.size, first.rate_hz
    chosen = lines_of_band(n, rate, (LOWEST_LINE * rate / n, min(1.1 * band[1], 0.4 * rate)))
    grid = BlockLines(2 * np.pi * chosen * rate / n, n, 1 / rate, DERIVATIVES[output_quantity(rig)])
    # What stands for the modes above has died out before a block begins.
    excitations = [
        tone_excitation(grid, s.tone.frequency_hz, complex(s.tone.amplitude[0]), len(STAND_INS)) for s in signals
    ]
    blocks = [LineBlock(e, np.fft.rfft(s.responses)[:, chosen], 0) for e, s in zip(excitations, signals, strict=True)]
    begin = with_stand_ins(start, band[1], STAND_INS, START_ZETA if max_iterations else ANY_ZETA)
    problem = _sine_problem(signals, blocks, begin)
    poles = poles_of(begin.omega, begin.zeta)
    steady = np.stack([e.steady_state(poles)[0] for e in excitations])
    parameters = SearchParameters(begin.omega, begin.zeta, steady, np.zeros(len(blocks), complex))
    if max_iterations:
        # Free from the beginning, what stands in for the modes above may take the place of a mode whose start is rough.
        held = replace(problem, fixed=np.arange(begin.omega.size) >= start.size)
        parameters = search_minimum(
            held, parameters, SearchLimits(FIRST_LOOK, states_first=STATES_FIRST)
        ).point.parameters
    found = search_minimum(
        problem, parameters, SearchLimits(max_iterations, states_first=0 if max_iterations else STATES_FIRST)
    )
    return LikelihoodFit(problem, found, (first.block.drive_point,))


def _sine_problem(signals: Sequence[Signals], blocks: Sequence[LineBlock], begin: StartPoles) -> LikelihoodProblem:
    n = signals[0].force.size
    force = np.array([np.abs(s.tone.amplitude[0]) for s in signals])
    noise = np.array([s.tone.residual_rms[0] for s in signals]) * np.sqrt(2 / n)
    # As good as free: force / (2 zeta omega) is the most a mode's state can be, a few times the force in N s.
    state_sigma: Real = np.repeat(100 * force[:, None], begin.omega.size, axis=1)
    # What stands in for the modes above the band has died out long before the block.
    state_sigma[:, -begin.stand_ins :] = 1e-9
    return LikelihoodProblem(
        blocks=blocks,
        powers=(0, 2, 4),
        n_inputs=1,
        state_sigma=state_sigma,
        drive_sigma=np.maximum(noise / force, 1e-9),
        zeta_prior=begin.zeta_prior,
    )


def _sine_readings(frf: Frf, fit: LikelihoodFit, keep: NDArray[np.bool_]) -> tuple[Real, Real]:
    found = np.sort(fit.point.parameters.omega[keep] / (2 * np.pi))
    return half_power_readings(frf, found), floor_of_steps(frf.frequency_hz, found)


def default_band(signals: Sequence[Signals]) -> tuple[float, float]:
    """From below the lowest to above the highest drive frequency: a mode there still answers, and still rings."""
    driven = [s.tone.frequency_hz for s in signals]
    return min(driven) / BAND_MARGIN, max(driven) * BAND_MARGIN


def clock_notes(signals: Sequence[Signals]) -> tuple[str, ...]:
    """What is to be said of the generator's clock, by which the measured frequencies are off the recorded ones."""
    offsets = [s.tone.frequency_hz / s.block.frequency_hz - 1 for s in signals if s.block.frequency_hz]
    clock = 1e6 * float(np.median(offsets))
    if not abs(clock) > CLOCK_PPM:
        return ()
    way = "slower" if clock < 0 else "faster"
    return (
        f"The generator's clock runs {abs(clock):.0f} ppm {way} than the converter's; the measured frequencies "
        "were used.",
    )
