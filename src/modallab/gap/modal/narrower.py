"""A model in a narrower band, as its own identification there would give it.

A mode just above a band is a mode in one model and a sum of powers of s in another. On the band's last lines, off the
axis, that is several per cent of an FRF, which would pass for a gap.
"""

import numpy as np

from modallab.core.model import ModalModel
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.model.modal_model import POWERS, fold_into_residuals

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
    "hit_shares",
)
"""What a model holds of each mode."""


def in_band(model: ModalModel, band_hz: tuple[float, float]) -> ModalModel:
    """The model with its modes above a band, Hz, as residual terms; as it is where there are none, or no others."""
    above = model.frequency_hz > band_hz[1]
    if not np.any(above) or np.all(above):
        return model
    poles = poles_of(2 * np.pi * model.frequency_hz[above], model.damping_ratio[above])
    terms = dict(zip(POWERS, fold_into_residuals(poles, model.modal_constants[above], band_hz), strict=True))
    for power, term in zip(model.residual_powers, model.residuals, strict=True):
        terms[power] = terms.get(power, 0.0) + term
    kept = {name: of[~above] for name in BY_MODE if (of := getattr(model, name)) is not None}
    outside = {"residuals": np.array(list(terms.values())), "residual_powers": tuple(terms)}
    return model.model_copy(update={**kept, **outside})
