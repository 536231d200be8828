"""Effects with their numbers: of the catalogue, learned in place of one, or given to a rig's simulation."""

from datetime import date

from pydantic import Field

from modallab.core.frozen import Frozen
from modallab.core.places import NO_PLACE, Place, place_as_shares


class Effect(Frozen):
    """An effect with its numbers: what the twin adds, what a diagnosis names.

    Attributes:
        effect: its name in the catalogue.
        parameters: name -> number, SI.
        place: as in the catalogue; x is a share of the length.
    """

    effect: str
    parameters: dict[str, float] = Field(default_factory=dict[str, float])
    place: Place = NO_PLACE


class Revision(Frozen):
    """A step by which the simulation of a rig came closer to the bench: a diagnosis that was applied.

    Attributes:
        effects: that the twin and the simulated bench carry from then on, beside those of the revisions before.
        applied_on: day it was applied.
        before: gap of the simulation without them, in noise units, on records held out of the fit; 1 is the floor.
        after: the same with them.
        closed: share of the reducible gap that they close there; None where there was next to none.
        source: the campaign that was diagnosed, or its diagnosis, in words.
    """

    effects: tuple[Effect, ...]
    applied_on: date
    before: float
    after: float
    closed: float | None = None
    source: str = ""


class Learned(Frozen):
    """A learned element of the twin: what the gap behaves like, and no cause.

    Attributes:
        element: its name: point_law, beam_law, row_filter, row_curve or row_hold.
        parameters: SI; a number that is not given is none.
        interval: parameter -> (low, high) of 95 %; None where the records leave the number open.
        not_known: parameter -> why it has no interval.
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
    """Another description that was fitted to the end.

    Attributes:
        says: it in words.
        gap: that it leaves on the records that were fitted, in noise units.
    """

    says: str
    gap: float
