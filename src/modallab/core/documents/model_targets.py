"""A modal model beside another one of its structure, and the change that a wanted property needs."""

from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.documents.model_change import Frequency, Mass
from modallab.core.documents.model_use import ModelRequest, ModelResult
from modallab.core.frozen import Frozen, RealArray
from modallab.core.units import Test


class ModePairView(Frozen):
    """A pair of corresponding modes, numbered from 1 in each model.

    Attributes:
        mode: of the one.
        other: of the other.
        mac: MAC of their shapes.
        frequency_hz: frequencies of both.
        frequency_sigma_hz: standard deviations of both; null if unknown.
        damping_ratio: of both.
    """

    mode: int
    other: int
    mac: float
    frequency_hz: RealArray
    frequency_sigma_hz: RealArray
    damping_ratio: RealArray


class CorrelationView(Frozen):
    """Pairs of modes of two models.

    Attributes:
        test: test of this model.
        other_test: test of the other model.
        points: (points,) common points.
        axes: (points,) axis of motion at each.
        pairs: pairs of corresponding modes.
        mac: (modes, modes of the other).
        comac: (points,) low where a point disagrees in many modes.
    """

    test: Test | None
    other_test: Test | None
    points: tuple[int, ...]
    axes: tuple[str, ...]
    pairs: tuple[ModePairView, ...]
    mac: RealArray
    comac: RealArray


class ChangeForFrequencyRequest(ModelRequest):
    """A frequency to which a mode is moved.

    Attributes:
        mode: from 1.
        to_hz: wanted frequency.
        by: kind of change: a mass, or a spring to ground.
        at: points to try; null for all with a sensor.
    """

    mode: PositiveInt
    to_hz: Frequency
    by: Literal["mass", "spring"]
    at: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=100)] | None = None


class ChangeForFrequencyView(Frozen):
    """The change that moves a mode to a frequency at a point.

    Attributes:
        at: point of the change.
        size: mass in kg or stiffness in N/m; null if no size succeeds.
        sigma: standard deviation of the size.
        hz_sigma: standard deviation of the resulting frequency; null if no size succeeds.
        lowest_hz: lowest frequency that any size reaches there.
        highest_hz: highest frequency that any size reaches there.
    """

    at: int
    size: float | None
    sigma: float | None
    hz_sigma: float | None
    lowest_hz: float
    highest_hz: float


class ChangesForFrequencyView(ModelResult):
    """The same at several points, the smallest first.

    Attributes:
        tunings: one for each point.
    """

    tunings: tuple[ChangeForFrequencyView, ...]


class ChangeForFreeBandRequest(ModelRequest):
    """A band to keep free of modes.

    Attributes:
        low_hz: lower edge of the band.
        high_hz: upper edge of the band.
        by: kind of change: a mass, or a spring to ground.
        at: points to try; null for all with a sensor.
    """

    low_hz: Frequency
    high_hz: Frequency
    by: Literal["mass", "spring"]
    at: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=100)] | None = None


class ChangeForFreeBandView(Frozen):
    """The change that leaves no mode in a band at a point, or the mode that stays there.

    Attributes:
        at: point of the change.
        size: mass in kg or stiffness in N/m; 0 if the band is already free, null if no size succeeds.
        sigma: standard deviation of the size.
        up_to: size above which the next mode enters the band; null if none does.
        stays: mode, from 1, that no size moves out of the band; null if there is an answer.
        stays_hz: frequency of that mode at the largest size tried.
    """

    at: int
    size: float | None
    sigma: float | None
    up_to: float | None
    stays: int | None
    stays_hz: float | None


class ChangesForFreeBandView(ModelResult):
    """The changes at several points, the smallest first.

    Attributes:
        answers: one answer for each point.
    """

    answers: tuple[ChangeForFreeBandView, ...]


class BestAbsorberRequest(ModelRequest):
    """The absorber of a given mass that makes the peak of a mode at a point smallest.

    Attributes:
        mode: from 1.
        at: point of the absorber.
        mass_kg: mass of the absorber.
    """

    mode: PositiveInt
    at: PositiveInt
    mass_kg: Mass


class BestAbsorberView(ModelResult):
    """The best absorber.

    Attributes:
        at: point of the absorber.
        mass_kg: mass of the absorber.
        frequency_hz: natural frequency of the absorber on a fixed point.
        damping_ratio: of it.
        mass_ratio: mass of the absorber over the modal mass at the point.
        peak_before: peak of the mobility at the point about the mode, m/(N s).
        peak_before_sigma: one standard deviation.
        peak_after: the same peak with the absorber.
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
