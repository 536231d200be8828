"""A model in the form of another: in the same band, with the same terms for what lies outside it.

No few terms hold it exactly, and an identification lets its terms, and its modal constants a little, take up what they
can. In a valley between two modes, below the first one, and close to a mode just outside, that is several per cent of an
FRF. Two models identified in one form have it in common; one of a wider band, or with other terms, as a computed one,
has not, and that would pass for a gap.
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
BY_MODE = (
    "frequency_hz",
    "damping_ratio",
    "frequency_sigma_hz",
    "damping_sigma",
    "modal_constants",
    "modal_constant_sigma",
    "modal_constant_part_sigma",
    "shapes",
    "shape_sigma",
    "half_power",
    "half_power_floor",
    "operating_shapes",
    "operating_shape_sigma",
)
"""What a model holds of each mode."""
READ = DERIVATIVES["inertance"]
"""A fit of accelerations weighs lines by their acceleration."""


def in_form_of(model: ModalModel, band_hz: tuple[float, float], powers: tuple[int, ...]) -> ModalModel:
    """A model as an identification of its own FRFs in a band, with other terms, would give it.

    Args:
        model: with any terms, in a band at least as wide.
        band_hz: Hz.
        powers: of s of the terms; none where nothing is known of what lies outside. Then the modes are all there is.
    """
    low, high = band_hz
    inside = (model.frequency_hz >= low) & (model.frequency_hz <= high)
    same = np.all(inside) and (set(powers) == set(model.residual_powers) or not model.residual_powers)
    if same or not powers or not np.any(inside):
        return model
    hz = _lines(model, band_hz)
    s = np.asarray(2j * np.pi * hz)
    weight = np.sqrt(np.gradient(hz))[:, None] * s[:, None] ** READ
    each = kernels(model, s)
    columns = np.concatenate([each[:, inside], _terms(s, powers)], axis=1)
    beyond = np.concatenate([each[:, ~inside], _terms(s, model.residual_powers)], axis=1)
    left = np.concatenate([model.modal_constants[~inside], model.residuals])
    taken = np.einsum("pq,qoi->poi", _real_fit(weight * columns, weight * beyond), left)
    modes = int(np.sum(inside))
    kept = _of_modes(model, inside)
    changed = {"modal_constants": kept.modal_constants + taken[:modes], "residuals": taken[modes:].real}
    return kept.model_copy(update={**changed, "residual_powers": powers, "band_hz": band_hz})


def _of_modes(model: ModalModel, which: NDArray[np.bool_]) -> ModalModel:
    """Some of its modes."""
    arrays = {name: getattr(model, name) for name in BY_MODE}
    return model.model_copy(update={name: of[which] for name, of in arrays.items() if of is not None})


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
