"""FRFs of a modal model at complex frequencies (eq. 13)."""

import numpy as np

from modallab.core.arrays import Complex
from modallab.core.model import ModalModel


def kernels(model: ModalModel, s: Complex) -> Complex:
    """(lines, modes) receptance of each mode of unit constant at complex frequencies."""
    omega, zeta = 2 * np.pi * model.frequency_hz, model.damping_ratio
    return np.asarray(1 / (s[:, None] ** 2 + 2 * zeta * omega * s[:, None] + omega**2))


def synthesised(model: ModalModel, s: Complex) -> Complex:
    """(lines, outputs, inputs) receptances of a model at complex frequencies (lines,)."""
    return np.einsum("lr,roi->loi", kernels(model, s), model.modal_constants) + outside(model, s)


def outside(model: ModalModel, s: Complex) -> Complex:
    """(lines, outputs, inputs) what lies outside the band."""
    powers = s[:, None] ** np.array(model.residual_powers, dtype=float)
    return np.einsum("lp,poi->loi", powers, model.residuals.astype(np.complex128))


def beside(model: ModalModel, s: Complex, out: Complex, into: Complex) -> Complex:
    """(lines, outputs, inputs) FRFs without the products of shapes out (outputs, modes) and into (inputs, modes)."""
    return synthesised(model, s) - np.einsum("lr,or,ir->loi", kernels(model, s), out, into)
