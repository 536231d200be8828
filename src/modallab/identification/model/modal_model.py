"""The modal model of a fit, in the paper's form."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.identification.estimator import USUAL, find_estimator
from modallab.identification.likelihood.fit import Fit, residuals
from modallab.identification.likelihood.poles import poles_of
from modallab.identification.model.modal_mass import unit_mass_shapes
from modallab.identification.model.repeated_poles import Split, split_repeated

Residues = tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.float64]]
"""Modal constants (modes, outputs, inputs), the sigmas of their parts, and residual terms (powers, outputs, inputs)."""
FOLDED = tuple(range(9))
"""Powers of s that stand for a mode above the band; the odd ones for its damping."""
FOLDED_LINES = 400
"""Frequencies at which they are made to."""


def model_of_fit(
    fit: Fit,
    keep: NDArray[np.bool_],
    rig: Rig,
    test: Test | None,
    band_hz: tuple[float, float],
    readings: tuple[NDArray[np.float64], NDArray[np.float64]],
    notes: tuple[str, ...],
    method: str = USUAL,
    seen: Residues | None = None,
) -> ModalModel:
    """The model of the kept modes; the others are folded into the residual terms.

    Args:
        fit: the refined fit.
        keep: (modes,) which poles are modes of the band.
        rig: names and points of the channels.
        test: the test the blocks came from.
        band_hz: band of the lines used.
        readings: half-power readings and their floor, each (kept modes,) by rising frequency.
        notes: what was found on the way.
        method: the estimator that gave the start.
        seen: constants and residual terms that are not those of the fit.
    """
    at, sigma = fit.point.parameters, fit.pole_sigma
    constants, of_parts, terms = seen or (*fit.modal_constants, residuals(fit))
    output_points = tuple(c.point for c in rig.responses)
    ascending = np.flatnonzero(keep)[np.argsort(at.omega[keep])]
    split = split_repeated(constants[ascending], np.abs(of_parts[ascending]), output_points, fit.input_points)
    order = ascending[split.pole]
    shapes = unit_mass_shapes(split.constants, split.sigma, output_points, fit.input_points)
    powers, terms = _residual_terms(fit, keep, (constants, terms), band_hz)
    return ModalModel(
        method=method,
        test=test,
        band_hz=band_hz,
        frequency_hz=at.omega[order] / (2 * np.pi),
        damping_ratio=at.zeta[order],
        frequency_sigma_hz=sigma[order, 0] / (2 * np.pi),
        damping_sigma=sigma[order, 1],
        outputs=tuple(c.name for c in rig.responses),
        output_points=output_points,
        input_points=fit.input_points,
        modal_constants=split.constants,
        modal_constant_sigma=split.sigma,
        modal_constant_part_sigma=of_parts[order],
        residuals=terms,
        residual_powers=powers,
        shapes=shapes.phi,
        shape_sigma=shapes.sigma,
        shapes_unavailable=shapes.unavailable,
        half_power=readings[0][split.pole],
        half_power_floor=readings[1][split.pole],
        notes=(*notes, *_repeated_notes(split, at.omega[ascending] / (2 * np.pi))),
    )


def _repeated_notes(split: Split, frequency_hz: NDArray[np.float64]) -> tuple[str, ...]:
    return tuple(
        f"{count} modes share the pole at {frequency_hz[r]:.4g} Hz. Their shapes span a plane: any mix of them is a "
        "mode as well."
        for r, count in enumerate(np.bincount(split.pole))
        if count > 1
    )


def _residual_terms(
    fit: Fit,
    keep: NDArray[np.bool_],
    seen: tuple[NDArray[np.complex128], NDArray[np.float64]],
    band_hz: tuple[float, float],
) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    """The fit's residual terms, with each mode left out (above the kept ones) added as a sum of powers of s."""
    at, (constants, own) = fit.point.parameters, seen
    powers = sorted({*fit.problem.powers, *(FOLDED if not np.all(keep) else ())})
    terms = np.zeros((len(powers), *constants.shape[1:]))
    for power, term in zip(fit.problem.powers, own, strict=True):
        terms[powers.index(power)] += term
    poles = poles_of(at.omega, at.zeta)
    for r in np.flatnonzero(~keep & (at.omega > np.max(at.omega[keep], initial=0.0))):
        residue = constants[r] / (2j * poles[r].imag)
        for power, (along, across) in zip(FOLDED, _as_powers(complex(poles[r]), band_hz), strict=True):
            terms[powers.index(power)] += along * residue.real + across * residue.imag
    return tuple(powers), terms


def _as_powers(pole: complex, band_hz: tuple[float, float]) -> NDArray[np.float64]:
    """Factors (powers, 2) of the powers of s that stand in the band for a pole pair of residue 1, and of residue j.

    By least squares over the band's mobility: the Taylor series of a pole just above the band hardly converges there.
    """
    omega = np.linspace(max(band_hz[0], 1e-3 * band_hz[1]), band_hz[1], FOLDED_LINES) * 2 * np.pi
    s, top = 1j * omega, float(omega[-1])
    up, down = s / (s - pole), s / (s - pole.conjugate())
    columns = np.stack([s * (s / top) ** power for power in FOLDED], axis=1)
    values = np.stack([up + down, 1j * (up - down)], axis=1)
    factors = np.linalg.lstsq(np.vstack([columns.real, columns.imag]), np.vstack([values.real, values.imag]))[0]
    return np.asarray(factors / top ** np.array(FOLDED, dtype=np.float64)[:, None], np.float64)


def without_sigma(model: ModalModel) -> ModalModel:
    """The same model, its sigmas unknown: a covariance is that of the maximum of the likelihood and of nothing else."""
    called = find_estimator(model.method).called
    return model.model_copy(
        update={
            "frequency_sigma_hz": np.full(model.n_modes, np.nan),
            "damping_sigma": np.full(model.n_modes, np.nan),
            "modal_constant_sigma": np.full(model.modal_constants.shape, np.nan),
            "modal_constant_part_sigma": None,
            "shape_sigma": None,
            "notes": (
                *model.notes,
                f"The poles are those of {called}, not refined: their uncertainty is not known.",
            ),
        }
    )


def receptance(model: ModalModel, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """The model's receptance (outputs, inputs, lines), with no block and no truncation: eqs. 13 and 14.

    Raises:
        DataError: frequencies that are none, or 0 Hz where a residual term has no value there.
    """
    if frequency_hz.ndim != 1 or not np.isfinite(frequency_hz).all():
        raise DataError(f"frequencies {frequency_hz.shape} are no lines, or not finite", remedy="give (lines,) in Hz")
    if min(model.residual_powers, default=0) < 0 and np.any(frequency_hz == 0):
        raise DataError("the residual terms have no value at 0 Hz", remedy="leave that line out")
    s = 2j * np.pi * frequency_hz
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    residue = model.modal_constants / (2j * poles.imag[:, None, None])
    value = np.einsum("moi,mk->oik", residue, 1 / (s - poles[:, None]))
    value += np.einsum("moi,mk->oik", residue.conj(), 1 / (s - poles.conj()[:, None]))
    for power, term in zip(model.residual_powers, model.residuals, strict=True):
        value += term[..., None] * s**power
    return value
