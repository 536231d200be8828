"""A description under trial: a fit with elements, on records that may have been freed of what a channel did to them."""

from dataclasses import dataclass

from modallab.core.described import Learned
from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.search.choose import Choice
from modallab.gap.search.intervals import intervals
from modallab.twin.learned import elements


@dataclass(frozen=True, eq=False, slots=True)
class Description:
    """What a gap behaves like.

    Attributes:
        fit: the twin, elements that it can hold included.
        unseen: records that no fit has seen, freed as those were.
        learned: the elements.
        rows: channels concerned.
    """

    fit: Fit
    unseen: Reduced
    learned: tuple[Learned, ...]
    rows: tuple[int, ...] = ()


def of_fit(base: Fit, fit: Fit, unseen: Reduced, rows: tuple[int, ...] = ()) -> Description:
    """The description that a fit of elements is."""
    length = fit.problem.data.rig.beam.length_m if fit.problem.data.rig.beam is not None else 1.0
    found: list[Learned] = []
    for effect, believed in zip(fit.effects, intervals(Choice(base, fit, (), True, False)), strict=True):
        place: dict[str, object] = dict(effect.place)
        x = effect.place.get("x")
        if isinstance(x, float):
            place["x_m"] = x * length
        found.append(
            Learned(
                element=effect.effect,
                parameters=effect.parameters,
                interval=believed.within,
                not_known=believed.not_known,
                place=dict(place),
            )
        )
    return Description(fit, unseen, tuple(found), rows)


def stage_of(description: Description) -> str:
    """Where its elements act."""
    return elements()[description.learned[0].element].kind.stage
