"""Where the gap comes from: each number that was free with its move and its share, each effect, the model, the noise.

The shares of numbers that act together by the integral of each one's slope along the straight way from what the rig
file says to where the fit ended (Aumann and Shapley, Values of Non-Atomic Games, 1974; as attribution: Sundararajan,
Taly and Yan, ICML 2017, 3319); the share of a part in a sum of squares is its product with the sum.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from modallab.core.arrays import Real, gauss_legendre
from modallab.core.budget import Budget, BudgetRow, Division
from modallab.core.digits import percent_text
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.residual_shares import weighed_by_record
from modallab.gap.model.twin_of_fit import with_own_hits
from modallab.gap.report.fitted_numbers import fitted_numbers
from modallab.gap.report.measure import labels_of_entries
from modallab.twin.effects import model_of

NODES = 8
"""Points of Gauss's rule on the way."""
NAMED = 0.02
"""Share, for or against the whole, from which a number is listed by its name."""
NARROWS = 0.05
"""Share by which an interval must narrow for a calibration to be suggested."""
MOST = 3
"""Sentences on what to calibrate."""


def budget_of_gap(fit: Fit, data: Reduced, resonances_hz: Sequence[float], usual: bool = False) -> Budget:
    """The budget of the gap between the rig file's own twin and the records.

    Args:
        fit: the twin with the effects judged present, fitted to part of the records.
        data: all records.
        resonances_hz: of the modes by which shares are split.
        usual: whether the rig's tolerances are not its file's, but a lab's usual ones.
    """
    own = with_own_hits(fit, data)
    noise, weighed = weighed_by_record(data)
    n = fit.problem.free.size
    bare = replace(fit.problem, data=weighed, candidates=(), floor=0.0)
    seen = _residual_at(bare, np.zeros(n))
    if float(seen @ seen) <= 0:
        return Budget(rows=[], calibrate=[])
    split = _SharesOfGap.of(weighed, resonances_hz, seen)
    beam = _residual_at(bare, own[:n])
    rows = _rows_of_numbers(bare, own[:n], seen - beam, split)
    before = beam
    for i in range(len(fit.problem.candidates)):
        after = _residual_at(_first_effects(fit, bare, i + 1), own[: _slots_before(fit, i + 1)])
        rows.append(_effect_row(fit, i, split.shares(before - after), split))
        before = after
    whole, stays = split.squares(noise), split.shares(before)
    floor = whole * min(1.0, max(float(stays[0]), 0.0) / max(float(whole[0]), 1e-300))
    rows.append(split.row("model", "model", "not explained", stays - floor))
    rows.append(split.row("noise", "noise", "noise of the channels", floor))
    ordered = sorted(rows, key=lambda r: -abs(r.share))
    listed = data.rig.tolerance.model_dump(exclude={"meaning", "response"}) if usual else {}
    return Budget(rows=ordered, calibrate=_calibrate_first(fit, ordered), usual=listed)


@dataclass(frozen=True, eq=False, slots=True)
class _SharesOfGap:
    """How shares are split.

    Attributes:
        columns: what each share but the first, which is all, is of.
        belongs: (entries, 1 + columns) 1 where an entry of a residual counts.
        seen: (entries,) the residual of the rig file's own twin.
    """

    columns: list[tuple[Division, str]]
    belongs: Real
    seen: Real

    @classmethod
    def of(cls, data: Reduced, resonances_hz: Sequence[float], seen: Real) -> Self:
        columns, belongs = labels_of_entries(data, resonances_hz)
        return cls(columns, np.concatenate([np.ones((len(seen), 1)), belongs], axis=1), seen)

    def shares(self, part: Real) -> Real:
        """(..., 1 + columns) of a part (..., entries) of the residual: its product with the whole."""
        return (part * self.seen) @ self.belongs / float(self.seen @ self.seen)

    def squares(self, values: Real) -> Real:
        """(1 + columns,) of squares (entries,)."""
        return values @ self.belongs / float(self.seen @ self.seen)

    def row(
        self, kind: Any, name: str, said: str, shares: Real, place: str = "", sigmas: float | None = None
    ) -> BudgetRow:
        """A row of the budget."""
        by: dict[Division, dict[str, float]] = {}
        for (division, one), share in zip(self.columns, shares[1:].tolist(), strict=True):
            by.setdefault(division, {})[one] = share
        return BudgetRow(kind=kind, name=name, place=place, said=said, sigmas=sigmas, share=float(shares[0]), by=by)


