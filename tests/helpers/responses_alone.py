"""A modal model as the responses alone would give it: shapes without a scale, all with noise."""

import numpy as np

from modallab.core.model import ModalModel

SHAPE, FREQUENCY, DAMPING = 0.01, 2e-4, 0.05
"""One deviation of a component over the largest, of a frequency and of a damping ratio over themselves."""


def responses_alone(of: ModalModel, seed: int = 0) -> ModalModel:
    """Of a model with one input."""
    rng, shapes = np.random.default_rng(seed), of.modal_constants[:, :, 0]
    shapes = shapes / shapes[np.arange(len(shapes)), np.argmax(np.abs(shapes), axis=1)][:, None]
    noise = rng.standard_normal((2, *shapes.shape)) * SHAPE / np.sqrt(2)
    nothing = np.zeros((*shapes.shape, 0))
    return of.model_copy(
        update={
            "frequency_hz": of.frequency_hz * (1 + FREQUENCY * rng.standard_normal(of.n_modes)),
            "frequency_sigma_hz": FREQUENCY * of.frequency_hz,
            "damping_ratio": of.damping_ratio * (1 + DAMPING * rng.standard_normal(of.n_modes)),
            "damping_sigma": DAMPING * of.damping_ratio,
            "input_points": (),
            "modal_constants": nothing.astype(complex),
            "modal_constant_sigma": nothing,
            "residuals": np.zeros((0, shapes.shape[1], 0)),
            "shapes_unavailable": "no force was measured, so that shapes have no scale",
            "operating_shapes": shapes + noise[0] + 1j * noise[1],
            "operating_shape_sigma": np.full(shapes.shape, SHAPE),
        }
    )
