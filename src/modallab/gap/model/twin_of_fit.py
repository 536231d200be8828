"""What belongs to a record alone: where its hits landed, what the beam got of them, how warm the bench was.

A fit knows these of the records it has seen. Of others they are no fault of the twin, and are taken from those records
themselves, with their priors: Gauss-Newton steps (Nocedal and Wright, Numerical Optimization, 2006, ch. 10).
"""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import DataPiece, Reduced
from modallab.gap.model.fit import Fit, Problem, all_rows
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import STEP, minimise
from modallab.twin.bench import Twin
from modallab.twin.effects import search_of

LOOSE = 0.05
"""Deviation of a piece's share of the drift from an even pace, before it is seen."""
ROUNDS = 3


def with_drift_curve(fit: Fit) -> Fit:
    """The fit with the share of the drift at each piece of the campaign freed; the same fit if it has no drift."""
    if not any(search_of(c.effect).tolerance.replaces == "stiffness_drift" for c in fit.problem.candidates):
        return fit
    best = fit
    for _ in range(ROUNDS):
        drift_curve = refine_drift_curve(best)
        problem = replace(best.problem, drift_curve=drift_curve)
        trial = minimise(problem, best.u, 3, 1e-3)
        if trial.cost >= best.cost * (1 - 1e-3):
            break
        best = trial
    return best


def refine_drift_curve(fit: Fit) -> tuple[tuple[float, float], ...]:
    """The curve after a Gauss-Newton step of every piece's own share at once: pieces do not know of each other."""
    data = fit.problem.data
    orders = np.array([*(d.piece.order for d in data.impacts), *(p.order for p in _sine_pieces(fit))]) / data.last_order
    twin = fit.problem.twin(fit.u)
    knots, inverse = np.unique(orders, return_inverse=True)
    shares = twin.share_of_drift(knots)
    step = 1e-3
    r0 = _by_piece(fit.problem, fit.u, tuple(zip(knots.tolist(), shares.tolist(), strict=True)))
    r1 = _by_piece(fit.problem, fit.u, tuple(zip(knots.tolist(), (shares + step).tolist(), strict=True)))
    numerator, denominator = np.zeros(len(knots)), np.full(len(knots), 1 / LOOSE**2)
    numerator += (shares - knots) / LOOSE**2
    for place, a, b in zip(inverse, r0, r1, strict=True):
        slope = (b - a) / step
        numerator[place] += float(slope @ a)
        denominator[place] += float(slope @ slope)
    moved = shares - np.clip(numerator / denominator, -0.2, 0.2)
    return tuple(zip(knots.tolist(), moved.tolist(), strict=True))


def _by_piece(problem: Problem, u: Real, drift_curve: tuple[tuple[float, float], ...]) -> list[Real]:
    twin = replace(problem.twin(u), drift_curve=drift_curve)
    answers = forward(twin, problem.data)
    parts = [rows.in_noise_units(rows.y - y) for rows, y in zip(all_rows(problem.data), answers, strict=True)]
    pieces = list(parts[: len(problem.data.impacts)])
    if problem.data.sines is not None:
        shape = (parts[-1].shape[0], *problem.data.sines.source.lines.shape)
        pieces += list(np.moveaxis(parts[-1].reshape(shape), 1, 0))
    return [np.concatenate([p.real.ravel(), p.imag.ravel()]).astype(np.float64) for p in pieces]


def _sine_pieces(fit: Fit) -> tuple[DataPiece, ...]:
    sines = fit.problem.data.sines
    return sines.pieces if sines is not None else ()


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
        own = replace(own, problem=replace(own.problem, drift_curve=refine_drift_curve(own)))
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
