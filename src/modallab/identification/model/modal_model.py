"""The modal model of a fit, in the paper's form.

Hits at a point are fitted together, and each weighs by the power of its force. One that is short drives the high modes
and one that is long does not, so that the mean place of the hits is another one for each mode.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.identification.estimator import USUAL, find_estimator
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.fit import LikelihoodFit, residual_coefficients
from modallab.identification.likelihood.orthonormal import complex_lines
from modallab.identification.model.modal_mass import driving_points, unit_mass_shapes
from modallab.identification.model.repeated_poles import SplitConstants, split_repeated
from modallab.signals.signals import Signals

POWERS = tuple(range(17))
"""Powers of s of the receptance; the odd ones for the modes' damping. So a mode 5 % above is met to 0.3 %, one at
the edge to 5 %, but for the last lines."""
LINES = 400
"""Frequencies at which they are made to stand for a mode."""


def fold_into_residuals(
    poles: NDArray[np.complex128], constants: NDArray[np.complex128], band_hz: tuple[float, float]
) -> NDArray[np.float64]:
    """Coefficients (powers, outputs, inputs) of the powers that stand in the band for modes above it.

    Args:
        poles: (modes,) rad/s, of positive imaginary part.
        constants: (modes, outputs, inputs) modal constants.
        band_hz: the band.
    """
    factors = np.array([_residual_factors(complex(pole), band_hz) for pole in poles]).reshape(
        len(poles), len(POWERS), 2
    )
    residues = constants / (2j * poles.imag[:, None, None])
    parts = np.stack([residues.real, residues.imag], axis=1)
    return np.asarray(np.einsum("rpk,rkoi->poi", factors, parts), np.float64)


def _residual_factors(pole: complex, band_hz: tuple[float, float]) -> NDArray[np.float64]:
    """Factors (powers, 2) of the powers of s that stand in the band for a pole pair of residue 1, and of residue j.

    By least squares over the band, relative to the mode: the Taylor series of a pole just above the band hardly
    converges, and absolute errors would be those of its resonance alone, wherever in the band they act.
    """
    omega = np.linspace(max(band_hz[0], 1e-3 * band_hz[1]), band_hz[1], LINES) * 2 * np.pi
    s, top = 1j * omega, float(omega[-1])
    up, down = 1 / (s - pole), 1 / (s - pole.conjugate())
    weight = 1 / np.abs(up - down)
    columns = weight[:, None] * np.stack([(s / top) ** power for power in POWERS], axis=1)
    values = weight[:, None] * np.stack([up + down, 1j * (up - down)], axis=1)
    factors = np.linalg.lstsq(np.vstack([columns.real, columns.imag]), np.vstack([values.real, values.imag]))[0]
    return np.asarray(factors / top ** np.array(POWERS, dtype=np.float64)[:, None], np.float64)


def with_hit_shares(model: ModalModel, groups: Sequence[Sequence[Signals]]) -> ModalModel:
    """The model with the share of each hit.

    Args:
        model: of all hits.
        groups: the hits by point, in the order of its inputs.
    """
    omega = 2 * np.pi * model.frequency_hz
    shares = np.zeros((model.n_modes, len(groups), max(map(len, groups))))
    for k, hits in enumerate(groups):
        power = np.array([_power_at(omega, hit) for hit in hits]).T
        shares[:, k, : len(hits)] = power / power.sum(axis=1, keepdims=True)
    return model.model_copy(update={"hit_shares": shares})


def _power_at(omega: np.ndarray, hit: Signals) -> np.ndarray:
    times = np.arange(hit.force.size) / hit.rate_hz
    return np.asarray(np.abs(np.exp(-1j * omega[:, None] * times) @ hit.hit_force) ** 2)


@dataclass(frozen=True, eq=False, slots=True)
class FitReadings:
    """What a model takes of a fit beside its poles.

    Attributes:
        constants: (modes, outputs, inputs) modal constants.
        sigma_of_parts: (modes, outputs, inputs) as `LikelihoodFit.modal_constants` has it.
        terms: (powers, outputs, inputs) residual terms.
        apparent: (modes,) share of a mode's constants that misfit or scatter can pass off as another mode's.
    """

    constants: NDArray[np.complex128]
    sigma_of_parts: NDArray[np.complex128]
    terms: NDArray[np.float64]
    apparent: NDArray[np.float64]


def readings_of_fit(fit: LikelihoodFit) -> FitReadings:
    """What a model takes of a fit."""
    constants, sigma = fit.modal_constants
    return FitReadings(constants, sigma, residual_coefficients(fit), _apparent_misfit(fit, constants))


def _apparent_misfit(fit: LikelihoodFit, constants: NDArray[np.complex128]) -> NDArray[np.float64]:
    """(modes,) the misfit of FRFs within each mode's width, over the height of its peak; 0 of blocks.

    Where one pole does not explain all FRFs of a mode, what is left takes the place of a second shape.
    """
    at = fit.point.parameters
    if fit.channels is None:
        return np.zeros(at.omega.size)
    grid = fit.problem.blocks[0].excitation.grid
    left = np.sum(np.abs(complex_lines(fit.point.groups[0].residual)) ** 2, axis=0)
    height = np.linalg.norm(constants.reshape(at.omega.size, -1), axis=1) * at.omega ** (grid.p - 2) / (2 * at.zeta)
    near = np.abs(grid.omega - at.omega[:, None]) <= np.maximum(at.zeta * at.omega, np.diff(grid.omega).max())[:, None]
    lines = np.maximum(near.sum(axis=1), 1)
    return np.asarray(np.sqrt(near @ left / lines) / np.maximum(height, np.finfo(float).tiny), np.float64)


def model_of_fit(
    fit: LikelihoodFit,
    keep: NDArray[np.bool_],
    rig: Rig,
    test: Test | None,
    band_hz: tuple[float, float],
    readings: tuple[NDArray[np.float64], NDArray[np.float64]],
    notes: tuple[str, ...],
    method: str = USUAL,
    seen: FitReadings | None = None,
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
        seen: of points that disagree, what is not that of the fit.
    """
    at, sigma = fit.point.parameters, fit.pole_sigma
    used = seen or readings_of_fit(fit)
    constants, of_parts = used.constants, used.sigma_of_parts
    output_points, driving = tuple(c.point for c in rig.responses), driving_points(rig)
    ascending = np.flatnonzero(keep)[np.argsort(at.omega[keep])]
    split = split_repeated(
        constants[ascending],
        np.abs(of_parts[ascending]),
        driving,
        fit.input_points,
        used.apparent[ascending],
    )
    order = ascending[split.pole]
    shapes = unit_mass_shapes(split.constants, split.sigma, output_points, fit.input_points, driving)
    powers, terms = _residual_terms(fit, keep, (constants, used.terms), band_hz)
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


