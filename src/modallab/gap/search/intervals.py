"""Intervals of an effect's numbers: noise, errors that are alike within a record, and the model's own.

Noise by the curvature at the fit, errors alike within a cluster of residuals by what they do together (cluster-robust
covariance: Liang and Zeger, Biometrika 73, 1986, 13; White, Econometrica 48, 1980, 817); the larger of the two counts.
A cluster is what one channel answers in one record near one mode: where a model is a little wrong, it is so smoothly.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.model.fit import Fit, all_rows, evaluated, row_frequencies_hz
from modallab.gap.model.minimise import jacobian
from modallab.gap.search.choose import Choice
from modallab.gap.search.fitting import excess, within_tolerances, without_effect
from modallab.gap.search.series_stiffness import HIDDEN, interval_in_series
from modallab.twin.candidate import FreeNumber
from modallab.twin.effects import search_of
from modallab.twin.modes import solve_modes

MODEL_SHARE = 0.7
"""Relative error of a parameter per relative residual its effect leaves."""
UNFELT = 50.0
"""Deviation of a number that is not felt, in its own units: plain ones to their bounds, logarithms to e^50."""
CURVED = 1e-14
"""Share of the largest curvature below which a number is not felt at all, as a place held at the tip."""
OPEN = float(np.log(10.0))
"""Half width of a logarithm's interval from which not even the order of magnitude is known; of a share's odds alike."""
NOT_FELT = "the records do not move with it"
NO_ORDER = "the records leave even its order of magnitude open"
NO_SHARE = "the records leave nearly all shares from 0 to 1 open"
NO_PLACE = "the records leave open where on the beam it is"


@dataclass(frozen=True, slots=True)
class Believed:
    """How well the numbers of an effect are known.

    Attributes:
        within: parameter -> (low, high) of 95 % in SI units; None where the records leave it open.
        not_known: parameter -> why it has no interval.
    """

    within: dict[str, tuple[float, float] | None] = field(default_factory=dict[str, tuple[float, float] | None])
    not_known: dict[str, str] = field(default_factory=dict[str, str])


def intervals(choice: Choice) -> list[Believed]:
    """95 % intervals (SI units) of the parameters of each effect: noise by the curvature, and the model's own error.

    The first part is the Gaussian approximation at the fit, 1.96 deviations in the searched coordinate, carried to the
    parameter by its transform (Bard, Nonlinear Parameter Estimation, 1974). Both parts add in quadrature (GUM, JCGM
    100:2008).

    What an effect leaves unexplained, as a share of what it explains, is the error its model may have: the parameters
    are believed no better, and its place by what the shape of the highest mode makes of that. So is what an effect
    declares of its own model (`Search.inexact`), and what its own tolerance adds: of a gain only the total is seen, and
    how much of it is the sensor's own percent nobody can tell.

    A number of which this leaves next to nothing said has no interval, but a reason.
    """
    fit = choice.fit
    deviation = deviations(fit)
    found: list[Believed] = []
    at = fit.problem.free.size
    for which, (candidate, effect) in enumerate(zip(fit.problem.candidates, fit.effects, strict=True)):
        own, off, shared = Believed(), _model_error(choice, which), relative_tolerance(effect, fit.problem.data.rig)
        for slot in candidate.slots:
            u = float(fit.u[at])
            if slot.name == "x":
                sigma, model = float(np.hypot(deviation[at], off / (_steepest(fit) * slot.scale))), 0.0
            else:
                # A gain of its own multiplies a wrong one.
                sure = shared * (abs(slot.value(u)) if slot.none else 1.0)
                sigma, model = float(deviation[at]), float(np.hypot(off, sure))
            why = not_known(slot, u, sigma, model)
            own.within[slot.name] = None if why else interval(slot, u, sigma, model)
            known = own.within[slot.name]
            if known is not None and slot.name == search_of(candidate.effect).law.behind:
                own.within[slot.name] = interval_in_series(fit, known)
                why = "" if own.within[slot.name] else HIDDEN
            if why:
                own.not_known[slot.name] = why
            at += 1
        found.append(own)
    return found


def _model_error(choice: Choice, which: int) -> float:
    """Relative deviation of the numbers of an effect that the error of its model adds."""
    share = MODEL_SHARE * float(np.sqrt(excess(choice.fit) / max(_explained(choice, which), 1e-9)))
    return float(np.hypot(share, search_of(choice.fit.problem.candidates[which].effect).inexact))


def _explained(choice: Choice, which: int) -> float:
    """What an effect explains, in squares of noise units above the floor.

    Where others stand beside it, or the assembly bends without it until it does its work, what comes back when it goes
    and all else stays.
    """
    fit = choice.fit
    if len(fit.problem.candidates) == 1 and (within_tolerances(choice.base) or not fit.problem.free.deviations):
        return excess(choice.base)
    alone = excess(evaluated(*without_effect(fit.problem, fit.u, which)))
    return max(excess(choice.base), alone) if len(fit.problem.candidates) == 1 else alone


def _steepest(fit: Fit) -> float:
    """Relative change of what an effect does per share of the length that its place moves.

    What it does goes with the squared shape, whose wave number is 2 (n - 1/2) pi over L in the highest mode n of a
    cantilever (Blevins, Formulas for Natural Frequency and Mode Shape, 1979).
    """
    return 2 * np.pi * (fit.problem.free.modes - 0.5)


def interval(slot: FreeNumber, u: float, deviation: float, model: float) -> tuple[float, float]:
    """(low, high) of 95 % in SI units: the noise's part and the model's, in quadrature.

    Args:
        slot: the number.
        u: its coordinate at the fit.
        deviation: of the coordinate, one.
        model: deviation that the model adds, as a share of the effect.
    """
    value = slot.value(u)
    if slot.transform == "log":
        half = _half_of_logarithm(slot, value, deviation, model)
        return slot.value(u - half), slot.value(u + half)
    low, high = (slot.value(u + sign * 1.96 * deviation) for sign in (-1, 1))
    more = 1.96 * model * abs(value - slot.none)
    least, most = (max(slot.low, 0.0), min(slot.high, 1.0)) if slot.transform == "share" else (slot.low, slot.high)
    below, above = float(np.hypot(value - min(low, high), more)), float(np.hypot(max(low, high) - value, more))
    return max(value - below, least), min(value + above, most)


def _half_of_logarithm(slot: FreeNumber, value: float, deviation: float, model: float) -> float:
    """Half of the 95 % interval of a number's logarithm: no number above zero that is off by a share lies below zero.

    Of a factor the effect is how far it is from the factor of none.
    """
    effect = abs(float(np.log(value / slot.none))) if slot.none else 1.0
    return 1.96 * float(np.hypot(deviation, model * effect))


def not_known(slot: FreeNumber, u: float, deviation: float, model: float) -> str:
    """Why a number has no interval; "" where it has one. For the arguments see `interval`."""
    half = 1.96 * deviation
    if deviation >= UNFELT:
        return NOT_FELT
    if slot.transform == "log":
        return NO_ORDER if _half_of_logarithm(slot, slot.value(u), deviation, model) > OPEN else ""
    if slot.transform == "share":
        return NO_SHARE if half > OPEN else ""
    low, high = interval(slot, u, deviation, model)
    return NO_PLACE if slot.name == "x" and low <= slot.low and high >= slot.high else ""


def relative_tolerance(effect: Effect, rig: Rig) -> float:
    """One deviation of the tolerance that an effect takes the place of, relative to the effect's size; 0 for none."""
    search = search_of(effect.effect)
    name = "sensitivity" if search.tolerance.replaces_gain else search.tolerance.replaces
    # A sensitivity that the rig file does not mention is exact.
    if name not in rig.tolerance.model_fields_set:
        return 0.0
    return 1 / max(search.tolerance.deviations(effect, rig), 1e-9)


