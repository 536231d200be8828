"""The curve of a drift over the campaign: a bench does not warm at an even pace, and need not.

Gauss-Newton steps (Nocedal and Wright, Numerical Optimization, 2006, ch. 10) with a Gaussian prior about an even pace.
"""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import Piece
from modallab.gap.model.fit import Fit, Problem, all_rows
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import minimise
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
        drift_curve = improved_curve(best)
        problem = replace(best.problem, drift_curve=drift_curve)
        trial = minimise(problem, best.u, 3, 1e-3)
        if trial.cost >= best.cost * (1 - 1e-3):
            break
        best = trial
    return best


def improved_curve(fit: Fit) -> tuple[tuple[float, float], ...]:
    """The curve after a Gauss-Newton step of every piece's own share at once: pieces do not know of each other."""
    data = fit.problem.data
    orders = np.array([*(d.piece.order for d in data.impacts), *(p.order for p in _sine_pieces(fit))]) / data.last_order
    twin = fit.problem.twin(fit.u)
    knots, inverse = np.unique(orders, return_inverse=True)
    shares = twin.drifted(knots)
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
    parts = [rows.whiten(rows.y - y) for rows, y in zip(all_rows(problem.data), answers, strict=True)]
    pieces = list(parts[: len(problem.data.impacts)])
    if problem.data.sines is not None:
        shape = (parts[-1].shape[0], *problem.data.sines.source.lines.shape)
        pieces += list(np.moveaxis(parts[-1].reshape(shape), 1, 0))
    return [np.concatenate([p.real.ravel(), p.imag.ravel()]).astype(np.float64) for p in pieces]


def _sine_pieces(fit: Fit) -> tuple[Piece, ...]:
    sines = fit.problem.data.sines
    return sines.pieces if sines is not None else ()
