"""A modal model put to use: what makes a response, where modes move, FRFs, and responses to forces."""

from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.frf import FrfQuantity
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.units import Quantity, Test

Force = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Step = Annotated[float, Field(ge=1e-9, le=1e3)]


class ParticipationView(Frozen):
    """Which modes make the response at a point: shares, with `outside`, add up to 1.

    Attributes:
        test: whose model.
        at: point of the force.
        of: point of the motion.
        quantity: of the motion.
        band_hz: of an even force.
        frequency_hz: (modes,) of each mode.
        share: (modes,) of the whole; below 0 against the others.
        share_sigma: (modes,) one standard deviation.
        alone: (modes,) effective value of a mode's part alone, over that of the whole.
        outside: share of what lies outside the band of the model.
    """

    test: Test | None
    at: int
    of: int
    quantity: Quantity
    band_hz: tuple[float, float]
    frequency_hz: RealArray
    share: RealArray
    share_sigma: RealArray
    alone: RealArray
    outside: float


class CrossingView(Frozen):
    """A node between points that lie along a line.

    Attributes:
        mode: from 1.
        place_m: where it is, along x, y, z.
        place_sigma_m: one standard deviation along the line.
    """

    mode: int
    place_m: RealArray
    place_sigma_m: float


class NodesView(Frozen):
    """Where each mode moves most and where its nodes are.

    Attributes:
        test: whose model.
        frequency_hz: (modes,) of each mode.
        points: (points,) that are known.
        axes: (points,) of motion at each.
        motion: (modes, points) over the largest of the mode.
        motion_sigma: (modes, points) one standard deviation.
        antinode: (modes,) point where each moves most.
        near_node: (modes,) points near a node of each.
        crossings: nodes between points along a line.
        advice: where to hit and where to mount, in sentences.
    """

    test: Test | None
    frequency_hz: RealArray
    points: tuple[int, ...]
    axes: tuple[str, ...]
    motion: RealArray
    motion_sigma: RealArray
    antinode: tuple[int, ...]
    near_node: tuple[tuple[int, ...], ...]
    crossings: tuple[CrossingView, ...]
    advice: tuple[str, ...]


class DeflectionView(Frozen):
    """The operating deflection shape that measured FRFs show at their line nearest to a frequency.

    Attributes:
        test: whose FRFs.
        frequency_hz: of that line.
        at: point of the force.
        points: (points,) that move.
        axes: (points,) of motion at each.
        values: (points,) mobility, complex.
    """

    test: Test | None
    frequency_hz: float
    at: int
    points: tuple[int, ...]
    axes: tuple[str, ...]
    values: ComplexArray


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
