"""A structure changed, by its modal model: what is hung on it, and the modes that it then has."""

from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.documents.model_use import AskedOfModel, OfModel
from modallab.core.frozen import ComplexArray, Frozen, RealArray

Added = Annotated[float, Field(ge=-1e12, le=1e12, allow_inf_nan=False)]
Mass = Annotated[float, Field(ge=1e-9, le=1e9)]
Frequency = Annotated[float, Field(ge=1e-3, le=1e6)]


class ElementNew(Frozen):
    """A mass, spring or damper at a point to ground, or between two points.

    Attributes:
        at: point.
        to: the other end of spring and damper; null for ground.
        mass_kg: below 0 for one that is taken away.
        spring_n_per_m: stiffness.
        damper_n_s_per_m: viscous damping.
    """

    kind: Literal["element"] = "element"
    at: PositiveInt
    to: PositiveInt | None = None
    mass_kg: Added = 0.0
    spring_n_per_m: Added = 0.0
    damper_n_s_per_m: Added = 0.0


class AbsorberNew(Frozen):
    """A tuned absorber at a point.

    Attributes:
        at: point.
        mass_kg: of it.
        frequency_hz: of it on a point at rest.
        damping_ratio: of it.
    """

    kind: Literal["absorber"]
    at: PositiveInt
    mass_kg: Mass
    frequency_hz: Frequency
    damping_ratio: Annotated[float, Field(ge=0, lt=1)]


class LinkNew(Frozen):
    """A rigid link of a point to ground, or to another point.

    Attributes:
        at: point.
        to: the other point; null for ground.
    """

    kind: Literal["link"]
    at: PositiveInt
    to: PositiveInt | None = None


class CouplingNew(Frozen):
    """Another structure, known by the newest model of its campaign, held to this one.

    Attributes:
        campaign: of the other structure.
        pairs: each a point of this structure, and one of the other.
        joint_n_per_m: stiffness of the joint at each pair; null for rigid ones.
        remove: whether it is taken away from a measurement of both, such as a fixture.
    """

    kind: Literal["coupling"]
    campaign: str
    pairs: Annotated[tuple[tuple[PositiveInt, PositiveInt], ...], Field(min_length=1, max_length=100)]
    joint_n_per_m: Annotated[float, Field(ge=1e-9, le=1e15)] | None = None
    remove: bool = False


ChangeNew = Annotated[ElementNew | AbsorberNew | LinkNew | CouplingNew, Field(discriminator="kind")]


class PairNew(Frozen):
    """An FRF that is asked for.

    Attributes:
        at: point of the force.
        of: point of the motion.
        lines: evenly over the band of the model; more are added about each mode before and after.
    """

    at: PositiveInt
    of: PositiveInt
    lines: Annotated[int, Field(ge=2, le=4000)] = 500


class ModificationNew(AskedOfModel):
    """Changes of a structure, all at once.

    Attributes:
        changes: what is hung on the structure.
        frf: whose mobility is asked for before and after; null for none.
        check: campaign that was measured with the changes; null for none.
    """

    changes: Annotated[tuple[ChangeNew, ...], Field(min_length=1, max_length=20)]
    frf: PairNew | None = None
    check: str | None = None


class MobilityView(Frozen):
    """The mobility of one pair of points before and after a change, in m/(N s).

    Attributes:
        frequency_hz: (lines,) over the band of the model.
        before: (lines,) complex.
        after: (lines,) complex.
    """

    frequency_hz: RealArray
    before: ComplexArray
    after: ComplexArray


class CheckedMode(Frozen):
    """A mode that was predicted, and then measured.

    Attributes:
        mode: of the prediction, from 1.
        predicted_hz: of it.
        predicted_sigma_hz: one standard deviation.
        measured_hz: of the nearest mode of the model with the changes.
        inside: whether it lies in the 95 % interval of both.
        words: the same as a sentence.
    """

    mode: int
    predicted_hz: float
    predicted_sigma_hz: float
    measured_hz: float
    inside: bool
    words: str


class ModifiedView(OfModel):
    """The modes of a structure after changes.

    Attributes:
        changes: in words.
        frequency_hz: (modes,) after.
        frequency_sigma_hz: (modes,) one standard deviation.
        damping_ratio: (modes,) after.
        damping_sigma: (modes,) one standard deviation.
        like: (modes,) the mode before whose shape is most like it, from 1.
        mac: (modes,) of the two shapes.
        outside: (modes,) part of the frequency that what lies outside the band moves it by.
        conditioning: by which factor errors at the joint to another structure grow, from 1 on; null without one.
        notes: how far it can be trusted.
        before_hz: (modes before,) of the model without the changes.
        motion: (modes, places, 3) complex, after, as `ShapesView` has it; null where no places are known.
        frf: the mobility that was asked for.
        checked: modes of the campaign that was measured with the changes.
    """

    changes: tuple[str, ...]
    frequency_hz: RealArray
    frequency_sigma_hz: RealArray
    damping_ratio: RealArray
    damping_sigma: RealArray
    like: tuple[int, ...]
    mac: RealArray
    outside: RealArray
    conditioning: float | None
    notes: tuple[str, ...]
    before_hz: RealArray
    motion: ComplexArray | None
    frf: MobilityView | None
    checked: tuple[CheckedMode, ...]
