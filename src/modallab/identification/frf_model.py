"""Identification of FRFs that came as such, from a source without time records."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frf
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import FrfEstimator
from modallab.frf.estimate import convert_frf
from modallab.frf.joined import RecordSpectra
from modallab.identification.estimate import PoleEstimate, estimate_poles, poles_without_stability
from modallab.identification.likelihood.basis import edges_of_stand_ins, poles_of
from modallab.identification.likelihood.driven_records import OF_H2, DrivenFit, DrivenModel
from modallab.identification.likelihood.equations import ParameterCovariance
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import WORDS, fit_frf, line_weights, quantity_of_even_noise
from modallab.identification.likelihood.search import FIRST_LOOK, MIN_ZETA, NOT_SETTLED
from modallab.identification.model.modal_model import FitReadings, model_of_fit, readings_of_fit, without_sigma
from modallab.identification.options import IdentificationOptions
from modallab.identification.readings import half_power_readings
from modallab.identification.selection.lost_modes import restore_lost_modes
from modallab.identification.selection.operator_choice import chosen_modes, poles_to_search, start_poles
from modallab.identification.setups.agreed import agreed_modes


@dataclass(frozen=True, eq=False, slots=True)
class FitToRecords:
    """The most likely model of records.

    Attributes:
        fit: of the FRFs, with the poles of the records and their covariance.
        stay: (modes,) which modes of the fit of the FRFs it holds.
        seen: what else a model takes.
        notes: what is to be said of the noise on the force.
    """

    fit: LikelihoodFit
    stay: NDArray[np.int64]
    seen: FitReadings
    notes: tuple[str, ...]


def fit_on_records(
    frf: Frf, fit: LikelihoodFit, keep: NDArray[np.bool_], records: RecordSpectra, estimator: FrfEstimator
) -> FitToRecords:
    """The most likely model of records, without the modes that only the fit of the FRFs needs.

    Args:
        frf: of one force.
        fit: of them.
        keep: (modes,) which poles are modes.
        records: of that force.
        estimator: whose the noise on the force is taken to be.

    Raises:
        IdentificationError: poles that cannot be distinguished.
    """
    problem, at = fit.problem, fit.point.parameters
    driven = DrivenFit(records, problem.powers, problem.blocks[0].excitation.grid.p, estimator)
    found = driven.search(at.omega, at.zeta, fit.point.groups[0].coefficients)
    found, stay = driven.needed(found, keep)
    there, n = fit_frf(frf, poles_of(found.omega, found.zeta), 0, stand_ins=()), 2 * stay.size
    covariance = ParameterCovariance.of_poles(found.covariance[:n, :n])
    refined = replace(there.refined, covariance=covariance, settled=True)
    better = replace(there, refined=refined)
    constants, sigma = _modal_constants(found)
    noise = float(np.median(1 - driven.true_share(found.force_noise)))
    parts = _with_bias(constants, sigma, noise, estimator)
    seen = replace(
        readings_of_fit(better), constants=constants, sigma_of_parts=parts, terms=found.coefficients[n:, :, None]
    )
    known = float(np.min(np.abs(sigma) / np.maximum(np.abs(constants), np.finfo(float).tiny), initial=np.inf))
    return FitToRecords(better, stay, seen, _noise_note(noise, estimator, known))


def _modal_constants(found: DrivenModel) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Modal constants and their sigmas, each (modes, outputs, 1), as `LikelihoodFit.modal_constants` has them."""
    n, size = 2 * found.omega.size, found.coefficients.size
    sigma = np.sqrt(np.diag(found.covariance)[n : n + size]).reshape(found.coefficients.shape[::-1]).T
    scale = 2 * poles_of(found.omega, found.zeta).imag[:, None, None]
    values, sigmas = (part[:n].reshape(found.omega.size, 2, -1) for part in (found.coefficients, sigma))
    residue = values[:, 0] + 1j * values[:, 1]
    return 1j * scale * residue[..., None], scale * (sigmas[:, 1] + 1j * sigmas[:, 0])[..., None]


def _with_bias(
    constants: NDArray[np.complex128], sigma: NDArray[np.complex128], noise: float, estimator: FrfEstimator
) -> NDArray[np.complex128]:
    """Sigmas of the parts with that of the bias, which is one of two that the records do not choose between.

    Noise on the force channel makes the constants too low by one share of the noise's power, a force that was not
    measured makes them too high by the rest of it. Either is as likely: the bias counts by the mean of their squares.
    """
    of_h2 = OF_H2[estimator]
    bias = noise * np.sqrt(((1 - of_h2) ** 2 + of_h2**2) / 2)
    return np.hypot(sigma.real, bias * constants.real) + 1j * np.hypot(sigma.imag, bias * constants.imag)


