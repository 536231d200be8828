"""A modal model beside another one of its structure, and the change that a wanted property needs."""

from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.documents.model_change import Frequency, Mass
from modallab.core.documents.model_use import AskedOfModel, OfModel
from modallab.core.frozen import Frozen, RealArray
from modallab.core.units import Test


class PairView(Frozen):
    """Two modes that are the same, from 1 in each model.

    Attributes:
        mode: of the one.
        other: of the other.
        mac: of their shapes.
        frequency_hz: of both.
        frequency_sigma_hz: one standard deviation of both; null where not known.
        damping_ratio: of both.
    """

    mode: int
    other: int
    mac: float
    frequency_hz: RealArray
    frequency_sigma_hz: RealArray
    damping_ratio: RealArray


class CorrelationView(Frozen):
    """Which modes of two models are the same.

    Attributes:
        test: of the one.
        other_test: of the other.
        points: (points,) that both have.
        axes: (points,) of motion at each.
        pairs: modes that are the same.
        mac: (modes, modes of the other).
        comac: (points,) low where a point disagrees in many modes.
    """

    test: Test | None
    other_test: Test | None
    points: tuple[int, ...]
    axes: tuple[str, ...]
    pairs: tuple[PairView, ...]
    mac: RealArray
    comac: RealArray


class ChangeForFrequencyNew(AskedOfModel):
    """A frequency that a mode shall have.

    Attributes:
        mode: from 1.
        to_hz: that frequency.
        by: what is hung on the structure: a mass, or a spring to ground.
        at: points to try; null for all that have a sensor.
    """

    mode: PositiveInt
    to_hz: Frequency
    by: Literal["mass", "spring"]
    at: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=100)] | None = None


class ChangeForFrequencyView(Frozen):
    """What brings a mode to a frequency at a point.

    Attributes:
        at: the point.
        size: kg or N/m; null where none does.
        sigma: of it, one standard deviation.
        hz_sigma: of the frequency it gives; null where none does.
        lowest_hz: of the frequencies that any size reaches there.
        highest_hz: of them.
    """

    at: int
    size: float | None
    sigma: float | None
    hz_sigma: float | None
    lowest_hz: float
    highest_hz: float


class ChangesForFrequencyView(OfModel):
    """The same at several points, the smallest first.

    Attributes:
        tunings: one for each point.
    """

    tunings: tuple[ChangeForFrequencyView, ...]


class ChangeForFreeBandNew(AskedOfModel):
    """A band that shall hold no mode.

    Attributes:
        low_hz: its lower edge.
        high_hz: its upper edge.
        by: what is hung on the structure: a mass, or a spring to ground.
        at: points to try; null for all that have a sensor.
    """

    low_hz: Frequency
    high_hz: Frequency
    by: Literal["mass", "spring"]
    at: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=100)] | None = None


class ChangeForFreeBandView(Frozen):
    """What leaves no mode in a band at a point, or the mode that stays there.

    Attributes:
        at: the point.
        size: kg or N/m; 0 where the band is free already, null where none does.
        sigma: of it, one standard deviation.
        up_to: size from which the next mode is in the band; null where none comes.
        stays: the mode, from 1, that no size brings out of the band; null where there is an answer.
        stays_hz: where that mode is at the largest size that was tried.
    """

    at: int
    size: float | None
    sigma: float | None
    up_to: float | None
    stays: int | None
    stays_hz: float | None


class ChangesForFreeBandView(OfModel):
    """The same at several points, the smallest first.

    Attributes:
        answers: one for each point.
    """

    answers: tuple[ChangeForFreeBandView, ...]


class BestAbsorberNew(AskedOfModel):
    """A mode whose motion at a point shall be as small as an absorber of a mass makes it.

    Attributes:
        mode: from 1.
        at: where the absorber hangs.
        mass_kg: of it.
    """

    mode: PositiveInt
    at: PositiveInt
    mass_kg: Mass


class BestAbsorberView(OfModel):
    """That absorber.

    Attributes:
        at: where it hangs.
        mass_kg: of it.
        frequency_hz: of it on a point at rest.
        damping_ratio: of it.
        mass_ratio: its mass over the modal mass at the point.
        peak_before: of the mobility at the point about the mode, m/(N s).
        peak_before_sigma: one standard deviation.
        peak_after: the same with it.
        peak_after_sigma: one standard deviation.
    """

    at: int
    mass_kg: float
    frequency_hz: float
    damping_ratio: float
    mass_ratio: float
    peak_before: float
    peak_before_sigma: float
    peak_after: float
    peak_after_sigma: float
