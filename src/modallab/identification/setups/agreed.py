"""Modes of FRFs whose points disagree: merged over the points, with poles of each point's own."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.identification.likelihood.basis import edges_of_stand_ins
from modallab.identification.likelihood.equations import ParameterCovariance
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import fit_frf
from modallab.identification.likelihood.projection import sum_of_squares
from modallab.identification.model.modal_model import FitReadings, readings_of_fit
from modallab.identification.options import IdentificationOptions
from modallab.identification.setups.merge import MergedModes, merge_modes
from modallab.identification.setups.roving import (
    PointPoles,
    modes_of_each_point,
    point_name,
    poles_at_points,
    roved_axis,
)
from modallab.identification.setups.scatter import CommonPoles, common_poles, setups_with_other_frequencies

LEAST_POINTS = 6
MISFIT = 1.3
"""The residual over the noise from line to line, from which on the points are asked whether they agree."""
ASKED = 40
"""Points that are asked for the modes they find alone; of more, evenly chosen ones say as much."""
ORDERS_A_MODE, LEAST_ORDER, MOST_ORDER = 4, 40, 90
"""Of the estimator at one point."""
SIGNIFICANCE = 5.0
FREE = 2.0
"""A point's poles may move by so many times as much as the points were seen to scatter."""
LEAST_SPREAD = (1e-5, 1e-3)
"""Relative, of a frequency and of a damping ratio."""


@dataclass(frozen=True, eq=False, slots=True)
class AgreedModes:
    """What points that disagree have in common.

    Attributes:
        fit: of all FRFs at the common poles, with the covariance that the scatter leaves.
        seen: modal constants and residual terms, each from its point's own fit.
        notes: on how far the points disagree, and which are off.
    """

    fit: LikelihoodFit
    seen: FitReadings
    notes: tuple[str, ...]


def agreed_modes(frf: Frf, fit: LikelihoodFit, options: IdentificationOptions) -> AgreedModes | None:
    """The modes of points that disagree; None where one set of poles explains the FRFs, or too few points roved.

    Args:
        frf: all FRFs, in the band.
        fit: with one set of poles.
        options: the estimator; modes that were picked or dropped by hand are left as they are.
    """
    few = max(frf.values.shape[:2]) < LEAST_POINTS
    if few or options.pick_hz or options.drop_hz or misfit_over_noise(fit) < MISFIT:
        return None
    found, asked = _merge_points(frf, fit, options)
    if found.centre.shape[0] == 0:
        return None
    try:
        stand_ins = edges_of_stand_ins(fit.point.parameters.omega, float(frf.frequency_hz[-1]))
        points = poles_at_points(frf, found.centre, _spread_of_points(found), stand_ins)
        common = common_poles(points.values, points.variance)
        alone = min(frf.values.shape[:2]) == 1
        if common.setup.max() == 0 or (alone and _evidence(*points.fits) > _evidence(fit)):
            return None
        return _agreed_model(frf, points, common, stand_ins, _agreement_notes(frf, found, common, asked))
    except IdentificationError:
        return None


def _evidence(*fits: LikelihoodFit) -> float:
    """BIC of fits that share no pole, each row with a noise of its own: less is better.

    Of one input rows have no signature. Then only how well they are explained tells modes that move from close ones.
    """
    left = np.concatenate([sum_of_squares(fit.point.groups[0].residual).ravel() for fit in fits])
    lines = fits[0].problem.blocks[0].response.shape[-1]
    poles = sum(fit.point.parameters.omega.size for fit in fits)
    rows = [fit.problem.blocks[0].response[..., 0].size for fit in fits]
    free = 2 * poles + 2 * sum(n * fit.point.parameters.omega.size for n, fit in zip(rows, fits, strict=True))
    misfit = 2 * lines * np.log(np.maximum(left, np.finfo(float).tiny)).sum()
    return float(misfit + free * np.log(2 * lines * left.size))


