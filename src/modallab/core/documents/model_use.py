"""A modal model put to use: FRFs, responses to forces, state spaces."""

from typing import Annotated, Literal, Self

from pydantic import Field, NonNegativeInt, PositiveInt, model_validator

from modallab.core.frf import FrfQuantity
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.units import Quantity, Test

Newton = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Hertz = Annotated[float, Field(ge=0, le=1e6, allow_inf_nan=False)]
Density = Annotated[float, Field(ge=0, le=1e12, allow_inf_nan=False)]


class ImpulseForce(Frozen):
    """An impulse within one sample, the second.

    Attributes:
        impulse_n_s: time integral of the force.
    """

    kind: Literal["impulse"] = "impulse"
    impulse_n_s: Newton


class SineForce(Frozen):
    """A sine from the first sample on.

    Attributes:
        frequency_hz: of it.
        amplitude_n: of it.
    """

    kind: Literal["sine"] = "sine"
    frequency_hz: Hertz
    amplitude_n: Newton


class SweepForce(Frozen):
    """A sine whose frequency changes evenly over the record.

    Attributes:
        from_hz: frequency at the first sample.
        to_hz: frequency at the last sample.
        amplitude_n: of it.
    """

    kind: Literal["sweep"] = "sweep"
    from_hz: Hertz
    to_hz: Hertz
    amplitude_n: Newton


class RandomForce(Frozen):
    """A random force with a given spectrum.

    Attributes:
        spectrum: ascending frequencies in Hz with one-sided density in N^2/Hz; linear between them, zero outside.
        seed: seed of the random numbers.
    """

    kind: Literal["random"] = "random"
    spectrum: Annotated[tuple[tuple[Hertz, Density], ...], Field(min_length=2, max_length=10000)]
    seed: NonNegativeInt = 0

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if any(b <= a for (a, _), (b, _) in zip(self.spectrum, self.spectrum[1:], strict=False)):
            raise ValueError("the frequencies of a spectrum rise: sort them, and give each once")
        return self


ForceKind = Annotated[ImpulseForce | SineForce | SweepForce | RandomForce, Field(discriminator="kind")]

Force = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Step = Annotated[float, Field(ge=1e-9, le=1e3)]


class ModelResult(Frozen):
    """What a modal model says.

    Attributes:
        test: test of the model.
    """

    test: Test | None


class ModelRequest(Frozen):
    """What is asked of a modal model.

    Attributes:
        test: test of the model; null for the first.
    """

    test: Test | None = None


class PredictedFrf(ModelResult):
    """FRFs of a model between points, measured pairs or not.

    Attributes:
        quantity: receptance, mobility or inertance.
        frequency_hz: (lines,) evenly over the band of the model.
        outputs: (outputs,) points of the motion.
        inputs: (inputs,) points of the force.
        values: (outputs, inputs, lines) complex, SI.
        sigma: (outputs, inputs, lines) one standard deviation.
    """

    quantity: FrfQuantity
    frequency_hz: RealArray
    outputs: tuple[int, ...]
    inputs: tuple[int, ...]
    values: ComplexArray
    sigma: RealArray


class InitialMotionRequest(Frozen):
    """Motion of a point at the first sample.

    Attributes:
        at: point of the change.
        displacement_m: displacement of the point; null if only the velocity is known.
        velocity_m_s: velocity of the point; null if only the displacement is known.
    """

    at: PositiveInt
    displacement_m: Force | None = None
    velocity_m_s: Force | None = None


class ResponseRequest(ModelRequest):
    """Forces whose response is requested.

    Attributes:
        at: points of the forces.
        forces_n: (forces, samples) one row for each point; null with `forces`.
        forces: one for each point, by kind; null with `forces_n`.
        seconds: duration of forces given by kind.
        step_s: time between samples.
        of: points of the requested motion; null for all with a sensor.
        quantity: of the motion.
        between: course of a force between its samples.
        start: displacements and velocities at the first sample; null for rest.
        samples: whether to return the motion over time besides its figures.
    """

    at: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=100)]
    forces_n: Annotated[tuple[tuple[Force, ...], ...], Field(min_length=1, max_length=100)] | None = None
    forces: Annotated[tuple[ForceKind, ...], Field(min_length=1, max_length=100)] | None = None
    seconds: Annotated[float, Field(gt=0, le=1e6)] | None = None
    step_s: Step
    of: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=1000)] | None = None
    quantity: Literal["displacement", "velocity", "acceleration"] = "acceleration"
    between: Literal["band-limited", "linear"] = "band-limited"
    start: Annotated[tuple[InitialMotionRequest, ...], Field(max_length=1000)] | None = None
    samples: bool = True


class ResponseView(ModelResult):
    """The motion under forces.

    Attributes:
        quantity: quantity of the motion, in SI units.
        step_s: time between samples.
        of: (points,) that move.
        values: (points, samples) motion; null if only figures were requested.
        sigma: (points, samples) one standard deviation; null without `values`.
        peak: (points,) largest absolute value.
        peak_sigma: (points,) one standard deviation.
        rms: (points,) effective value.
        rms_sigma: (points,) one standard deviation.
        octaves_hz: (octaves,) centres of octave bands.
        levels: (points, octaves) effective value in each.
        levels_sigma: (points, octaves) one standard deviation.
        outside: share of the forces' power outside the band of the model, where the model is not valid.
    """

    quantity: Quantity
    step_s: float
    of: tuple[int, ...]
    values: RealArray | None
    sigma: RealArray | None
    peak: RealArray
    peak_sigma: RealArray
    rms: RealArray
    rms_sigma: RealArray
    octaves_hz: RealArray
    levels: RealArray
    levels_sigma: RealArray
    outside: float


class StateSpaceMatrices(Frozen):
    """x' = A x + B f, y = C x + D f, with two states for each mode and the forces f in N.

    Attributes:
        A: (states, states), two states for each mode.
        B: (states, inputs).
        C: (outputs, states).
        D: (outputs, inputs).
        inputs: names of the forces.
        outputs: names of the motions.
        unit: unit of the motions.
        frequency_hz: (modes,) in the order of the states: all real parts first, then all imaginary parts.
        frequency_sigma_hz: (modes,) one standard deviation.
        damping_ratio: (modes,).
        damping_sigma: (modes,) one standard deviation.
    """

    A: RealArray
    B: RealArray
    C: RealArray
    D: RealArray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    unit: str
    frequency_hz: RealArray
    frequency_sigma_hz: RealArray
    damping_ratio: RealArray
    damping_sigma: RealArray


class StateSpaceView(ModelResult, StateSpaceMatrices):
    """The state space of a campaign's newest model."""
