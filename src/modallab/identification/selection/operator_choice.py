"""Modes that the operator picks or drops, over what the automatic selection says."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import IdentificationError
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection.prune import is_mode
from modallab.identification.start.stabilisation import OrderPoles

NEAR = 0.02
"""A mode within this share of the frequency that was said is the one that is meant."""
TWICE = 1e-3
"""A stable pole this near to a picked one, relative, is the same."""
FIRST_ZETA = 0.005
"""Where a picked mode's damping begins if no order holds a pole there."""


def start_poles(
    found: NDArray[np.complex128], orders: Sequence[OrderPoles], options: IdentificationOptions
) -> NDArray[np.complex128]:
    """Where the search begins: at the stable poles, and at those that the operator has picked.

    The others stay in the fit, for the picked ones would else move to stand for them too.

    Args:
        found: (poles,) the stable ones.
        orders: all poles by order, among which a picked mode that is not stable is looked for.
        options: with `pick_hz`.
    """
    if not options.pick_hz:
        return found
    every = np.concatenate([found, *[o.poles for o in reversed(orders)]])
    poles: list[complex] = []
    for choice in 2 * np.pi * np.array(sorted(options.pick_hz)):
        sound = every[(every.real < 0) & (-every.real < 0.2 * np.abs(every))]
        near = sound[np.abs(np.abs(sound) / choice - 1) < NEAR]
        stable = near[np.isin(near, found)]
        use = stable if stable.size else near
        if use.size:
            poles.append(complex(use[np.argmin(np.abs(np.abs(use) - choice))]))
        else:
            poles.append(complex(-FIRST_ZETA * choice, choice))
    picked = np.array(list(dict.fromkeys(poles)))
    apart = np.abs(np.abs(found)[:, None] / np.abs(picked) - 1).min(axis=1) > TWICE
    others = found[apart & ~np.isin(found, picked)]
    return np.concatenate([picked, others])


def poles_to_search(
    fit: LikelihoodFit, keep: NDArray[np.bool_], band_hz: tuple[float, float], options: IdentificationOptions
) -> NDArray[np.bool_]:
    """(modes,) which poles a further search keeps: the modes, and beside picked ones those that were not picked."""
    return keep | is_mode(fit, band_hz) if options.pick_hz else keep


def chosen_modes(
    fit: LikelihoodFit, band_hz: tuple[float, float], options: IdentificationOptions, *, first: bool
) -> NDArray[np.bool_]:
    """(modes,) which poles are modes: the operator's picks, or the automatic selection without what was dropped.

    Args:
        fit: a refined fit.
        band_hz: band of the lines.
        options: with `pick_hz` and `drop_hz`.
        first: whether dropped modes are still in the fit.

    Raises:
        IdentificationError: no pole stands where one was picked, or no mode where one was dropped.
    """
    inside = fit.inside(band_hz)
    if options.pick_hz:
        found = _picked_poles(fit, inside, options.pick_hz)
    elif options.drop_hz and not first:
        # What the operator has left stays, however much noise the dropped one is for it now.
        found = np.isinf(fit.problem.zeta_prior[:, 1]) & inside
    else:
        # What an estimator says is taken as it says it: there is no covariance to judge it by.
        found = is_mode(fit, band_hz) if options.refined else inside
    return _drop_modes(fit, found, options.drop_hz) if options.drop_hz and first else found


def _picked_poles(fit: LikelihoodFit, inside: NDArray[np.bool_], pick_hz: Sequence[float]) -> NDArray[np.bool_]:
    frequency = fit.point.parameters.omega / (2 * np.pi)
    keep = np.zeros(frequency.size, bool)
    for choice in pick_hz:
        keep[
            _nearest_pole(frequency, inside, choice, "the fit has no pole there", "leave it out, or widen the band")
        ] = True
    return keep


def _drop_modes(fit: LikelihoodFit, found: NDArray[np.bool_], drop_hz: Sequence[float]) -> NDArray[np.bool_]:
    frequency, keep = fit.point.parameters.omega / (2 * np.pi), found.copy()
    for unwanted in drop_hz:
        keep[_nearest_pole(frequency, keep, unwanted, "no mode stands there", "give a frequency found")] = False
    if not np.any(keep):
        raise IdentificationError(
            f"no mode is left once {', '.join(f'{f:g}' for f in drop_hz)} Hz are dropped",
            remedy="drop fewer modes, or widen the band",
        )
    return keep


def _nearest_pole(frequency: NDArray[np.float64], of: NDArray[np.bool_], choice: float, says: str, remedy: str) -> int:
    among = np.flatnonzero(of)
    away = np.abs(frequency[among] / choice - 1)
    if not away.size or away.min() > NEAR:
        there = ", ".join(f"{f:.4g}" for f in np.sort(frequency[among])) or "none"
        raise IdentificationError(f"{choice:g} Hz: {says}; there are {there} Hz", remedy=remedy)
    return int(among[np.argmin(away)])
