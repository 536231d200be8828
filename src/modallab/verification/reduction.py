"""Data reduction by a model: count of values before and after, and the error of each pair."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel


@dataclass(frozen=True, eq=False, slots=True)
class ModelReduction:
    """The size of measured FRFs and of their model, and the error of each pair.

    Attributes:
        outputs: (outputs,) channel names.
        output_points: (outputs,) where they are; None where unknown.
        input_points: (inputs,) points that were driven; None where unknown.
        measured_numbers: real numbers in the measured FRFs.
        model_numbers: real numbers in the model: poles, modal constants, residual terms.
        error: (outputs, inputs) effective value of the difference, over that of the measured FRF.
        frac: (outputs, inputs) FRAC of measured against regenerated.
    """

    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    measured_numbers: int
    model_numbers: int
    error: Real
    frac: Real


def reduction_of(model: ModalModel, measured: Complex, regenerated: Complex, frac: Real) -> ModelReduction:
    """The size before and after, and the error of each pair.

    Args:
        model: of the FRFs.
        measured: (outputs, inputs, lines).
        regenerated: the model's, through the same block.
        frac: (outputs, inputs) of one against the other.
    """
    off, size = (np.linalg.norm(one, axis=-1) for one in (regenerated - measured, measured))
    constants = 2 if np.any(model.modal_constants.imag) else 1
    return ModelReduction(
        model.outputs,
        model.output_points,
        model.input_points,
        2 * measured.size,
        2 * model.n_modes + constants * model.modal_constants.size + model.residuals.size,
        np.divide(off, size, out=np.full_like(size, np.nan), where=size > 0),
        frac,
    )
