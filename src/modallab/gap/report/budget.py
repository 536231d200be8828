"""Where the gap comes from: each number that was free with its move and its share, each effect, the model, the noise.

The shares of numbers that act together by the integral of each one's slope along the straight way from what the rig
file says to where the fit ended (Aumann and Shapley, Values of Non-Atomic Games, 1974; as attribution: Sundararajan,
Taly and Yan, ICML 2017, 3319); the share of a part in a sum of squares is its product with the sum.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.diagnosis import Budget, BudgetRow
from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.own_numbers import with_own_hits
from modallab.gap.model.share import relative
from modallab.gap.report.moved import moved
from modallab.twin.effects import model_of

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

NODES = 8
"""Points of Gauss's rule on the way."""
NAMED = 0.02
"""Share from which a number within its tolerance is worth a sentence on what to calibrate."""
NARROWS = 0.05
"""Share by which an interval must narrow for a calibration to be worth it."""
MOST = 3
"""Sentences on what to calibrate."""


def budget(fit: Fit, data: Reduced, usual: bool = False) -> Budget:
    """The budget of the gap between the rig file's own twin and the records.

    Args:
        fit: the twin with the effects judged present, fitted to part of the records.
        data: all records.
        usual: whether the rig's tolerances are not its file's, but a lab's usual ones.
    """
    own = with_own_hits(fit, data)
    noise, weighed = relative(data)
    n = fit.problem.free.size
    bare = replace(fit.problem, data=weighed, candidates=(), floor=0.0)
    seen = _residual(bare, np.zeros(n))
    whole = float(seen @ seen)
    if whole <= 0:
        return Budget(rows=[], calibrate=[])
    beam = _residual(bare, own[:n])
    rows = _numbers(fit, bare, own[:n], seen, seen - beam)
    before = beam
    for i in range(len(fit.problem.candidates)):
        after = _residual(_first_effects(fit, bare, i + 1), own[: _slots_before(fit, i + 1)])
        rows.append(_effect_row(fit, i, float((before - after) @ seen) / whole))
        before = after
    floor = min(noise / whole, float(before @ seen) / whole) if float(before @ seen) > 0 else 0.0
    rows.append(_plain("model", "what no number explains", float(before @ seen) / whole - floor))
    rows.append(_plain("noise", "noise of the channels", floor))
    ordered = sorted(rows, key=lambda r: -abs(r.share))
    listed = data.rig.tolerance.model_dump(exclude={"meaning", "response"}) if usual else {}
    return Budget(rows=ordered, calibrate=_calibrate(fit, ordered), usual=listed)


def _residual(problem: Problem, u: Array) -> Array:
    r = problem.residual(u)
    # The clock's own entry is no share of a response.
    return r[:-1] if problem.data.sines is not None else r


def _first_effects(fit: Fit, bare: Problem, count: int) -> Problem:
    return replace(bare, candidates=fit.problem.candidates[:count], drift_curve=fit.problem.drift_curve)


def _slots_before(fit: Fit, count: int) -> int:
    return fit.problem.free.size + sum(len(c.slots) for c in fit.problem.candidates[:count])


def _numbers(fit: Fit, problem: Problem, u: Array, seen: Array, explained: Array) -> list[BudgetRow]:
    """A row for each free number; together they are what the beam and the chain explain without any effect."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    products = np.zeros(len(u))
    for node, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        at = node * u
        r = problem.residual(at)
        J = jacobian(problem, at, r)[: len(seen)]
        products -= weight * u * (J.T @ seen)
    # What the rule misses between its points is spread in proportion.
    whole, joint, found = float(seen @ seen), float(explained @ seen), float(np.sum(products))
    scale = joint / found if abs(found) > 0.2 * abs(joint) else 1.0
    shares = products * scale / whole
    return [
        BudgetRow(kind="tolerance", name=m.name, place=m.place, said=m.said, sigmas=float(u[k]), share=float(shares[k]))
        for k, m in enumerate(moved(problem, u))
    ]


def _effect_row(fit: Fit, i: int, share: float) -> BudgetRow:
    effect = fit.effects[i]
    spoken = model_of(effect.effect).spoken
    return BudgetRow(kind="effect", name=effect.effect, place="", said=spoken, sigmas=None, share=share)


def _plain(kind: Any, said: str, share: float) -> BudgetRow:
    return BudgetRow(kind=kind, name=kind, place="", said=said, sigmas=None, share=share)


def _calibrate(fit: Fit, rows: Sequence[BudgetRow]) -> list[str]:
    """What to calibrate or measure first: what narrows the effects' intervals most, or else what is most of the gap."""
    if not fit.problem.candidates:
        # What the damping of a mode is nobody knows before the test.
        listed = [r for r in rows if r.kind == "tolerance" and r.name != "damping_ratio"]
        worth = [r for r in listed if r.share > NAMED][:MOST]
        return [_within(r) for r in worth]
    narrows = narrowing(fit)
    said = [m.said for m in moved(fit.problem, fit.u[: fit.problem.free.size])]
    best = [int(k) for k in np.argsort(-narrows)[:MOST] if narrows[k] > NARROWS]
    return [f"If this were known, the intervals would be {narrows[k]:.0%} narrower: {said[k]}." for k in best]


def _within(row: BudgetRow) -> str:
    return f"Within tolerance: {row.said} ({abs(row.sigmas or 0):.1f} sigma); it is {row.share:.0%} of what you see."


def narrowing(fit: Fit) -> Array:
    """(nuisances,) share by which the deviation of an effect's number would shrink, at most, were each one known.

    Of a Gaussian conditioned on one of its numbers (Anderson, An Introduction to Multivariate Statistical Analysis,
    2003, ch. 2.5).
    """
    n = fit.problem.free.size
    if len(fit.u) == n:
        # An exchange of plugs has no size.
        return np.zeros(n)
    covariance = np.linalg.pinv(fit.normal, hermitian=True)
    own = np.maximum(np.diag(covariance), 1e-300)
    known = covariance[n:, :n] ** 2 / (own[n:, None] * own[:n])
    return 1 - np.sqrt(np.maximum(1 - np.max(known, axis=0), 0.0))
