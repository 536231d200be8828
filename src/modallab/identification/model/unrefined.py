"""Models whose poles are an estimator's own, with no search for the maximum of the likelihood behind it."""

import numpy as np

from modallab.core.model import Method, ModalModel

CALLED: dict[Method, str] = {
    "plscf": "pLSCF",
    "era": "ERA",
    "circle": "the circle fit",
    "peak": "the half-power rule",
}


def without_sigma(model: ModalModel) -> ModalModel:
    """The same model, its sigmas unknown: a covariance is that of the maximum of the likelihood and of nothing else."""
    return model.model_copy(
        update={
            "frequency_sigma_hz": np.full(model.n_modes, np.nan),
            "damping_sigma": np.full(model.n_modes, np.nan),
            "modal_constant_sigma": np.full(model.modal_constants.shape, np.nan),
            "modal_constant_part_sigma": None,
            "shape_sigma": None,
            "notes": (
                *model.notes,
                f"The poles are those of {CALLED[model.method]}, not refined: their uncertainty is not known.",
            ),
        }
    )
