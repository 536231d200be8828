"""A reference in the form in which the bench was identified: the same terms for what lies outside the band.

No few terms hold it exactly, and an identification lets its terms, and its modal constants a little, take up what they
can. In a valley between two modes, and below the first one, that is several per cent of an FRF. Two models identified
in one form have it in common; one with other terms, as a computed one, has not, and that would pass for a gap.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import DERIVATIVES
from modallab.core.model import ModalModel
from modallab.modification.synthesis import kernels

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

LINES = 400
"""Evenly over the band, besides those about the modes."""
ABOUT = np.linspace(-6.0, 6.0, 49)
"""Lines about a mode, in half widths of its resonance."""
READ = DERIVATIVES["inertance"]
"""A fit of accelerations weighs lines by their acceleration."""


def in_form_of(bench: ModalModel, reference: ModalModel) -> ModalModel:
    """The reference as an identification of its own FRFs, in the bench's band and with its terms, would give it.

    Args:
        bench: identified, on the reference's outputs and inputs.
        reference: with any terms; with the bench's own it is given back as it is.
    """
    powers = bench.residual_powers
    if set(powers) == set(reference.residual_powers) or not powers or not reference.residual_powers:
        return reference
    hz = _lines(reference, bench.band_hz)
    s = np.asarray(2j * np.pi * hz)
    weight = np.sqrt(np.gradient(hz))[:, None] * s[:, None] ** READ
    columns = np.concatenate([kernels(reference, s), _terms(s, powers)], axis=1)
    taken = _real_fit(weight * columns, weight * _terms(s, reference.residual_powers))
    modes = reference.n_modes
    constants = np.einsum("rq,qoi->roi", taken[:modes], reference.residuals)
    return reference.model_copy(
        update={
            "modal_constants": reference.modal_constants + constants,
            "residuals": np.einsum("pq,qoi->poi", taken[modes:], reference.residuals),
            "residual_powers": powers,
        }
    )


def _lines(reference: ModalModel, band_hz: tuple[float, float]) -> Real:
    low, high = band_hz
    near = (reference.frequency_hz * (1 + reference.damping_ratio * a) for a in ABOUT)
    hz = np.unique(np.concatenate([np.linspace(max(low, 1e-3 * high), high, LINES), *near]))
    return hz[(hz >= low) & (hz <= high) & (hz > 0)]


def _terms(s: Complex, powers: tuple[int, ...]) -> Complex:
    return np.asarray(s[:, None] ** np.array(powers, float))


def _real_fit(columns: Complex, of: Complex) -> Real:
    """(columns, of) real coefficients by least squares."""
    both = np.concatenate([columns.real, columns.imag])
    size = np.linalg.norm(both, axis=0)
    wanted = np.concatenate([of.real, of.imag])
    return np.linalg.lstsq(both / size, wanted, rcond=None)[0] / size[:, None]
