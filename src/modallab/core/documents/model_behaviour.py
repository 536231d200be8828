"""How a structure behaves, as its modal model says it: what makes a response, where modes move, and how."""

from modallab.core.documents.model_use import ModelResult
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.units import Quantity, Test


class ParticipationView(ModelResult):
    """Shares of the modes in a response; with `outside` they add up to 1.

    Attributes:
        at: point of the force.
        of: point of the motion.
        quantity: of the motion.
        band_hz: band of an even force; null for a time.
        after_s: begin and end of the time after a hit; null for a band.
        frequency_hz: (modes,) frequency of each mode.
        share: (modes,) share of the total; a negative one reduces it.
        share_sigma: (modes,) one standard deviation.
        alone: (modes,) effective value of the mode alone, relative to the total.
        outside: share of modes outside the band of the model.
    """

    at: int
    of: int
    quantity: Quantity
    band_hz: tuple[float, float] | None
    after_s: tuple[float, float] | None
    frequency_hz: RealArray
    share: RealArray
    share_sigma: RealArray
    alone: RealArray
    outside: float


class ReductionView(ModelResult):
    """Number of values in measured FRFs and in their model, and the error of each pair.

    Attributes:
        outputs: (outputs,) channel names.
        output_points: (outputs,) points of the channels; null where unknown.
        input_points: (inputs,) driven points; null where unknown.
        measured_numbers: real numbers in the measured FRFs.
        model_numbers: real numbers in the model.
        error: (outputs, inputs) effective value of the difference, divided by the effective value of the measured FRF.
        frac: (outputs, inputs) FRAC of measured against regenerated.
    """

    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    measured_numbers: int
    model_numbers: int
    error: RealArray
    frac: RealArray


class NodeView(Frozen):
    """A node between points that lie along a line.

    Attributes:
        mode: from 1.
        place_m: place of the node, along x, y, z.
        place_sigma_m: one standard deviation along the line.
    """

    mode: int
    place_m: RealArray
    place_sigma_m: float


class NodesView(ModelResult):
    """Antinode and nodes of each mode.

    Attributes:
        frequency_hz: (modes,) frequency of each mode.
        points: (points,) known points.
        axes: (points,) axis of motion at each.
        motion: (modes, points) motion relative to the largest of the mode.
        motion_sigma: (modes, points) one standard deviation.
        antinode: (modes,) point of the largest motion.
        near_node: (modes,) points near a node.
        crossings: nodes between points along a line.
        advice: advice where to hit and where to mount, in sentences.
    """

    frequency_hz: RealArray
    points: tuple[int, ...]
    axes: tuple[str, ...]
    motion: RealArray
    motion_sigma: RealArray
    antinode: tuple[int, ...]
    near_node: tuple[tuple[int, ...], ...]
    crossings: tuple[NodeView, ...]
    advice: tuple[str, ...]


class ShapesView(ModelResult):
    """A structure as points and lines, and its motion in each mode.

    Attributes:
        frequency_hz: (modes,) frequency of each mode.
        points: (places,) points of the rig; 0 for a clamp.
        places_m: (places, 3) coordinates.
        lines: pairs of joined places, from 0.
        surfaces: places around each face, from 0.
        motion: (modes, places, 3) complex, along x, y, z, the largest of each mode 1; 0 if unknown.
    """

    frequency_hz: RealArray
    points: tuple[int, ...]
    places_m: RealArray
    lines: tuple[tuple[int, int], ...]
    surfaces: tuple[tuple[int, ...], ...]
    motion: ComplexArray


class DeflectionView(Frozen):
    """The operating deflection shape from measured FRFs, at the line nearest to a frequency.

    Attributes:
        test: test of the FRFs.
        frequency_hz: frequency of that line.
        at: point of the force.
        points: (points,) moving points.
        axes: (points,) axis of motion at each.
        values: (points,) mobility, complex.
        sigma: (points,) one standard deviation of each, None if unknown.
    """

    test: Test | None
    frequency_hz: float
    at: int
    points: tuple[int, ...]
    axes: tuple[str, ...]
    values: ComplexArray
    sigma: RealArray