def _noise_note(noise: float, estimator: FrfEstimator, known: float) -> tuple[str, ...]:
    """A bias that the best known modal constant would not show is not worth a word."""
    if noise < known:
        return ()
    low, high = 100 * noise * (1 - OF_H2[estimator]), 100 * noise * OF_H2[estimator]
    on_channel = f"{estimator} and the modal constants are {low:.2g} % low" if low else f"{estimator} is right"
    in_force = f"they are {high:.2g} % high" if high else "they are right"
    return (
        f"Noise on the force, {100 * np.sqrt(noise):.2g} % of it, is in the uncertainties, as is its bias. If the "
        f"force channel makes it, {on_channel}. If it is a force that was not measured, {in_force}.",
    )


NOT_FROM_RECORDS = "Identified from FRFs, not from time records: what a block's end cut off could not be modelled."


def frf_in_band(frf: Frf, band_hz: tuple[float, float] | None) -> Frf:
    """The FRF at the lines of a band, None for all of them; never at 0 Hz, where mobility has no receptance.

    Raises:
        DataError: the FRF is not finite, its lines do not ascend, or it has no phase.
        IdentificationError: fewer than eight lines lie inside.
    """
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=False)
    inside = frf.frequency_hz > 0
    if band_hz is not None:
        inside &= (frf.frequency_hz >= band_hz[0]) & (frf.frequency_hz <= band_hz[1])
    # Lines ascend, so those of a band are neighbours, and looking at them needs no copy.
    lines = slice(int(np.argmax(inside)), int(np.argmax(inside)) + int(np.count_nonzero(inside)))
    used = replace(
        frf,
        frequency_hz=frf.frequency_hz[lines],
        values=frf.values[..., lines],
        coherence=None if frf.coherence is None else frf.coherence[..., lines],
        variance=None if frf.variance is None else frf.variance[..., lines],
    )
    if used.frequency_hz.size < 8:
        raise IdentificationError(
            f"the band holds {used.frequency_hz.size} lines of the FRF", remedy="widen the band to at least 8 lines"
        )
    return used


def identify_given_frf(frf: Frf, rig: Rig, options: IdentificationOptions) -> tuple[ModalModel, LikelihoodFit]:
    """Modal model of FRFs of which nobody says what was measured: the same in whatever quantity they are given.

    Where nothing says how well each line is known, noise is taken as even in the quantity in which what is left is.

    Raises:
        DataError, IdentificationError: as `identify_frf`; or they are complex conjugates.
    """
    try:
        return _in_quantity_of_even_noise(frf, rig, options)
    except IdentificationError:
        if not _turns_back(frf, rig, options):
            raise
    raise IdentificationError(
        "the FRFs are complex conjugates: their phase rises through the resonances, as of exp(-j omega t)",
        remedy="turn the sign of their imaginary parts or phases",
    )


def _turns_back(frf: Frf, rig: Rig, options: IdentificationOptions) -> bool:
    """Whether the conjugates of FRFs without modes have modes."""
    try:
        identify_frf(replace(frf, values=frf.values.conj()), rig, options)
    except IdentificationError:
        return False
    return True


def _in_quantity_of_even_noise(frf: Frf, rig: Rig, options: IdentificationOptions) -> tuple[ModalModel, LikelihoodFit]:
    used = frf_in_band(frf, options.band_hz)
    if not options.refined or line_weights(used) is not None:
        return identify_frf(frf, rig, options)
    try:
        _, fit = found = identify_frf(convert_frf(used, "inertance"), rig, options)
    except IdentificationError:
        return identify_frf(frf, rig, options)
    quantity = quantity_of_even_noise(fit)
    model, fit = found if quantity == "inertance" else identify_frf(convert_frf(used, quantity), rig, options)
    note = WORDS.format(quantity=quantity)
    return model.model_copy(update={"notes": (*model.notes, note)}), fit


def identify_frf(
    frf: Frf, rig: Rig, options: IdentificationOptions, records: RecordSpectra | None = None
) -> tuple[ModalModel, LikelihoodFit]:
    """Modal model of measured FRFs, taken as those of the structure: how they were truncated is not known.

    Where nothing says how well each line is known, noise is taken as even in the quantity that they are given in.
    `records` of one random force are what the FRFs were made of: the modes found are fitted to them.

    Raises:
        DataError: the FRF is not finite, its lines do not ascend, or it has no phase.
        IdentificationError: no stable pole.
    """
    used = frf_in_band(frf, options.band_hz)
    band = (float(used.frequency_hz[0]), float(used.frequency_hz[-1]))
    estimate = estimate_poles(used, options.method, options.max_order)
    fit = fit_frf(used, _start_poles(used, estimate, band, options), FIRST_LOOK if options.refined else 0)
    points = agreed_modes(used, fit, options) if options.refined else None
    if points is not None:
        keep = np.isinf(points.fit.problem.zeta_prior[:, 1])
        said = (NOT_FROM_RECORDS,), points.notes
        return _model_of_kept(used, points.fit, keep, rig, band, options, said, points.seen), points.fit
    fit, keep, lost = _select_modes(used, fit, estimate, band, options)
    source, seen = (NOT_FROM_RECORDS,), None
    if records is not None and options.refined:
        better = fit_on_records(used, fit, keep, records, options.frf)
        # A pole that the records move out of the band stands for modes outside it.
        fit, keep, seen = better.fit, keep[better.stay] & better.fit.inside(band), better.seen
        source = better.notes
    said = source, (*lost, *(() if fit.refined.settled or not options.refined else (NOT_SETTLED,)))
    return _model_of_kept(used, fit, keep, rig, band, options, said, seen), fit