def _residual_at(problem: Problem, u: Real) -> Real:
    r = problem.residual(u)
    # The clock's own entry is no share of a response.
    return r[:-1] if problem.data.sines is not None else r


def _first_effects(fit: Fit, bare: Problem, count: int) -> Problem:
    return replace(bare, candidates=fit.problem.candidates[:count], drift_curve=fit.problem.drift_curve)


def _slots_before(fit: Fit, count: int) -> int:
    return fit.problem.free.size + sum(len(c.slots) for c in fit.problem.candidates[:count])


def _rows_of_numbers(problem: Problem, u: Real, explained: Real, split: _SharesOfGap) -> list[BudgetRow]:
    """A row for each free number; together they are what the beam and the chain explain without any effect."""
    nodes, weights = gauss_legendre(NODES)
    parts = np.zeros((len(u), len(split.seen)))
    for node, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        J = jacobian(problem, node * u, problem.residual(node * u))[: len(split.seen)]
        parts -= (weight * u)[:, None] * J.T
    shares = split.shares(parts)
    # What the rule misses between its points is spread in proportion.
    joint, found = split.shares(explained)[0], np.sum(shares[:, 0])
    scale = joint / found if abs(found) > 0.2 * abs(joint) else 1.0
    numbers, shares = fitted_numbers(problem, u), shares * scale
    return [
        split.row(
            "tolerance",
            "+".join(dict.fromkeys(numbers[k].name for k in group)),
            _names_together([numbers[k].in_words for k in group]),
            shares[group].sum(axis=0),
            ", ".join(dict.fromkeys(numbers[k].place for k in group if numbers[k].place)),
            float(u[group][np.argmax(np.abs(u[group]))]),
        )
        for group in group_cancelling_parts(shares[:, 0], parts @ parts.T)
    ]


def group_cancelling_parts(shares: Real, products: Real) -> list[list[int]]:
    """Parts in groups, such that none works against the sum: what is left of a group is what stays once they cancel.

    Args:
        shares: (parts,) of each, its product with the sum.
        products: (parts, parts) of each with each.
    """
    groups = [[k] for k in range(len(shares))]
    while groups:
        own = [float(shares[g].sum()) for g in groups]
        least = int(np.argmin(own))
        against = [float(products[np.ix_(groups[least], g)].sum()) for g in groups]
        against[least] = 0.0
        other = int(np.argmin(against))
        if own[least] > -NAMED or against[other] >= 0:
            break
        groups[other] = sorted(groups[other] + groups[least])
        del groups[least]
    return groups


def _names_together(said: list[str]) -> str:
    return said[0] if len(said) == 1 else f"{', '.join(said[:-1])} and {said[-1]} together"


def _effect_row(fit: Fit, i: int, shares: Real, split: _SharesOfGap) -> BudgetRow:
    effect = fit.effects[i]
    return split.row("effect", effect.effect, model_of(effect.effect).spoken, shares)


def _calibrate_first(fit: Fit, rows: Sequence[BudgetRow]) -> list[str]:
    """What to calibrate or measure first: what narrows the effects' intervals most, or else what is most of the gap."""
    if not fit.problem.candidates:
        # What the damping of a mode is nobody knows before the test.
        listed = [r for r in rows if r.kind == "tolerance" and r.name != "damping_ratio"]
        listed_by_name = [r for r in listed if r.share > NAMED][:MOST]
        return [_share_of_tolerance(r) for r in listed_by_name]
    narrows = narrowing_by_nuisance(fit)
    quantities = [m.quantity for m in fitted_numbers(fit.problem, fit.u[: fit.problem.free.size])]
    best = [int(k) for k in np.argsort(-narrows)[:MOST] if narrows[k] > NARROWS]
    alike: dict[str, list[str]] = {}
    for k in best:
        alike.setdefault(percent_text(narrows[k]), []).append(quantities[k].rstrip(","))
    return [
        f"The 95 % intervals of the effect would be {share} narrower if one of these were measured: "
        f"{' or '.join(names)}."
        for share, names in alike.items()
    ]


def _share_of_tolerance(row: BudgetRow) -> str:
    return (
        f"Within tolerance: {row.said}, {abs(row.sigmas or 0):.1f} standard deviations; it makes "
        f"{percent_text(row.share)} of the gap to the simulation of the rig file."
    )


def narrowing_by_nuisance(fit: Fit) -> Real:
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
