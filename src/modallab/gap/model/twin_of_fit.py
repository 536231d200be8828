"""What belongs to a record alone: where its hits landed, what the beam got of them, how warm the bench was.

A fit knows these of the records it has seen. Of others they are no fault of the twin, and are taken from those records
themselves, with their priors: Gauss-Newton steps (Nocedal and Wright, Numerical Optimization, 2006, ch. 10).
"""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.drift_curve import improved_curve
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.minimise import STEP
from modallab.twin.bench import Twin

OF_HITS = ("hit_position_m", "hit_gain")
"""Tolerances that each drive point has a number of its own for."""
STEPS = 3


def twin_of(fit: Fit, data: Reduced) -> Twin:
    """The twin of a fit on any records of its campaign."""
    own = replace(fit, u=with_own_hits(fit, data))
    if not fit.problem.drift_curve:
        return own.problem.twin(own.u)
    own = replace(own, problem=replace(own.problem, data=data))
    for _ in range(STEPS):
        own = replace(own, problem=replace(own.problem, drift_curve=improved_curve(own)))
    return own.problem.twin(own.u)


def with_own_hits(fit: Fit, data: Reduced) -> Real:
    """(u,) the fit's numbers, those of hits at drive points it has not seen as these records show them."""
    seen = {d.piece.drive_x_m for d in fit.problem.data.impacts if not d.piece.by_shaker}
    u = fit.u.copy()
    for d in (one for one in data.impacts if not one.piece.by_shaker):
        x = d.piece.drive_x_m
        free, first = fit.problem.free, fit.problem.free.first_deviation
        own = [first + k for k, t in enumerate(free.deviations) if t.tolerance in OF_HITS and t.at == x]
        if own and x not in seen:
            u[own] = _settled(replace(fit.problem, data=replace(data, impacts=(d,), sines=None), floor=0.0), u, own)
    return u


def _settled(problem: Problem, u: Real, own: list[int]) -> Real:
    u = u.copy()
    for _ in range(STEPS):
        r = problem.residual(u)
        columns: list[Real] = []
        for k in own:
            moved = u.copy()
            moved[k] += STEP
            columns.append((problem.residual(moved) - r) / STEP)
        J = np.array(columns).T
        u[own] -= np.linalg.solve(J.T @ J + np.eye(len(own)), J.T @ r + u[own])
    return u[own]