def deviations(fit: Fit) -> Real:
    """(u,) standard deviation of each free number; UNFELT where no data move.

    The curvature is that at the fit: a fit's own is that of its last slopes, from where it has moved on since.
    """
    problem, n = fit.problem, fit.problem.free.size
    # Where a smooth law sits shows in little more than what it makes of an ordinary bench's deviations.
    placed = any(search_of(c.effect).law.on_slowest for c in problem.candidates)
    J = jacobian(problem, fit.u, fit.residual, whole=placed)
    normal = J.T @ J
    normal[np.arange(n), np.arange(n)] += problem.priors(fit.u)[2]
    curvature = np.diag(normal)
    felt = np.flatnonzero(curvature > CURVED * np.max(curvature))
    covariance = np.linalg.pinv(normal[np.ix_(felt, felt)], hermitian=True)
    # What is above the floor and not alike anywhere counts as more noise.
    variance = np.diag(covariance) * max(1.0, fit.gap) ** 2
    moved = _pulls(fit, J)[:, felt] @ covariance
    found = np.full(len(curvature), UNFELT)
    found[felt] = np.sqrt(np.maximum(np.maximum(variance, np.sum(moved**2, axis=0)), 0))
    return found


def _pulls(fit: Fit, J: Real) -> Real:
    """(clusters, u) by how much each cluster of residuals pulls at the free numbers: its part of J^T r."""
    n = sum(rows.y.size for rows in all_rows(fit.problem.data))
    # What the clock says is one number, and its noise is its own.
    pulled, labels = J[: 2 * n] * fit.residual[: 2 * n, None], _clusters(fit)
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order], prepend=-1))
    return np.add.reduceat(pulled[order], starts, axis=0)


def _clusters(fit: Fit) -> NDArray[np.int64]:
    """(residuals,) number of the cluster of each: of its part of the data or block, its channel and its mode."""
    data = fit.problem.data
    hz = np.abs(solve_modes(fit.problem.twin(fit.u).structure).poles) / (2 * np.pi)
    labels: list[NDArray[np.int64]] = []
    pieces = 0
    for part, own_hz in enumerate(row_frequencies_hz(data)):
        mode = np.argmin(np.abs(np.log(hz / np.maximum(np.abs(own_hz)[:, None], 0.1))), axis=1)
        blocks = np.zeros(len(own_hz), dtype=np.int64)
        if part == len(data.impacts) and data.sines is not None:
            blocks = np.repeat(np.arange(len(data.sines.pieces)), data.sines.source.lines.shape[1])
        channel = np.arange(len(data.channels))[:, None]
        labels.append((((pieces + blocks) * len(data.channels) + channel) * len(hz) + mode).ravel())
        pieces += int(blocks.max()) + 1
    one = np.concatenate(labels)
    return np.concatenate([one, one])
