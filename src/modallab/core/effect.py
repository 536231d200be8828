"""Effects with their numbers: of the catalogue, learned in place of one, or given to a rig's simulation."""

from datetime import date
from typing import Annotated, Literal

from pydantic import Field, ValidationError, ValidatorFunctionWrapHandler, WrapValidator
from pydantic_core import PydanticCustomError

from modallab.core.frozen import Frozen, is_not_stated


class NoPlace(Frozen):
    """An effect of the whole bench, or an effect with a free place."""


NO_PLACE = NoPlace()


class AlongBeam(Frozen):
    """A place along the beam.

    Attributes:
        x: share of the length, from the clamp.
        x_m: the same in metres, in a diagnosis.
    """

    x: float
    x_m: float | None = Field(default=None, exclude_if=is_not_stated)


class AllAlongBeam(Frozen):
    """The whole beam.

    Attributes:
        x: the word `all`.
    """

    x: Literal["all"] = "all"


class OneChannel(Frozen):
    """A channel.

    Attributes:
        channel: row of the channel in the rig.
        level_v: clipping voltage, in a diagnosis.
    """

    channel: int
    level_v: float | None = Field(default=None, exclude_if=is_not_stated)


class TwoChannels(Frozen):
    """Two channels.

    Attributes:
        channel: rows of the channels in the rig.
    """

    channel: tuple[int, int]


class AllChannels(Frozen):
    """All channels.

    Attributes:
        channel: the word `all`.
    """

    channel: Literal["all"] = "all"


class FixedPlace(Frozen):
    """A fixed place of an effect.

    Attributes:
        where: the base, the hit point, or the impact test as a whole.
    """

    where: Literal["base", "hit", "impact"]


def _as_one_error(content: object, read: ValidatorFunctionWrapHandler) -> object:
    """A place, or one error where each of the forms would raise its own."""
    try:
        return read(content)
    except ValidationError:
        raise PydanticCustomError(
            "place",
            "x (a share of the length, or all), channel (a row, two rows, or all), or where (base, hit or impact)",
        ) from None


Place = Annotated[
    NoPlace | AlongBeam | AllAlongBeam | OneChannel | TwoChannels | AllChannels | FixedPlace,
    WrapValidator(_as_one_error),
]
"""Where an effect of the catalogue acts."""
RowsOfPlace = int | tuple[int, int] | Literal["all"]


class NearPoint(Frozen):
    """A place on a measured structure.

    Attributes:
        point: the nearest.
        at_m: x, y and z.
        axis: along which it acts, of what has a direction.
    """

    point: int
    at_m: tuple[float, float, float]
    axis: str | None = Field(default=None, exclude_if=is_not_stated)


class BetweenPoints(Frozen):
    """Two points of a measured structure, and what connects them.

    Attributes:
        points: both.
        at_m: x, y and z half-way.
        axis: along which it acts.
    """

    points: tuple[int, int]
    at_m: tuple[float, float, float]
    axis: str


class NamedChannel(Frozen):
    """A channel of a modal model.

    Attributes:
        channel: its name.
    """

    channel: str


class EveryOutput(Frozen):
    """All outputs of a modal model.

    Attributes:
        channels: all of them.
    """

    channels: Literal["all"] = "all"


PlaceOnStructure = NearPoint | BetweenPoints | NamedChannel | EveryOutput
"""Where a change of a measured structure acts."""


def channels_of_place(place: Place) -> RowsOfPlace | None:
    """The rows of the rig that a place is; None where it is none."""
    return place.channel if isinstance(place, OneChannel | TwoChannels | AllChannels) else None


def x_m_of(place: Place) -> float | None:
    """Metres from the clamp, where a diagnosis reports them."""
    return place.x_m if isinstance(place, AlongBeam) else None


def place_in_metres(place: Place, length_m: float) -> Place:
    """The same as a diagnosis reports it, on a beam of this length."""
    return place.model_copy(update={"x_m": place.x * length_m}) if isinstance(place, AlongBeam) else place


def place_relative_to_length(place: Place) -> Place:
    """The same as the catalogue has it."""
    return AlongBeam(x=place.x) if isinstance(place, AlongBeam) else place


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
        return Effect(effect=self.element, parameters=self.parameters, place=place_relative_to_length(self.place))


class AlternativeDescription(Frozen):
    """Another description, fitted to convergence.

    Attributes:
        says: the description in words.
        gap: gap that it leaves on the fitted records, in noise units.
    """

    says: str
    gap: float
