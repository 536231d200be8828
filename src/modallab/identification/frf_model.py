"""Identification of FRFs that came as such, from a source without time records."""

from dataclasses import replace

import numpy as np

from modallab.core.array_checks import check_frf
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.identification.estimate import estimate_poles
from modallab.identification.likelihood.fit import Fit
from modallab.identification.likelihood.frf_fit import fit_frf
from modallab.identification.likelihood.search import FIRST_LOOK, NOT_SETTLED
from modallab.identification.model.modal_model import model_of_fit, without_sigma
from modallab.identification.options import Options
from modallab.identification.readings import half_power_readings
from modallab.identification.selection.operator_choice import chosen, in_fit, start_poles
from modallab.identification.setups.agreed import Agreed, agreed

NOT_FROM_RECORDS = "Identified from FRFs, not from time records: what a block's end cut off could not be modelled."


def in_band(frf: Frf, band_hz: tuple[float, float] | None) -> Frf:
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
        frf, frequency_hz=frf.frequency_hz[lines], values=frf.values[..., lines], coherence=None, variance=None
    )
    if used.frequency_hz.size < 8:
        raise IdentificationError(
            f"the band holds {used.frequency_hz.size} lines of the FRF", remedy="widen the band to at least 8 lines"
        )
    return used


def identify_frf(frf: Frf, rig: Rig, options: Options) -> tuple[ModalModel, Fit]:
    """Modal model of measured FRFs, taken as those of the structure: how they were truncated is not known.

    Raises:
        DataError: the FRF is not finite, its lines do not ascend, or it has no phase.
        IdentificationError: no stable pole.
    """
    used = in_band(frf, options.band_hz)
    band = (float(used.frequency_hz[0]), float(used.frequency_hz[-1]))
    estimate = estimate_poles(used, options.method, options.max_order)
    poles = start_poles(estimate.poles, estimate.orders, options)
    if poles.size == 0:
        raise IdentificationError(
            f"no pole of {options.estimator.called} between {band[0]:.4g} and {band[1]:.4g} Hz is stable",
            remedy="widen the band, or look at the FRFs: is there a resonance in them at all?",
        )
    fit = fit_frf(used, poles, FIRST_LOOK if options.refined else 0)
    points = agreed(used, fit, options) if options.refined else None
    if points is not None:
        return _of_points(points, used, rig, band, options), points.fit
    keep = chosen(fit, band, options, first=True)
    if options.refined and np.any(keep) and not (np.all(keep) and fit.refined.settled):
        at, stay = fit.point.parameters, in_fit(fit, keep, band, options)
        fit = fit_frf(used, -at.zeta[stay] * at.omega[stay] + 1j * at.omega[stay])
        keep = chosen(fit, band, options, first=False)
    if not np.any(keep):
        raise IdentificationError(
            f"no mode stands out of the noise between {band[0]:.4g} and {band[1]:.4g} Hz", remedy="widen the band"
        )
    found = np.sort(fit.point.parameters.omega[keep]) / (2 * np.pi)
    read = half_power_readings(used, found)
    notes = (
        NOT_FROM_RECORDS,
        *(() if fit.refined.settled or not options.refined else (NOT_SETTLED,)),
    )
    floor = np.full(found.size, np.nan)
    model = model_of_fit(fit, keep, rig, None, band, (read, floor), notes, options.method)
    return model if options.refined else without_sigma(model), fit


def _of_points(points: Agreed, frf: Frf, rig: Rig, band: tuple[float, float], options: Options) -> ModalModel:
    fit = points.fit
    found = np.sort(fit.point.parameters.omega) / (2 * np.pi)
    readings = half_power_readings(frf, found), np.full(found.size, np.nan)
    keep = np.ones(found.size, bool)
    notes = NOT_FROM_RECORDS, *points.notes
    return model_of_fit(fit, keep, rig, None, band, readings, notes, options.method, points.seen)
