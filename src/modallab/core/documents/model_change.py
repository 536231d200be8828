"""A structure changed, by its modal model: what is hung on it, and the modes that it then has."""

from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.documents.model_use import ModelRequest, ModelResult
from modallab.core.frozen import ComplexArray, Frozen, RealArray

Added = Annotated[float, Field(ge=-1e12, le=1e12, allow_inf_nan=False)]
Mass = Annotated[float, Field(ge=1e-9, le=1e9)]
Frequency = Annotated[float, Field(ge=1e-3, le=1e6)]


class ElementRequest(Frozen):
    """A mass, spring or damper at a point to ground, or between two points.

    Attributes:
        at: point.
        to: other end of spring and damper; null for ground.
        mass_kg: mass; a negative one is removed.
        spring_n_per_m: stiffness.
        damper_n_s_per_m: viscous damping.
    """

    kind: Literal["element"] = "element"
    at: PositiveInt
    to: PositiveInt | None = None
    mass_kg: Added = 0.0
    spring_n_per_m: Added = 0.0
    damper_n_s_per_m: Added = 0.0


class AbsorberRequest(Frozen):
    """A tuned absorber at a point.

    Attributes:
        at: point.
        mass_kg: mass of the absorber.
        frequency_hz: natural frequency of the absorber on a fixed point.
        damping_ratio: of it.
    """

    kind: Literal["absorber"]
    at: PositiveInt
    mass_kg: Mass
    frequency_hz: Frequency
    damping_ratio: Annotated[float, Field(ge=0, lt=1)]


class LinkRequest(Frozen):
    """A rigid link of a point to ground, or to another point.

    Attributes:
        at: point.
        to: other point; null for ground.
    """

    kind: Literal["link"]
    at: PositiveInt
    to: PositiveInt | None = None


class CouplingRequest(Frozen):
    """Another structure coupled to this one, given by the newest model of its campaign.

    Attributes:
        campaign: campaign of the other structure.
        pairs: pairs of a point of this structure and one of the other.
        joint_n_per_m: stiffness of the joint at each pair; null for rigid ones.
        remove: whether it is removed from a measurement of both, such as a fixture.
    """

    kind: Literal["coupling"]
    campaign: str
    pairs: Annotated[tuple[tuple[PositiveInt, PositiveInt], ...], Field(min_length=1, max_length=100)]
    joint_n_per_m: Annotated[float, Field(ge=1e-9, le=1e15)] | None = None
    remove: bool = False


ChangeNew = Annotated[ElementRequest | AbsorberRequest | LinkRequest | CouplingRequest, Field(discriminator="kind")]


class FrfRequest(Frozen):
    """Request for an FRF.

    Attributes:
        at: point of the force.
        of: point of the motion.
        lines: number of frequencies spread evenly over the band of the model; more are added about each mode.
    """

    at: PositiveInt
    of: PositiveInt
    lines: Annotated[int, Field(ge=2, le=4000)] = 500


class ModificationRequest(ModelRequest):
    """Simultaneous changes of a structure.

    Attributes:
        changes: parts attached to the structure.
        frf: pair of points for the mobility before and after; null for none.
        check: campaign measured with the changes; null for none.
    """

    changes: Annotated[tuple[ChangeNew, ...], Field(min_length=1, max_length=20)]
    frf: FrfRequest | None = None
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
    """A predicted mode, compared with its measurement.

    Attributes:
        mode: number of the mode in the prediction, from 1.
        predicted_hz: of it.
        predicted_sigma_hz: one standard deviation.
        measured_hz: frequency of the nearest mode in the model with the changes.
        inside: whether the measured frequency lies in the 95 % interval of both.
        words: comparison as a sentence.
    """

    mode: int
    predicted_hz: float
    predicted_sigma_hz: float
    measured_hz: float
    inside: bool
    words: str


class ModifiedView(ModelResult):
    """The modes of a structure after changes.

    Attributes:
        changes: in words.
        frequency_hz: (modes,) frequency after the changes.
        frequency_sigma_hz: (modes,) one standard deviation.
        damping_ratio: (modes,) after.
        damping_sigma: (modes,) one standard deviation.
        like: (modes,) number of the original mode with the most similar shape, from 1.
        mac: (modes,) MAC of the two shapes.
        outside: (modes,) relative frequency shift by modes outside the band.
        conditioning: growth factor of errors at the joint to another structure, from 1 on; null without a joint.
        notes: sentences on the reliability.
        before_hz: (modes before,) frequency without the changes.
        motion: (modes, places, 3) complex, after the changes, as in `ShapesView`; null without known places.
        frf: requested mobility.
        checked: modes of the campaign measured with the changes.
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
