"""Intervals of an effect's numbers: noise, errors that are alike within a record, and the model's own.

Noise by the curvature at the fit, errors alike within a cluster of residuals by what they do together (cluster-robust
covariance: Liang and Zeger, Biometrika 73, 1986, 13; White, Econometrica 48, 1980, 817); the larger of the two counts.
A cluster is what one channel answers in one record near one mode: where a model is a little wrong, it is so smoothly.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.model.fit import Fit, all_hz, all_rows
from modallab.gap.model.minimise import jacobian
from modallab.gap.search.choose import Choice
from modallab.gap.search.fitting import excess
from modallab.twin.effects import search_of
from modallab.twin.structure import solve

Array = NDArray[np.float64]

MODEL_SHARE = 0.7
"""Relative error of a parameter per relative residual its effect leaves."""
UNFELT = 50.0
"""Deviation of a number that is not felt, in its own units: plain ones to their bounds, logarithms to e^50."""
CURVED = 1e-14
"""Share of the largest curvature below which a number is not felt at all, as a place held at the tip."""


def intervals(choice: Choice) -> list[dict[str, tuple[float, float]]]:
    """95 % intervals (SI units) of the parameters of each effect: noise by the curvature, and the model's own error.

    The first part is the Gaussian approximation at the fit, 1.96 deviations in the searched coordinate, carried to the
    parameter by its transform (Bard, Nonlinear Parameter Estimation, 1974). Both parts add in quadrature (GUM, JCGM
    100:2008).

    What an effect leaves unexplained, as a share of what it explains, is the error its model may have: the parameters
    are believed no better. So is what an effect declares of its own model (`Search.inexact`), and what its own
    tolerance adds: of a gain only the total is seen, and how much of it is the sensor's own percent nobody can tell.
    """
    fit = choice.fit
    deviation = deviations(fit)
    share = MODEL_SHARE * float(np.sqrt(excess(fit) / max(excess(choice.base), 1e-9)))
    found: list[dict[str, tuple[float, float]]] = []
    at = fit.problem.free.size
    for candidate, effect in zip(fit.problem.candidates, fit.effects, strict=True):
        own: dict[str, tuple[float, float]] = {}
        shared = tolerated(effect, fit.problem.data.rig)
        off = float(np.hypot(share, search_of(candidate.effect).inexact))
        for slot in candidate.slots:
            u = float(fit.u[at])
            value = slot.value(u)
            low, high = (slot.value(u + sign * 1.96 * float(deviation[at])) for sign in (-1, 1))
            # A gain of its own multiplies a wrong one.
            sure = shared * (abs(value) if slot.none else 1.0)
            model = 1.96 * float(np.hypot(off, sure)) * abs(value - slot.none) if slot.name != "x" else 0.0
            own[slot.name] = (
                max(value - float(np.hypot(value - min(low, high), model)), slot.low),
                min(value + float(np.hypot(max(low, high) - value, model)), slot.high),
            )
            at += 1
        found.append(own)
    return found


def tolerated(effect: Effect, rig: Rig) -> float:
    """What the tolerance that an effect stands for has in it, one deviation, as a share of the effect; 0 for none."""
    search = search_of(effect.effect)
    name = "sensitivity" if search.replaces_gain else search.replaces
    # A sensitivity that the rig file does not mention is exact.
    if name not in rig.tolerance.model_fields_set:
        return 0.0
    return 1 / max(search.deviations(effect, rig), 1e-9)


def deviations(fit: Fit) -> Array:
    """(u,) standard deviation of each free number; UNFELT where no data move."""
    curvature = np.diag(fit.normal)
    felt = np.flatnonzero(curvature > CURVED * np.max(curvature))
    covariance = np.linalg.pinv(fit.normal[np.ix_(felt, felt)], hermitian=True)
    # What is above the floor and not alike anywhere counts as more noise.
    variance = np.diag(covariance) * max(1.0, fit.gap) ** 2
    moved = pulls(fit)[:, felt] @ covariance
    found = np.full(len(curvature), UNFELT)
    found[felt] = np.sqrt(np.maximum(np.maximum(variance, np.sum(moved**2, axis=0)), 0))
    return found


def pulls(fit: Fit) -> Array:
    """(clusters, u) by how much each cluster of residuals pulls at the free numbers: its part of J^T r."""
    n = sum(rows.y.size for rows in all_rows(fit.problem.data))
    # What the clock says is one number, and its noise is its own.
    J, r, labels = jacobian(fit.problem, fit.u, fit.residual)[: 2 * n], fit.residual[: 2 * n], _clusters(fit)
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order], prepend=-1))
    return np.add.reduceat(J[order] * r[order, None], starts, axis=0)


def _clusters(fit: Fit) -> NDArray[np.int64]:
    """(residuals,) number of the cluster of each: of its part of the data or block, its channel and its mode."""
    data = fit.problem.data
    hz = np.abs(solve(fit.problem.twin(fit.u).structure).poles) / (2 * np.pi)
    labels: list[NDArray[np.int64]] = []
    pieces = 0
    for part, own_hz in enumerate(all_hz(data)):
        mode = np.argmin(np.abs(np.log(hz / np.maximum(np.abs(own_hz)[:, None], 0.1))), axis=1)
        blocks = np.zeros(len(own_hz), dtype=np.int64)
        if part == len(data.impacts) and data.sines is not None:
            blocks = np.repeat(np.arange(len(data.sines.pieces)), data.sines.source.lines.shape[1])
        channel = np.arange(len(data.channels))[:, None]
        labels.append((((pieces + blocks) * len(data.channels) + channel) * len(hz) + mode).ravel())
        pieces += int(blocks.max()) + 1
    one = np.concatenate(labels)
    return np.concatenate([one, one])
