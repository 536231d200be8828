"""The noise before the hits, and how many times as large the residual of an impact test's fit is."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.selection.prune import MODEL_ERROR_FROM
from modallab.signals.signals import Signals

SAMPLES_NEEDED = 1000
"""Samples before the hits, over all outputs and blocks, that determine the noise to some 2 %."""


def model_error(fit: LikelihoodFit, signals: Sequence[Signals]) -> float:
    """The residual of the fit over the pre-trigger noise, median over outputs.

    1 where the model explains the blocks; NaN where too few samples lie before the hits.
    """
    noise = pre_trigger_noise(signals)
    return float("nan") if noise is None else float(np.median(fit.point.noise / noise))


def pre_trigger_noise(signals: Sequence[Signals]) -> NDArray[np.float64] | None:
    """Noise (outputs,) of a DFT line's real part, from the samples before the hits; None if there are too few."""
    cut = [s.responses[:, : s.hit.first] for s in signals]
    centred = [q - q.mean(axis=1, keepdims=True) for q in cut if q.shape[1] > 1]
    free = sum(q.shape[1] - 1 for q in centred)
    if free * len(signals[0].outputs) < SAMPLES_NEEDED:
        return None
    variance = np.sum([np.sum(q**2, axis=1) for q in centred], axis=0) / free
    # A DFT line's real part holds half of n times the variance of a sample.
    return np.maximum(np.sqrt(variance * signals[0].force.size / 2), np.finfo(float).tiny)


def model_error_notes(ratio: float, *, widened: bool = False) -> tuple[str, ...]:
    """What is to be said of such a ratio; the sigmas of the poles may have been widened by the hits' own scatter."""
    if not ratio > MODEL_ERROR_FROM:
        return ()
    which = "uncertainties of the modal constants" if widened else "stated uncertainties"
    return (
        f"The fit's residual is {ratio:.3g} times the pre-trigger noise: linear modes do not explain all of it. Hits "
        f"that land off their points, a drift or a nonlinearity do that. The {which} are too small, and "
        "weak modes may not be real.",
    )