def misfit_over_noise(fit: LikelihoodFit) -> float:
    """The fit's residual over the noise from line to line, median over the FRFs: 1 where the model explains them."""
    # As the fit saw them, weighed line by line.
    fourth = np.diff(fit.problem.blocks[0].response, 4, axis=-1)
    # Of white noise a fourth difference has 70 times the variance; a median magnitude is 1.177 sigmas of a part.
    noise = np.median(np.abs(fourth), axis=-1) / np.sqrt(70) / 1.1774
    ratio = fit.point.noise / np.maximum(noise.reshape(-1), np.finfo(float).tiny)
    return float(np.median(ratio))


def _merge_points(frf: Frf, fit: LikelihoodFit, options: IdentificationOptions) -> tuple[MergedModes, int]:
    n_points = frf.values.shape[roved_axis(frf)]
    asked = np.unique(np.linspace(0, n_points - 1, min(n_points, ASKED)).astype(int)).tolist()
    order = options.max_order or int(np.clip(ORDERS_A_MODE * fit.point.parameters.omega.size, LEAST_ORDER, MOST_ORDER))
    order = min(order, max(2, frf.frequency_hz.size // 2 - 1))
    return merge_modes(modes_of_each_point(frf, asked, options.method, order, SIGNIFICANCE), len(asked)), len(asked)


def _spread_of_points(found: MergedModes) -> Real:
    return FREE * np.maximum(found.spread, found.centre * np.array(LEAST_SPREAD))


def _agreed_model(
    frf: Frf, points: PointPoles, common: CommonPoles, stand_ins: tuple[float, ...], notes: tuple[str, ...]
) -> AgreedModes:
    omega, zeta = common.value.T
    start = np.asarray(-zeta * omega + 1j * omega, np.complex128)
    at_common = fit_frf(frf, start, 0, stand_ins=stand_ins)
    covariance = ParameterCovariance.of_poles(np.diag(np.append(common.sigma**2, np.zeros(2 * len(stand_ins)))))
    axis = 1 + roved_axis(frf)
    each = [readings_of_fit(f) for f in points.fits]
    constants = np.concatenate([one.constants for one in each], axis=axis)
    # A pole that moves by a part of its half-width leaves as much of the mode to its neighbours.
    between = np.append(common.between[:, 0] / (zeta * omega), np.zeros(len(stand_ins)))
    apparent = np.hypot(between, _apparent_misfit(each))
    seen = FitReadings(
        constants,
        np.concatenate([one.sigma_of_parts for one in each], axis=axis),
        np.concatenate([one.terms for one in each], axis=axis),
        apparent,
    )
    return AgreedModes(
        replace(at_common, refined=replace(at_common.refined, covariance=covariance, settled=True)), seen, notes
    )


def _apparent_misfit(each: Sequence[FitReadings]) -> Real:
    """(modes,) of all points what is apparent of each: in proportion to the mode's size there."""
    size = np.array([np.linalg.norm(one.constants, axis=(1, 2)) for one in each])
    own = size * np.array([one.apparent for one in each])
    return np.linalg.norm(own, axis=0) / np.maximum(np.linalg.norm(size, axis=0), np.finfo(float).tiny)


def _agreement_notes(frf: Frf, found: MergedModes, common: CommonPoles, asked: int) -> tuple[str, ...]:
    size, shares = 100 * np.median(common.between[:, 0] / common.value[:, 0]), 100 * found.share
    n = int(common.setup.max()) + 1
    notes = [
        f"The points disagree: their frequencies scatter by {size:.2g} % over {n} set-ups that the shifts show. Each "
        "point has poles of its own; those of the model are their mean, and the scatter is in the sigmas.",
        f"By itself each mode was found by {shares.min():.0f} to {shares.max():.0f} % of the {asked} points asked.",
    ]
    for c in setups_with_other_frequencies(common):
        members = ", ".join(point_name(frf, int(k)) for k in np.flatnonzero(common.setup == c))
        away = 100 * (common.shift[c] - np.median(common.shift))
        notes.append(
            f"The set-up of {members} is off: its frequencies are {abs(away):.2g} % "
            f"{'higher' if away > 0 else 'lower'} than the others'. Look at its sensor's mass, cable and mounting."
        )
    return tuple(notes)
