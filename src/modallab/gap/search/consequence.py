"""Which effects of an explanation are worth a name: beyond their own tolerance, and of consequence.

On a bench as people build it noise units are many before anything matters: what the rig file states that its parts may
be off is no gap, and neither is what moves no response by more than the user cares for.
"""

from dataclasses import dataclass

from modallab.core.digits import percent_text
from modallab.core.effects import Effect, kind_of
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit, fit_at
from modallab.gap.model.forward import forward
from modallab.gap.model.residual_shares import largest_difference
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.search.fitting import refitted_without, within_tolerances, without_effect
from modallab.twin.effects import model_of, search_of

ABOVE = 3.0
"""Deviations of its own tolerance up to which an effect is an ordinary bench."""


@dataclass(frozen=True, slots=True)
class DismissedEffect:
    """An effect that is not worth a name.

    Attributes:
        effect: with its numbers.
        deviations: of its own tolerance; infinite where the rig file states none.
        moves: share of the response that it moves on records held out, as far as no tolerance could do the same.
    """

    effect: Effect
    deviations: float
    moves: float

    @property
    def why(self) -> str:
        """In words."""
        spoken = model_of(self.effect.effect).spoken
        if self.deviations <= ABOVE:
            return f"Within tolerance: {spoken}, {self.deviations:.1f} deviations of what the rig file states."
        return f"Of no consequence: {spoken} moves the response on records held out by {percent_text(self.moves)}."


def no_tolerance_acts_like(effect: str, clock_visible: bool) -> bool:
    """Whether no number within its tolerance does the work of an effect, though one may on the records there are.

    A clock that the generator's lines show is wrong however well a beam does its work. A law that depends on the size
    of the motion acts otherwise at another level, where a beam that does its work at this one is wrong.
    """
    return not kind_of(effect).linear or (clock_visible and search_of(effect).tolerance.is_clock)


def without_inconsequential(fit: Fit, held: Reduced, clock_visible: bool = False) -> tuple[Fit, list[DismissedEffect]]:
    """The fit with those of its effects that are worth a name, and the others.

    Args:
        fit: the explanation.
        held: records that no fit has seen.
        clock_visible: whether the generator's lines show a wrong clock.
    """
    least = held.rig.tolerance.response
    dismissed: list[DismissedEffect] = []
    at = 0
    while at < len(fit.problem.candidates):
        refitted = refitted_without(fit, at)
        found = _dismissal(fit, refitted, at, held, clock_visible)
        if found.deviations <= ABOVE or found.moves < least:
            dismissed.append(found)
            fit, at = refitted, 0
        else:
            at += 1
    return fit, dismissed


def _dismissal(fit: Fit, refitted: Fit, at: int, held: Reduced, clock_visible: bool) -> DismissedEffect:
    effect = fit.effects[at]
    deviations = search_of(effect.effect).tolerance.deviations(effect, held.rig)
    if not within_tolerances(refitted):
        # What takes its work over only by leaving its own tolerance is no ordinary bench.
        return DismissedEffect(effect, deviations, float("inf"))
    alone = no_tolerance_acts_like(effect.effect, clock_visible)
    bare = fit_at(*without_effect(fit.problem, fit.u, at)) if alone else refitted
    answers = (forward(twin_of(f, held), held) for f in (fit, bare))
    return DismissedEffect(effect, deviations, largest_difference(held, *answers))
