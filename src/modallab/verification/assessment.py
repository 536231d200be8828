"""What is said of a model beside its numbers: its assumptions, its shapes' indices, each mode's standing."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.identification.selection.assumptions import AssumptionVerdict
from modallab.identification.selection.criteria import auto_mac, mpc, mpd

LITTLE = 0.2
"""A mode of less confidence is reported as doubtful."""
ALONE = 0.98
"""Share of a mode's squared constants from which one sensor has it to itself."""
SIGMAS = 5.0
LEAST_OUTPUTS = 4
LEAST_FRAC = 0.9
"""A FRF with a lower FRAC is not what the model says."""


def doubtful_mode_sentences(model: ModalModel, confidence: NDArray[np.float64]) -> tuple[str, ...]:
    """Sentences on the modes to be doubted.

    Args:
        model: the modes.
        confidence: (modes,) 0 to 1, NaN where it is not known.
    """
    weak = np.flatnonzero(confidence < LITTLE)
    found = [_weak_modes(model, weak)] if weak.size else []
    seen = output_of_isolated_mode(model)
    return (
        *found,
        *(_modes_of_one_output(model, o, np.flatnonzero(seen == o)) for o in np.unique(seen[seen >= 0]).tolist()),
    )


def output_of_isolated_mode(model: ModalModel) -> NDArray[np.int64]:
    """(modes,) the output that has a mode to itself though forces at other points drive it; -1 where there is none.

    What a force at k drives moves at k. A sensor that clips, is loose or rings by itself answers every force.
    """
    found = np.full(model.n_modes, -1, dtype=np.int64)
    if len(model.outputs) < LEAST_OUTPUTS:
        return found
    power = np.sum(np.abs(model.modal_constants) ** 2, axis=2)
    for r, each in enumerate(power):
        o = int(np.argmax(each))
        constants, sigma = model.modal_constants[r, o], model.modal_constant_sigma[r, o]
        elsewhere = [k for k, p in enumerate(model.input_points) if p is not None and p != model.output_points[o]]
        driven = any(abs(constants[k]) > SIGMAS * sigma[k] for k in elsewhere)
        if each[o] > ALONE * each.sum() and driven:
            found[r] = o
    return found


def mismatch_warning(model: ModalModel, frac: NDArray[np.float64]) -> tuple[str, ...]:
    """A warning where the model does not reproduce what was measured.

    Args:
        model: the modes.
        frac: (outputs, inputs), NaN where it could not be formed.
    """
    poor = ~(frac >= LEAST_FRAC)
    if not poor.any():
        return ()
    known = np.nan_to_num(frac, nan=0.0)
    o, k = np.unravel_index(int(np.argmin(known)), known.shape)
    point = model.input_points[k]
    driven = "" if point is None else f" driven at point {point}"
    worst = f"the worst is {model.outputs[o]}{driven} with {known[o, k]:.2g}"
    return (
        f"WARNING: the model does not reproduce {poor.sum()} of the {frac.size} measured FRFs (FRAC below "
        f"{LEAST_FRAC:g}); {worst}. Do not use the model there: check these FRFs and their records, the band, and "
        "missing modes.",
    )


def _weak_modes(model: ModalModel, modes: NDArray[np.int64]) -> str:
    which, hold = _modes_in_words(model, modes)
    return (
        f"{which} {'are' if modes.size > 1 else 'is'} doubtful: {hold} hardly above what noise, or what the model "
        "leaves unexplained, could cause. Check the FRFs there, or leave the mode out with --drop."
    )


def _modes_of_one_output(model: ModalModel, output: int, modes: NDArray[np.int64]) -> str:
    which, _ = _modes_in_words(model, modes)
    return (
        f"{which} {'are' if modes.size > 1 else 'is'} seen by {model.outputs[output]} alone, though other points were "
        "driven: no mode of a structure is. Check that sensor, its mounting, and its records for clipping."
    )


def _modes_in_words(model: ModalModel, modes: Sequence[int] | NDArray[np.int64]) -> tuple[str, str]:
    listed = ", ".join(f"{model.frequency_hz[r]:.4g}" for r in modes)
    return (f"The modes at {listed} Hz", "they stand") if len(modes) > 1 else (f"The mode at {listed} Hz", "it stands")


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
