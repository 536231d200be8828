"""Where an effect acts: one class a form. Their fields distinguish them, so a document needs no further tag."""

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


def rows_of(place: Place) -> RowsOfPlace | None:
    """The rows of the rig that a place is; None where it is none."""
    return place.channel if isinstance(place, OneChannel | TwoChannels | AllChannels) else None


def x_m_of(place: Place) -> float | None:
    """Metres from the clamp, where a diagnosis reports them."""
    return place.x_m if isinstance(place, AlongBeam) else None


def place_in_metres(place: Place, length_m: float) -> Place:
    """The same as a diagnosis reports it, on a beam of this length."""
    return place.model_copy(update={"x_m": place.x * length_m}) if isinstance(place, AlongBeam) else place


def place_as_shares(place: Place) -> Place:
    """The same as the catalogue has it."""
    return AlongBeam(x=place.x) if isinstance(place, AlongBeam) else place