def _start_poles(
    frf: Frf, estimate: PoleEstimate, band_hz: tuple[float, float], options: IdentificationOptions
) -> NDArray[np.complex128]:
    """(poles,) where the search begins: the stable ones and those picked, else the one that stands alone."""
    poles = start_poles(estimate.poles, estimate.orders, options)
    if poles.size == 0 and options.refined:
        poles = poles_without_stability(frf, estimate)
    if poles.size == 0:
        raise IdentificationError(
            f"no pole of {options.estimator.called} between {band_hz[0]:.4g} and {band_hz[1]:.4g} Hz is stable",
            remedy="widen the band, or look at the FRFs: is there a resonance in them at all?",
        )
    return poles


def _select_modes(
    frf: Frf, fit: LikelihoodFit, estimate: PoleEstimate, band_hz: tuple[float, float], options: IdentificationOptions
) -> tuple[LikelihoodFit, NDArray[np.bool_], tuple[str, ...]]:
    """The fit of the poles that are modes, which these are, and what is to be said of modes lost on the way."""
    keep = chosen_modes(fit, band_hz, options, first=True)
    if options.refined and np.any(keep) and not (np.all(keep[:-1]) and fit.refined.settled):
        at, stay = fit.point.parameters, poles_to_search(fit, keep, band_hz, options)
        start = -at.zeta[stay] * at.omega[stay] + 1j * at.omega[stay]
        fit = fit_frf(frf, start, stand_ins=edges_of_stand_ins(at.omega, band_hz[1]))
        keep = chosen_modes(fit, band_hz, options, first=False)
    lost: tuple[str, ...] = ()
    if options.refined and not options.pick_hz and not options.drop_hz:
        fit, keep, lost = restore_lost_modes(frf, fit, keep, estimate.orders, band_hz)
    if not np.any(keep):
        raise _no_mode_error(fit, band_hz)
    return fit, keep, lost


def _model_of_kept(
    frf: Frf,
    fit: LikelihoodFit,
    keep: NDArray[np.bool_],
    rig: Rig,
    band_hz: tuple[float, float],
    options: IdentificationOptions,
    said: tuple[tuple[str, ...], tuple[str, ...]],
    seen: FitReadings | None,
) -> ModalModel:
    """The model of the kept poles; `said` stands before and behind what is said of an exponential window."""
    found = np.sort(fit.point.parameters.omega[keep]) / (2 * np.pi)
    readings = half_power_readings(frf, found), np.full(found.size, np.nan)
    notes = *said[0], *_window_note(frf, found), *said[1]
    model = model_of_fit(fit, keep, rig, None, band_hz, readings, notes, options.method, seen)
    return model if options.refined else without_sigma(model)


def _no_mode_error(fit: LikelihoodFit, band: tuple[float, float]) -> IdentificationError:
    what = f"no mode stands out of the noise between {band[0]:.4g} and {band[1]:.4g} Hz"
    at = fit.point.parameters
    undamped = np.sort(at.omega[fit.inside(band) & (at.zeta <= 2 * MIN_ZETA)]) / (2 * np.pi)
    if not undamped.size:
        return IdentificationError(what, remedy="widen the band")
    listed = ", ".join(f"{one:.5g}" for one in undamped)
    return IdentificationError(
        f"{what}: at {listed} Hz there is a peak, but its lines have not the course of a resonance, and its damping"
        " comes out as none",
        remedy="look at the coherence there; average more blocks, or record longer ones",
    )


def _window_note(frf: Frf, found_hz: NDArray[np.float64]) -> tuple[str, ...]:
    if frf.damping_shift == 0 or not found_hz.size:
        return ()
    tau, most = 1 / frf.damping_shift, 100 * frf.damping_shift / (2 * np.pi * found_hz.min())
    return (
        f"The damping of an exponential window of {tau:.4g} s is taken off: 1 / (tau omega), {most:.3g} % at "
        f"{found_hz.min():.4g} Hz. Half-power readings hold it still.",
    )
