"""Which modes make a response: what each gives to it, projected on the whole, over a band or over a time after a hit.

A response is the sum of the parts of its modes and of what lies outside the band. The share of a part is its
projection on the sum: shares add up to 1, and one that works against the others is negative (the modal contribution of
vibroacoustics). `alone` is the effective value of a part by itself over that of the sum.
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.units import DERIVATIVE, Quantity
from modallab.modification.known import FRF_SAMPLES, KnownStructure
from modallab.modification.structure import At, Structure

EVEN = 400
"""Lines spread evenly over a band; each mode has its own besides, as a peak is narrower than any even grid."""
ABOUT = np.linspace(-8, 8, 65)
"""Lines of a mode, in half of its half-power bandwidth."""


@dataclass(frozen=True, eq=False, slots=True)
class ModalParticipation:
    """Parts of a response to a force at one point.

    Attributes:
        at: the point of the force.
        of: the point of the motion.
        quantity: displacement, velocity or acceleration.
        band_hz: over which; None where it is over a time.
        after_s: over which time after a hit; None where it is over a band.
        share: (modes,) of the whole; all, with `outside`, add up to 1.
        share_sigma: (modes,) one standard deviation.
        alone: (modes,) effective value of a mode's part alone, over that of the whole.
        outside: share of what lies outside the band of the model; 0 over a time.
    """

    at: At
    of: At
    quantity: Quantity
    band_hz: tuple[float, float] | None
    after_s: tuple[float, float] | None
    share: Real
    share_sigma: Real
    alone: Real
    outside: float


def modal_participation(
    known: KnownStructure,
    at: At,
    of: At,
    quantity: Quantity = "velocity",
    band_hz: tuple[float, float] | None = None,
    after_s: tuple[float, float] | None = None,
) -> ModalParticipation:
    """The parts of a response to an even spectrum of force, or to a hit.

    Args:
        known: the structure.
        at: point of the force.
        of: point of the motion.
        quantity: displacement, velocity or acceleration.
        band_hz: over which; twice the same number for a single frequency; None for the band of the model.
        after_s: begin and end of a time after a hit, twice the same number for an instant; instead of a band.

    Raises:
        DataError: a band or a time that cannot be, a point that the model does not know, or no driving point.
    """
    structure, samples = known.measured_pairs([of], [at]), known.samples.first_samples(FRF_SAMPLES)
    if quantity not in DERIVATIVE:
        raise DataError(f"no motion is called {quantity!r}", remedy=f"use one of {', '.join(DERIVATIVE)}")
    if band_hz is not None and after_s is not None:
        raise DataError("both a band and a time are given", remedy="give band_hz or after_s")
    band = None if after_s is not None else _valid_band(structure, band_hz)
    _check_time(after_s)
    order, one, two = DERIVATIVE[quantity], structure.index(of), structure.index(at)
    whole, varied = (
        _integrals_of_products(s, one, two, order, band)
        if after_s is None
        else _integrals_over_time(s, one, two, order, after_s)
        for s in (structure, samples)
    )
    total = whole.sum()
    share = whole.sum(axis=1) / total
    spread = np.std(varied.sum(axis=-1) / varied.sum(axis=(-2, -1))[:, None], axis=0)
    alone, modes = np.sqrt(np.diag(whole) / total), len(structure.poles)
    return ModalParticipation(
        at, of, quantity, band, after_s, share[:modes], spread[:modes], alone[:modes], float(share[modes:].sum())
    )


def _valid_band(structure: Structure, band_hz: tuple[float, float] | None) -> tuple[float, float]:
    low, high = structure.band_hz
    if band_hz is None:
        return max(low, 1e-3 * high), high
    if not (low <= band_hz[0] <= band_hz[1] <= high and band_hz[0] > 0):
        raise DataError(
            f"the band {band_hz[0]:g} to {band_hz[1]:g} Hz is not within that of the model",
            remedy=f"stay within {low:.4g} to {high:.4g} Hz",
        )
    return band_hz


def _check_time(after_s: tuple[float, float] | None) -> None:
    if after_s is not None and not (0 <= after_s[0] <= after_s[1] < np.inf):
        raise DataError(
            f"{after_s[0]:g} to {after_s[1]:g} s is no time after a hit",
            remedy="give begin and end in s, such as (0, 0.1)",
        )


def _integrals_of_products(s: Structure, of: int, at: int, order: int, band_hz: tuple[float, float] | None) -> Real:
    """(..., parts, parts) integrals over a band of the products of all parts, what lies outside the band the last."""
    assert band_hz is not None
    hz, weights = _integration_lines(s, band_hz)
    z = 2j * np.pi * hz[..., :, None]
    product = (s.psi[..., of] * s.psi[..., at])[..., None, :]
    modes = product / (z - s.poles[..., None, :]) + product.conj() / (z - s.poles.conj()[..., None, :])
    powers = z ** np.array(s.powers, np.float64)
    outside = np.einsum("...lp,...p->...l", powers, s.residual[..., of, at])
    parts = np.concatenate([modes, outside[..., None]], axis=-1) * z**order
    return np.real(np.einsum("...l,...lr,...ls->...rs", weights, parts.conj(), parts, optimize=True))


def _integration_lines(s: Structure, band_hz: tuple[float, float]) -> tuple[Real, Real]:
    """(..., lines) frequencies in Hz that follow every peak, and their weights in an integral over the band."""
    low, high = band_hz
    if low == high:
        one = np.ones((*s.poles.shape[:-1], 1))
        return low * one, one
    own = (s.poles.imag[..., None] + s.poles.real[..., None] * ABOUT) / (2 * np.pi)
    own = own.reshape(*s.poles.shape[:-1], -1)
    even = np.broadcast_to(np.linspace(low, high, EVEN), (*own.shape[:-1], EVEN))
    hz = np.sort(np.clip(np.concatenate([even, own], axis=-1), low, high), axis=-1)
    step = np.diff(hz, axis=-1) / 2
    none = [(0, 0)] * (hz.ndim - 1)
    return hz, np.pad(step, [*none, (1, 0)]) + np.pad(step, [*none, (0, 1)])


def _integrals_over_time(s: Structure, of: int, at: int, order: int, after_s: tuple[float, float]) -> Real:
    """(..., modes, modes) integrals over a time of the products of the modes' motion after a hit of 1 N s."""
    each = s.psi[..., of] * s.psi[..., at] * s.poles**order
    pairs = ((each, s.poles), (each.conj(), s.poles.conj()))
    a, p = each[..., :, None], s.poles[..., :, None]
    return np.sum(
        [2 * np.real(a * b[..., None, :] * _integral_of_exponential(p + q[..., None, :], after_s)) for b, q in pairs],
        axis=0,
    )


def _integral_of_exponential(rate: Complex, after_s: tuple[float, float]) -> Complex:
    """Integral of exp(rate t) from begin to end; where both are equal, exp(rate t) at that instant."""
    begin, end = after_s
    if begin == end:
        return np.exp(rate * begin)
    return (np.exp(rate * end) - np.exp(rate * begin)) / rate
