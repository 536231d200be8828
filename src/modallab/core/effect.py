"""Effects with their numbers: of the catalogue, learned in place of one, or given to a rig's simulation."""

from datetime import date

from pydantic import Field

from modallab.core.frozen import Frozen
from modallab.core.places import NO_PLACE, Place, place_as_shares


class Effect(Frozen):
    """An effect with its numbers, in the twin and in a diagnosis.

    Attributes:
        effect: name in the catalogue.
        parameters: name -> number, SI.
        place: as in the catalogue; x is a share of the length.
    """

    effect: str
    parameters: dict[str, float] = Field(default_factory=dict[str, float])
    place: Place = NO_PLACE


class Revision(Frozen):
    """A revision of the simulation of a rig: a diagnosis that was applied.

    Attributes:
        effects: effects that the twin and the simulated bench include from then on, besides those of earlier
            revisions.
        applied_on: date of the revision.
        before: gap of the simulation without the effects, in noise units, on held-out records; 1 is the floor.
        after: gap with the effects.
        closed: share of the reducible gap that the effects close there; None if there was almost none.
        source: diagnosed campaign, or its diagnosis, in words.
    """

    effects: tuple[Effect, ...]
    applied_on: date
    before: float
    after: float
    closed: float | None = None
    source: str = ""


class LearnedElement(Frozen):
    """A learned element of the twin: a description of the gap, not its cause.

    Attributes:
        element: name: point_law, beam_law, row_filter, row_curve or row_hold.
        parameters: parameters in SI units; a missing number is zero.
        interval: parameter -> (low, high) of the 95 % interval; None if the records leave the number open.
        not_known: parameter -> reason for a missing interval.
        place: channel, or x as a share of the length with x_m in metres.
    """

    element: str
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float] | None] = Field(default_factory=dict[str, tuple[float, float] | None])
    not_known: dict[str, str] = Field(default_factory=dict[str, str])
    place: Place = NO_PLACE

    def as_effect(self) -> Effect:
        """The element for the twin."""
        return Effect(effect=self.element, parameters=self.parameters, place=place_as_shares(self.place))


class Alternative(Frozen):
    """Another description, fitted to convergence.

    Attributes:
        says: the description in words.
        gap: gap that it leaves on the fitted records, in noise units.
    """

    says: str
    gap: float
