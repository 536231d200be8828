"""What is said of a model beside its numbers: its assumptions, its shapes' indices, each mode's standing."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.identification.selection.assumptions import AssumptionVerdict
from modallab.identification.selection.criteria import auto_mac, mpc, mpd


@dataclass(frozen=True, eq=False, slots=True)
class ModelAssessment:
    """Judgement of a model.

    Attributes:
        verdicts: the assumptions that could be judged.
        unjudged: (assumption, why not) of the others.
        confidence: (modes,) 0 to 1; NaN where it is not known.
        mpc: (modes,) modal phase collinearity; NaN with fewer than two outputs.
        mpd_rad: (modes,) mean phase deviation.
        auto_mac: (modes, modes).
    """

    verdicts: tuple[AssumptionVerdict, ...]
    unjudged: tuple[tuple[str, str], ...]
    confidence: Real
    mpc: Real
    mpd_rad: Real
    auto_mac: Real


def assess_model(
    model: ModalModel, verdicts: tuple[AssumptionVerdict, ...], unjudged: tuple[tuple[str, str], ...], confidence: Real
) -> ModelAssessment:
    """Verdicts and confidence, with the indices of the shapes: operating ones, or from each mode's loudest input."""
    shapes = model.operating_shapes
    if shapes is None:
        size = np.sum(np.abs(model.modal_constants), axis=1)
        shapes = np.stack([model.modal_constants[r, :, k] for r, k in enumerate(np.argmax(size, axis=1))])
    try:
        return ModelAssessment(verdicts, unjudged, confidence, mpc(shapes), mpd(shapes), auto_mac(shapes))
    except DataError as error:
        unknown = np.full(model.n_modes, np.nan)
        reasons = (*unjudged, ("shapes", str(error)))
        return ModelAssessment(verdicts, reasons, confidence, unknown, unknown, np.full((model.n_modes,) * 2, np.nan))
