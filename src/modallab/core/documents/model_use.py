"""A modal model put to use: FRFs, and responses to forces."""

from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.frf import FrfQuantity
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.units import Quantity, Test

Force = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Step = Annotated[float, Field(ge=1e-9, le=1e3)]


class PredictedFrf(Frozen):
    """FRFs of a model between points, measured pairs or not.

    Attributes:
        test: whose model.
        quantity: receptance, mobility or inertance.
        frequency_hz: (lines,) evenly over the band of the model.
        outputs: (outputs,) points of the motion.
        inputs: (inputs,) points of the force.
        values: (outputs, inputs, lines) complex, SI.
        sigma: (outputs, inputs, lines) one standard deviation.
    """

    test: Test | None
    quantity: FrfQuantity
    frequency_hz: RealArray
    outputs: tuple[int, ...]
    inputs: tuple[int, ...]
    values: ComplexArray
    sigma: RealArray


class ResponseNew(Frozen):
    """Forces whose response is asked for.

    Attributes:
        test: whose model; null for the first.
        at: points of the forces.
        forces_n: (forces, samples) a row for each point.
        step_s: between samples.
        of: points whose motion is asked for; null for all that have a sensor.
        quantity: of the motion.
        between: what a force is between its samples.
    """

    test: Test | None = None
    at: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=100)]
    forces_n: Annotated[tuple[tuple[Force, ...], ...], Field(min_length=1, max_length=100)]
    step_s: Step
    of: Annotated[tuple[PositiveInt, ...], Field(min_length=1, max_length=1000)] | None = None
    quantity: Literal["displacement", "velocity", "acceleration"] = "acceleration"
    between: Literal["band-limited", "linear"] = "band-limited"


class ResponseView(Frozen):
    """The motion that forces give.

    Attributes:
        test: whose model.
        quantity: of the motion, in SI units.
        step_s: between samples.
        of: (points,) that move.
        values: (points, samples).
        peak: (points,) largest absolute value.
        rms: (points,) effective value.
    """

    test: Test | None
    quantity: Quantity
    step_s: float
    of: tuple[int, ...]
    values: RealArray
    peak: RealArray
    rms: RealArray
