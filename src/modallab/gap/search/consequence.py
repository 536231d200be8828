"""Which effects of an explanation are worth a name: beyond their own tolerance, and of consequence.

On a bench as people build it noise units are many before anything matters: what the rig file states that its parts may
be off is no gap, and neither is what moves no response by more than the user cares for.
"""

from dataclasses import dataclass

from modallab.core.digits import percent_text
from modallab.core.effects import Effect
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit, evaluated
from modallab.gap.model.forward import forward
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.model.share import largest_difference
from modallab.gap.search.fitting import refitted_without, within_tolerances, without_effect
from modallab.twin.effects import model_of, search_of

ABOVE = 3.0
"""Deviations of its own tolerance up to which an effect is an ordinary bench."""


@dataclass(frozen=True, slots=True)
class Dismissed:
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


def without_inconsequential(fit: Fit, held: Reduced, shown: bool = False) -> tuple[Fit, list[Dismissed]]:
    """The fit with those of its effects that are worth a name, and the others.

    Args:
        fit: the explanation.
        held: records that no fit has seen.
        shown: whether the generator's lines show a wrong clock: a beam that does its work would be wrong instead.
    """
    least = held.rig.tolerance.response
    dismissed: list[Dismissed] = []
    at = 0
    while at < len(fit.problem.candidates):
        bare = refitted_without(fit, at)
        clock = shown and search_of(fit.problem.candidates[at].effect).tolerance.is_clock
        judged = _dismissal(fit, evaluated(*without_effect(fit.problem, fit.u, at)) if clock else bare, at, held)
        if judged.deviations <= ABOVE or judged.moves < least:
            dismissed.append(judged)
            fit, at = bare, 0
        else:
            at += 1
    return fit, dismissed


def _dismissal(fit: Fit, bare: Fit, at: int, held: Reduced) -> Dismissed:
    effect = fit.effects[at]
    answers = (forward(twin_of(f, held), held) for f in (fit, bare))
    # What takes its work over only by leaving its own tolerance is no ordinary bench.
    moves = largest_difference(held, *answers) if within_tolerances(bare) else float("inf")
    return Dismissed(effect, search_of(effect.effect).tolerance.deviations(effect, held.rig), moves)
