"""FRFs of a modal model at complex frequencies (eq. 13)."""

import numpy as np

from modallab.core.arrays import Complex
from modallab.core.model import ModalModel


def receptance_of_modes(model: ModalModel, s: Complex) -> Complex:
    """(lines, modes) receptance of each mode of unit constant at complex frequencies."""
    omega, zeta = 2 * np.pi * model.frequency_hz, model.damping_ratio
    return np.asarray(1 / (s[:, None] ** 2 + 2 * zeta * omega * s[:, None] + omega**2))


def receptances_of_model(model: ModalModel, s: Complex) -> Complex:
    """(lines, outputs, inputs) receptances of a model at complex frequencies (lines,)."""
    return np.einsum("lr,roi->loi", receptance_of_modes(model, s), model.modal_constants) + outside_band_receptances(
        model, s
    )


def outside_band_receptances(model: ModalModel, s: Complex) -> Complex:
    """(lines, outputs, inputs) what lies outside the band."""
    powers = s[:, None] ** np.array(model.residual_powers, dtype=float)
    return np.einsum("lp,poi->loi", powers, model.residuals.astype(np.complex128))


def frfs_without_shapes(model: ModalModel, s: Complex, out: Complex, into: Complex) -> Complex:
    """(lines, outputs, inputs) FRFs without the products of shapes out (outputs, modes) and into (inputs, modes)."""
    return receptances_of_model(model, s) - np.einsum("lr,or,ir->loi", receptance_of_modes(model, s), out, into)
