"""Where a fit begins: the beam and the effect that bring the twin's frequencies to those of the ring-down.

Bending frequencies go with t sqrt(E / rho) / L^2, so deviations of E, t and rho add as 1/2, 1 and 1/2 in quadrature
(GUM, JCGM 100:2008). Mismatches count as absolute values up to a bound, which keeps a missing pole from deciding
(bounded loss: Hampel et al., Robust Statistics, 1986); the effect's numbers by the simplex of Nelder and Mead, Comput.
J. 7 (1965), 308.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import minimize

from modallab.core.arrays import Complex, Real
from modallab.gap.model.nuisances import Nuisances
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effects import apply_effect
from modallab.twin.modes import solve_modes

SPREAD = 0.004
"""Relative deviation of a frequency that is called a match."""


@dataclass(frozen=True, eq=False, slots=True)
class PrefitStart:
    """A place to begin: the free numbers, and how badly the frequencies fit there."""

    u: Real
    cost: float


def start_fits(
    candidates: tuple[CandidateEffect, ...], free: Nuisances, poles: Complex, best: int = 2, former: Real | None = None
) -> list[PrefitStart]:
    """The best places to begin: the last candidate on its grid, those before it where they are.

    Args:
        candidates: effects whose numbers are free.
        free: the nuisances.
        poles: of the ring-down.
        best: how many.
        former: coordinates of the candidates before the last.
    """
    own = candidates[-1].slots if candidates else ()
    before = former if former is not None else np.zeros(0)
    grid = product(*(slot.starts for slot in own))
    found = [
        start_fit(
            candidates,
            np.concatenate([before, [s.coordinate(v) for s, v in zip(own, values, strict=True)]]),
            free,
            poles,
        )
        for values in grid
    ]
    return [refined(s, candidates, free, poles) for s in sorted(found, key=lambda s: s.cost)[:best]]


def refined(
    begin: PrefitStart, candidates: tuple[CandidateEffect, ...], free: Nuisances, poles: Complex
) -> PrefitStart:
    """The same with the last candidate's numbers moved to where the frequencies fit best nearby."""
    count = len(candidates[-1].slots) if candidates else 0
    if not count or not len(poles):
        return begin
    held = begin.u[free.size : len(begin.u) - count]

    def cost(own: Real) -> float:
        return start_fit(candidates, np.concatenate([held, own]), free, poles).cost

    own = begin.u[-count:]
    simplex = np.vstack([own, own + np.diag([0.25 if s.name != "x" else 0.03 for s in candidates[-1].slots])])
    found = minimize(
        cost, own, method="Nelder-Mead", options={"maxfev": 30 * count, "initial_simplex": simplex, "fatol": 1e-3}
    )
    moved = start_fit(candidates, np.concatenate([held, found.x]), free, poles)
    return moved if moved.cost < begin.cost else begin


def start_fit(candidates: tuple[CandidateEffect, ...], effect_u: Real, free: Nuisances, poles: Complex) -> PrefitStart:
    """A start with these effect coordinates; Young's modulus and damping follow from the poles."""
    u = np.concatenate([np.zeros(free.size), effect_u])
    twin, at = free.build(u[: free.size]), free.size
    # The tolerances of a damper are no reason to doubt what the ring-down says of the damping.
    twin = replace(twin, structure=replace(twin.structure, dampers=()))
    for candidate in candidates:
        twin = apply_effect(twin, candidate.effect_at(u[at : at + len(candidate.slots)]), free.rig)
        at += len(candidate.slots)
    model = solve_modes(twin.structure).poles / (1 + twin.clock) * np.sqrt(1 + 0.15 * twin.ei_drift)
    scale, cost, pairs = _match(np.abs(poles), np.abs(model), free)
    u[0] = scale
    u[3 : 3 + free.modes] = _damping(poles, pairs, free, bool(twin.structure.dampers))
    return PrefitStart(u, cost)


def _match(seen: Real, model: Real, free: Nuisances) -> tuple[float, float, list[tuple[int, int]]]:
    """Young's modulus (in deviations) that brings the model's frequencies to those seen, robustly."""
    if not len(seen):
        return 0.0, 0.0, []
    tolerance = free.rig.tolerance
    shift_sigma = 0.5 * np.sqrt(tolerance.youngs_modulus**2 + (2 * tolerance.thickness) ** 2 + tolerance.density**2)
    log_seen, log_model = np.log(seen), np.log(model)
    shifts = np.linspace(-3, 3, 25) * shift_sigma
    distance = np.abs(log_seen[:, None, None] - log_model[None, :, None] - shifts)
    nearest = np.min(distance, axis=1) / SPREAD
    costs = np.sum(np.minimum(nearest, 30.0), axis=0) + 0.5 * (shifts / shift_sigma) ** 2
    best = int(np.argmin(costs))
    pairs = [(i, int(np.argmin(distance[i, :, best]))) for i in range(len(seen))]
    gaps = np.array([log_seen[i] - log_model[j] for i, j in pairs])
    close = np.abs(gaps - shifts[best]) < 10 * SPREAD
    shift = float(np.median(gaps[close])) if np.any(close) else float(shifts[best])
    moved = np.min(np.abs(log_seen[:, None] - log_model[None, :] - shift), axis=1) / SPREAD
    least = min(float(costs[best]), float(np.sum(np.minimum(moved, 30.0)) + 0.5 * (shift / shift_sigma) ** 2))
    kept = [pair for pair, ok in zip(pairs, close, strict=True) if ok]
    return float(np.clip(2 * shift / max(tolerance.youngs_modulus, 1e-4), -4, 4)), least, kept


def _damping(poles: Complex, pairs: list[tuple[int, int]], free: Nuisances, coupled: bool) -> Real:
    u = np.zeros(free.modes)
    if coupled:
        return u
    guess, factor = free.rig.damping_ratio.guess, free.rig.damping_ratio.factor
    for i, j in pairs:
        if j < free.modes:
            zeta = max(-poles[i].real / abs(poles[i]), 3e-4)
            u[j] = float(np.clip(np.log(zeta / guess) / np.log(factor), -4, 4))
    return u
