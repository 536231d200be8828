"""The modes below a band as one mode: a body that hangs free moves as a whole, and what hangs on it moves with it."""

from typing import Any

import numpy as np

from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.gap.modal.narrower import BY_MODE
from modallab.modification.freedoms import freedoms_of

LOWEST = 0.01
"""Frequency of that mode over the band's lower edge: so far below it no line distinguishes it from 0 Hz."""
DAMPED = 0.01
"""Damping ratio of that mode: any will do, as no line is near it."""
FARTHEST = 10.0
"""A point that moves by so many times more than a driven one is none of a body that moves as a whole."""


def with_rigid_mode(model: ModalModel, rig: Rig) -> ModalModel:
    """The model with its term in s^-2 as a mode; as it is where that term is not one of a body.

    A term alone says what happens between measured points. A mode has a shape: it says so for every pair of points.
    """
    if -2 not in model.residual_powers or not _of_body(model, rig):
        return model
    at = model.residual_powers.index(-2)
    first: dict[str, Any] = {
        "frequency_hz": LOWEST * model.band_hz[0],
        "damping_ratio": DAMPED,
        "modal_constants": model.residuals[at],
    }
    modes = {
        name: np.concatenate([np.broadcast_to(first.get(name, np.nan), of[:1].shape), of])
        for name in BY_MODE
        if (of := getattr(model, name)) is not None
    }
    left = np.where(np.arange(len(model.residuals))[:, None, None] == at, 0.0, model.residuals)
    return model.model_copy(update={**modes, "residuals": left})


def _of_body(model: ModalModel, rig: Rig) -> bool:
    """Whether each driven point where a sensor stands moves with the force, and no other point moves far more."""
    outputs, inputs = freedoms_of(model, rig)
    term = model.residuals[model.residual_powers.index(-2)]
    driven = [(outputs.index(f), i) for i, f in enumerate(inputs) if f in outputs]
    return bool(driven) and all(np.abs(term[:, i]).max() < FARTHEST * term[o, i] for o, i in driven)
