"""Modes that the search for the maximum of the likelihood has lost, or that only some orders of the estimator show.

A pole that the search pulls onto a neighbour, out of the band or up to a damping that is none has not shown that its
mode is not there. What it explains of the FRFs shows that, compared with what is left where it stands.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.identification.likelihood.basis import edges_of_stand_ins
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import fit_frf
from modallab.identification.selection.prune import MAX_ZETA, MIN_SIGNIFICANCE, is_mode
from modallab.identification.start.stabilisation import OrderPoles, StabilityLimits, stable_poles

SHARE = 0.9
"""Of the power within its width, which a lost mode explains and no other pole does."""
SOME_SHARE = 0.5
"""The same before the search, when the others may still be away from their final frequencies."""
WIDTHS = 2.0
"""Half-widths to either side within which that is asked; three lines at least."""
APART = 0.5
"""Half-widths from a mode within which a lost pole is its double."""
SOME = StabilityLimits(min_share=0.08)
"""A weak mode shows at few orders."""
MOST = 12
"""So many lost poles are asked at most, those of the longest runs."""
FROM_ESTIMATOR = (
    "The mode{s} at {hz} Hz stand{v} where the estimator put {it}: {it2} explain{v} what no other does, and the search"
    " does not stay there."
)


def unshared_power(fit: LikelihoodFit) -> Real:
    """(poles,) share of the power within each pole's width that it explains and no other pole or residual term does.

    The residues of all others are solved for again, in closed form.

    Args:
        fit: of FRFs: one group.
    """
    at, (group,) = fit.point.parameters, fit.point.groups
    omega = fit.problem.blocks[0].excitation.grid.omega
    left = np.sum((group.residual / fit.point.noise) ** 2, axis=1).reshape(-1, 2).sum(axis=1)
    inverse = np.linalg.inv(group.r)
    found = np.empty(at.omega.size)
    for r in range(at.omega.size):
        rows, own = inverse[2 * r : 2 * r + 2], group.coefficients[2 * r : 2 * r + 2] / fit.point.noise
        explained = float(np.sum(own * np.linalg.solve(rows @ rows.T, own)))
        reach = max(WIDTHS * at.zeta[r] * at.omega[r], 3 * float(np.diff(omega).max()))
        near = float(left[np.abs(omega - at.omega[r]) <= reach].sum())
        found[r] = explained / max(explained + near, np.finfo(float).tiny)
    return found


def restore_lost_modes(
    frf: Frf, fit: LikelihoodFit, keep: NDArray[np.bool_], orders: Sequence[OrderPoles], band_hz: tuple[float, float]
) -> tuple[LikelihoodFit, NDArray[np.bool_], tuple[str, ...]]:
    """The fit with the modes that it has lost, which of its poles are modes, and a note where the search lost them.

    Args:
        frf: the FRFs.
        fit: its end.
        keep: (poles,) which are modes.
        orders: the estimator's poles by order.
        band_hz: where modes are looked for.
    """
    at = fit.point.parameters
    kept = _complex_poles(at.omega[keep], at.zeta[keep])
    lost = _candidate_poles(orders, kept, band_hz)
    if not lost.size:
        return fit, keep, ()
    try:
        # Poles that stand on one another have no finite covariance, and are then not seen.
        with np.errstate(over="ignore", invalid="ignore"):
            likely = _poles_that_explain(frf, kept, lost, SOME_SHARE)
            stand = _poles_that_explain(frf, kept, likely, SHARE)
        if not likely.size:
            return fit, keep, ()
        again = fit_frf(frf, np.concatenate([kept, likely]))
        known = is_mode(again, band_hz) & (unshared_power(again) > SHARE)
        if known.sum() > kept.size + max(0, stand.size - 1):
            return _fit_without(frf, again, known, band_hz)
        if not stand.size:
            return fit, keep, ()
        fixed = fit_frf(frf, np.concatenate([kept, stand]), 0)
    except IdentificationError:
        return fit, keep, ()
    names = ", ".join(f"{f:.4g}" for f in np.sort(np.abs(stand)) / (2 * np.pi))
    one = stand.size == 1
    words = {"s": "" if one else "s", "hz": names, "v": "s" if one else ""}
    note = FROM_ESTIMATOR.format(**words, it="it" if one else "them", it2="it" if one else "they")
    return fixed, np.arange(fixed.point.parameters.omega.size) < kept.size + stand.size, (note,)


def overlooked_poles(
    frf: Frf, kept: Complex128, orders: Sequence[OrderPoles], band_hz: tuple[float, float]
) -> Complex128:
    """Poles (poles,) in rad/s that some orders of the estimator show, and that explain what no mode does.

    Args:
        frf: the FRFs of all modes.
        kept: (modes,) poles of the modes in rad/s.
        orders: the estimator's poles by order, in what the modes leave of the FRFs: beside a strong mode a weak one
            shows in no order of the whole.
        band_hz: where modes are looked for.
    """
    lost = _candidate_poles(orders, kept, band_hz)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return _poles_that_explain(frf, kept, lost, SHARE)
    except IdentificationError:
        return lost[:0]


def _fit_without(
    frf: Frf, fit: LikelihoodFit, known: NDArray[np.bool_], band_hz: tuple[float, float]
) -> tuple[LikelihoodFit, NDArray[np.bool_], tuple[str, ...]]:
    """The same fit without the poles that have turned out to be none."""
    if np.all(known[:-1]):
        return fit, known, ()
    at = fit.point.parameters
    again = fit_frf(
        frf, _complex_poles(at.omega[known], at.zeta[known]), stand_ins=edges_of_stand_ins(at.omega, band_hz[1])
    )
    keep = is_mode(again, band_hz)
    return (again, keep, ()) if keep.sum() >= known.sum() else (fit, known, ())


def _poles_that_explain(frf: Frf, kept: Complex128, lost: Complex128, least: float) -> Complex128:
    """Those of the lost poles that explain what no other does: the least one goes until all do."""
    while lost.size:
        fit = fit_frf(frf, np.concatenate([kept, lost]), 0)
        n = kept.size + lost.size
        constants, sigma = (v[:n].reshape(n, -1) for v in fit.modal_constants)
        seen = np.max(np.abs(constants) / np.maximum(np.abs(sigma), 1e-300), axis=1) > MIN_SIGNIFICANCE
        share = np.where(seen, unshared_power(fit)[:n], 0.0)[kept.size :]
        if share.min() > least:
            break
        lost = np.delete(lost, int(np.argmin(share)))
    return lost


def _candidate_poles(orders: Sequence[OrderPoles], kept: Complex128, band_hz: tuple[float, float]) -> Complex128:
    found = sorted(stable_poles(orders, replace(SOME, max_zeta=MAX_ZETA)), key=lambda p: p.run, reverse=True)
    poles = np.array([p.pole for p in found], np.complex128)
    size = np.abs(poles)
    inside = (size > 2 * np.pi * band_hz[0]) & (size < 2 * np.pi * band_hz[1]) & (poles.real < 0)
    if kept.size:
        apart = np.abs(size[:, None] - np.abs(kept))
        inside &= np.all(apart > APART * np.maximum(-poles.real[:, None], -kept.real), axis=1)
    return poles[inside][:MOST]


def _complex_poles(omega: Real, zeta: Real) -> Complex128:
    return np.asarray(-zeta * omega + 1j * omega * np.sqrt(1 - zeta**2), np.complex128)
