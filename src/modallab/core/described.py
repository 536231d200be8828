"""What a diagnosis says of a gap that no effect of the catalogue explains: what it behaves like."""

from pydantic import Field

from modallab.core.effects import Effect
from modallab.core.frozen import Frozen
from modallab.core.places import NO_PLACE, Place, place_as_shares


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
