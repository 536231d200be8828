"""An effect with its numbers, and the revisions of a rig: the effects that its simulation has been given."""

from datetime import date

from pydantic import Field

from modallab.core.frozen import Frozen
from modallab.core.places import NO_PLACE, Place


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
