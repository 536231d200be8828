"""Intervals of an effect's numbers: noise, the model's own error, and the tolerance that an effect replaces.

Gaussian approximation at the fit, under the likelihood by which explanations are compared: what a fit leaves is the
error of few numbers, and its curvature counts by their variance (`inference.evidence`).
"""

from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Real
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.inference.evidence import records_floor
from modallab.gap.model.fit import Fit
from modallab.gap.model.minimise import jacobian
from modallab.gap.search.series_stiffness import HIDDEN, interval_in_series
from modallab.twin.candidate import FreeNumber
from modallab.twin.effects import search_of

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


def intervals(fit: Fit) -> list[Believed]:
    """95 % intervals (SI units) of the parameters of each effect: noise by the curvature, and the model's own error.

    The first part is the Gaussian approximation at the fit, 1.96 deviations in the searched coordinate, carried to the
    parameter by its transform (Bard, Nonlinear Parameter Estimation, 1974). Both parts add in quadrature (GUM, JCGM
    100:2008).

    The second part is what an effect declares of its own model (`EffectSearch.inexact`): its place is off by what the
    shape of the highest mode makes of that. And it is what its own tolerance adds: of a gain only the total is seen,
    and how much of it is the sensor's own percent nobody can tell.

    A number of which this leaves next to nothing said has no interval, but a reason.
    """
    deviation = deviations(fit)
    found: list[Believed] = []
    at = fit.problem.free.size
    for candidate, effect in zip(fit.problem.candidates, fit.effects, strict=True):
        own, off = Believed(), search_of(candidate.effect).inexact
        shared = relative_tolerance(effect, fit.problem.data.rig)
        for slot in candidate.slots:
            u = float(fit.u[at])
            if slot.name == "x":
                sigma, model = float(np.hypot(deviation[at], off / (_steepest_slope(fit) * slot.scale))), 0.0
            else:
                # A gain of its own multiplies a wrong one.
                sure = shared * (abs(slot.value(u)) if slot.none else 1.0)
                sigma, model = float(deviation[at]), float(np.hypot(off, sure))
            why = reason_not_known(slot, u, sigma, model)
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


def _steepest_slope(fit: Fit) -> float:
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


def reason_not_known(slot: FreeNumber, u: float, deviation: float, model: float) -> str:
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
    placed = any(search_of(c.effect).law.smooth for c in problem.candidates)
    J = jacobian(problem, fit.u, fit.residual, whole=placed)
    normal = J.T @ J / records_floor(fit).variance
    normal[np.arange(n), np.arange(n)] += problem.priors(fit.u)[2]
    curvature = np.diag(normal)
    felt = np.flatnonzero(curvature > CURVED * np.max(curvature))
    covariance = np.linalg.pinv(normal[np.ix_(felt, felt)], hermitian=True)
    found = np.full(len(curvature), UNFELT)
    found[felt] = np.sqrt(np.maximum(np.diag(covariance), 0))
    return found
