"""How well poles are known by how they differ between parts of a test.

The fit's sigma takes the errors of the lines for independent. Those of an FRF of one random record are not: its leakage
and what the local polynomials miss reach over many lines, and differ from one stretch of the record to the next. So
stretches are fitted apart, from the same poles, and the sigma of the whole is at least that of their mean.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.identification.likelihood.frf_fit import fit_frf
from modallab.identification.likelihood.poles import poles_of
from modallab.identification.model.modal_mass import unit_mass_shapes

Real = NDArray[np.float64]

PARTS = 6
STEPS = 12


def with_scatter_of_parts(model: ModalModel, parts: Sequence[Frf]) -> ModalModel:
    """The model, its sigmas no less than the scatter of the parts says.

    Of few parts the scatter is known roughly, which Student's factor allows for.

    Args:
        model: of the whole test.
        parts: FRFs of stretches of it, of one length, in the model's band.
    """
    if len(parts) < 2:
        return model
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    try:
        fits = [fit_frf(part, poles, STEPS) for part in parts]
    except IdentificationError:
        return model
    student = float(stdtrit(len(parts) - 1, 0.975) / ndtri(0.975))
    at = [fit.point.parameters for fit in fits]
    f, zeta = (
        student * np.std([values], axis=1, ddof=1)[0] / np.sqrt(len(parts))
        for values in ([p.omega / (2 * np.pi) for p in at], [p.zeta for p in at])
    )
    wider = np.maximum(f, model.frequency_sigma_hz), np.maximum(zeta, model.damping_sigma)
    constants = np.array([fit.modal_constants[0] for fit in fits])
    scatter = student * np.std(constants, axis=0, ddof=1) / np.sqrt(len(parts))
    of_constants = np.maximum(scatter, model.modal_constant_sigma)
    shapes = unit_mass_shapes(model.modal_constants, of_constants, model.output_points, model.input_points)
    return model.model_copy(
        update={
            "frequency_sigma_hz": wider[0],
            "damping_sigma": wider[1],
            "modal_constant_sigma": of_constants,
            "modal_constant_part_sigma": _part_sigma(model, constants, student),
            "shape_sigma": None if model.shape_sigma is None else shapes.sigma,
        }
    )


def _part_sigma(model: ModalModel, constants: NDArray[np.complex128], student: float) -> NDArray[np.complex128] | None:
    """Of real and imaginary parts, as the model has them."""
    known = model.modal_constant_part_sigma
    if known is None:
        return None
    re, im = (
        student * np.std(part, axis=0, ddof=1) / np.sqrt(len(constants)) for part in (constants.real, constants.imag)
    )
    return np.maximum(re, known.real) + 1j * np.maximum(im, known.imag)