def _repeated_notes(split: SplitConstants, frequency_hz: NDArray[np.float64]) -> tuple[str, ...]:
    return tuple(
        f"{count} modes share the pole at {frequency_hz[r]:.4g} Hz. Their shapes span a plane: any mix of them is a "
        "mode as well."
        for r, count in enumerate(np.bincount(split.pole))
        if count > 1
    )


def _residual_terms(
    fit: LikelihoodFit,
    keep: NDArray[np.bool_],
    seen: tuple[NDArray[np.complex128], NDArray[np.float64]],
    band_hz: tuple[float, float],
) -> tuple[tuple[int, ...], NDArray[np.float64]]:
    """The fit's residual terms, with each mode left out (above the kept ones) added as a sum of powers of s."""
    at, (constants, own) = fit.point.parameters, seen
    powers = sorted({*fit.problem.powers, *(POWERS if not np.all(keep) else ())})
    terms = np.zeros((len(powers), *constants.shape[1:]))
    for power, term in zip(fit.problem.powers, own, strict=True):
        terms[powers.index(power)] += term
    above = ~keep & (at.omega > np.max(at.omega[keep], initial=0.0))
    for power, term in zip(
        POWERS, fold_into_residuals(poles_of(at.omega, at.zeta)[above], constants[above], band_hz), strict=True
    ):
        if power in powers:
            terms[powers.index(power)] += term
    return tuple(powers), terms


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


def receptance_of_model(
    model: ModalModel, frequency_hz: NDArray[np.float64], damping_shift: float = 0.0
) -> NDArray[np.complex128]:
    """The model's receptance (outputs, inputs, lines), with no block and no truncation: eqs. 13 and 14.

    Args:
        model: poles, modal constants and residual terms.
        frequency_hz: (lines,)
        damping_shift: rate in 1/s: at s = damping_shift + j omega, as an exponential window leaves an FRF.

    Raises:
        DataError: frequencies that are none, or 0 Hz where a residual term has no value there.
    """
    if frequency_hz.ndim != 1 or not np.isfinite(frequency_hz).all():
        raise DataError(f"frequencies {frequency_hz.shape} are no lines, or not finite", remedy="give (lines,) in Hz")
    if min(model.residual_powers, default=0) < 0 and damping_shift == 0 and np.any(frequency_hz == 0):
        raise DataError("the residual terms have no value at 0 Hz", remedy="leave that line out")
    s = damping_shift + 2j * np.pi * frequency_hz
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    residue = model.modal_constants / (2j * poles.imag[:, None, None])
    value = np.einsum("moi,mk->oik", residue, 1 / (s - poles[:, None]))
    value += np.einsum("moi,mk->oik", residue.conj(), 1 / (s - poles.conj()[:, None]))
    for power, term in zip(model.residual_powers, model.residuals, strict=True):
        value += term[..., None] * s**power
    return value
