"""From the rounds of a search to what is judged present, how surely, and the verdict.

Effects are dropped one by one as in backward elimination (Draper and Smith, Applied Regression Analysis, 1998).
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.effects import kind_of
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.evidence import evidence, evidence_without_name, probabilities_of
from modallab.gap.inference.select import SearchRound
from modallab.gap.model.fit import Fit, cost_of
from modallab.gap.model.forward import forward
from modallab.gap.model.residual_shares import unexplained
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.search.clock import clock_error_visible
from modallab.gap.search.consequence import DismissedEffect, no_tolerance_acts_like, without_inconsequential
from modallab.gap.search.fitting import (
    Bench,
    each_within_tolerance,
    within_tolerances,
)
from modallab.twin.effects import search_of


@dataclass(frozen=True, eq=False, slots=True)
class Selection:
    """What the search says.

    Attributes:
        base: the twin without effects.
        fit: the twin with those judged present; `base` if there are none.
        rivals: other explanations that were fitted to the end, best first.
        explained: whether nothing structured is left.
        flat: whether there was nothing to explain.
        dismissed: effects that explain something, but are within tolerance or of no consequence.
        tolerated: share of the response that no effect explains and that the rig file tolerates; None where all of the
            gap is explained, or where it exceeds the tolerance.
        nameless: -2 log evidence of the element without a name that explains the gap, where one does.
    """

    base: Fit
    fit: Fit
    rivals: tuple[Fit, ...]
    explained: bool
    flat: bool
    dismissed: tuple[DismissedEffect, ...] = ()
    tolerated: float | None = None
    nameless: float | None = None

    @property
    def accepted_fit(self) -> Fit:
        """The twin with what is judged present: what does not explain the gap is none of it."""
        return self.fit if self.explained else self.base

    @property
    def named(self) -> tuple[Fit, ...]:
        """All explanations by effects of the catalogue, the most probable first."""
        return (self.fit, *self.rivals) if self.fit.problem.candidates else self.rivals


def select_explanation(bench: Bench, levels: list[SearchRound], held: Reduced | None = None) -> Selection:
    """The most probable of all explanations that were fitted, and whether it explains the gap.

    Args:
        bench: what was searched.
        levels: the rounds.
        held: records that no fit has seen, where what does not matter there is no gap: on a rig that states how well it
            is put together.
    """
    base = levels[0].base
    plain = base.gap <= bench.flat and (within_tolerances(base) or not bench.free.deviations)
    if plain and not _clock_alone(bench, levels):
        return Selection(base, base, (), True, True)
    rivals = sorted((f for level in levels for f in level.fits), key=cost_of)
    listed = [base, *rivals]
    minus_two_logs = evidence(listed)
    best = int(np.argmin(minus_two_logs))
    fit = listed[best]
    # Compared with the others, not by itself: what an effect is itself off by is no excuse where others predict better.
    explained = bool(fit.problem.candidates) and bool(minus_two_logs[best] < evidence_without_name(fit))
    others = tuple(f for f in rivals if effect_names(f) != effect_names(fit))
    choice = Selection(base, fit, others, explained, False)
    return choice if held is None else _without_inconsequential(choice, held, clock_error_visible(bench))


def has_stepped_law(fit: Fit) -> bool:
    """Whether an effect of a fit depends on the size of the motion."""
    return any(not kind_of(c.effect).linear for c in fit.problem.candidates)


def _without_inconsequential(choice: Selection, held: Reduced, clock_visible: bool) -> Selection:
    """The same without what is within tolerance or of no consequence."""
    left = unexplained(held, forward(twin_of(choice.base, held), held))
    unnamed = not choice.explained and each_within_tolerance(choice.base)
    tolerable = within_tolerances(choice.base) and not (
        choice.explained and any(no_tolerance_acts_like(c.effect, clock_visible) for c in choice.fit.problem.candidates)
    )
    if left < held.rig.tolerance.response and (tolerable or unnamed):
        # Nothing has a name, no number alone is beyond its tolerance, and nothing that matters is left to name.
        tolerated = None if choice.explained else left
        return Selection(choice.base, choice.base, choice.rivals, True, True, tolerated=tolerated)
    if not choice.explained:
        return choice
    fit, dismissed = without_inconsequential(choice.fit, held, clock_visible)
    if not fit.problem.candidates:
        # An effect of next to nothing may have shown the way to a twin without effects that fits better.
        base = min(choice.base, fit, key=lambda f: f.cost)
        return Selection(base, base, choice.rivals, True, True, tuple(dismissed))
    return replace(choice, fit=fit, dismissed=tuple(dismissed))


def _clock_alone(bench: Bench, levels: list[SearchRound]) -> bool:
    """Whether the lines show a wrong clock that begins the rounds: a beam within its tolerances follows it unseen."""
    return clock_error_visible(bench) and any(_has_clock(fit) for fit in levels[0].fits[:1])


def _has_clock(fit: Fit) -> bool:
    """Whether a wrong clock is one of the effects of a fit."""
    return any(search_of(c.effect).tolerance.is_clock for c in fit.problem.candidates)


def effect_names(fit: Fit) -> tuple[str, ...]:
    """The effects of a fit, sorted."""
    return tuple(sorted(c.effect for c in fit.problem.candidates))


def probabilities(choice: Selection) -> tuple[list[tuple[Fit, float]], float]:
    """The explanations, each with its probability, best first, and the probability that the cause has no name."""
    fits: dict[tuple[str, ...], Fit] = {effect_names(choice.fit): choice.fit}
    for fit in choice.rivals:
        fits.setdefault(effect_names(fit), fit)
    ordered = list(fits.values())
    nameless = evidence_without_name(choice.fit) if choice.nameless is None else choice.nameless
    *shares, unknown = probabilities_of(np.append(evidence(ordered), nameless)).tolist()
    return sorted(zip(ordered, shares, strict=True), key=lambda pair: -pair[1]), unknown
