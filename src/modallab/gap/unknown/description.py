"""A description under trial: a fit with elements, on records that may have been freed of what a channel did to them."""

from dataclasses import dataclass

import numpy as np

from modallab.core.effect import LearnedElement, OneChannel, place_in_metres
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit, cost_with_price
from modallab.gap.search.intervals import intervals
from modallab.twin.learned import learned_element_models


@dataclass(frozen=True, eq=False, slots=True)
class Description:
    """What a gap behaves like.

    Attributes:
        fit: the twin, elements that it can hold included.
        unseen: records that no fit has seen, freed as those were.
        raw: the same as they came.
        learned: the elements.
        rows: channels concerned.
    """

    fit: Fit
    unseen: Reduced
    raw: Reduced
    learned: tuple[LearnedElement, ...]
    rows: tuple[int, ...] = ()


def description_of(fit: Fit, unseen: Reduced, rows: tuple[int, ...] = ()) -> Description:
    """The description that a fit of elements is."""
    length = fit.problem.data.rig.beam.length_m if fit.problem.data.rig.beam is not None else 1.0
    found: list[LearnedElement] = []
    for effect, believed in zip(fit.effects, intervals(fit), strict=True):
        found.append(
            LearnedElement(
                element=effect.effect,
                parameters=effect.parameters,
                interval=believed.within,
                not_known=believed.not_known,
                place=place_in_metres(effect.place, length),
            )
        )
    return Description(fit, unseen, unseen, tuple(found), rows)


def cost_per_number(one: Description) -> float:
    """What it leaves per number; a description of fewer numbers goes first where both leave about as little."""
    # Elements that act sample by sample have numbers too, though no fit of lines knows of them.
    more = sum(len(e.parameters) for e in one.learned) if not one.fit.problem.candidates else 0
    return fit_cost(one.fit, more)


def fit_cost(fit: Fit, more: int = 0) -> float:
    """What a fit leaves for each number measured, at the price of its own numbers and so many more."""
    count = max(np.count_nonzero(fit.residual), 1)
    return (cost_with_price(fit) + more * float(np.log(count))) / count


def stage_of(description: Description) -> str:
    """Where its elements act."""
    return learned_element_models()[description.learned[0].element].kind.stage


def rows_of(fit: Fit) -> tuple[int, ...]:
    """The channels on which the effects and elements of a fit act alone."""
    return tuple(e.place.channel for e in fit.effects if isinstance(e.place, OneChannel))
