"""How a structure behaves, as its modal model says it: what makes a response, where modes move, and how."""

from modallab.core.documents.model_use import OfModel
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.units import Quantity, Test


class ParticipationView(OfModel):
    """Which modes make the response at a point: shares, with `outside`, add up to 1.

    Attributes:
        at: point of the force.
        of: point of the motion.
        quantity: of the motion.
        band_hz: of an even force; null over a time.
        after_s: begin and end of the time after a hit; null over a band.
        frequency_hz: (modes,) of each mode.
        share: (modes,) of the whole; below 0 against the others.
        share_sigma: (modes,) one standard deviation.
        alone: (modes,) effective value of a mode's part alone, over that of the whole.
        outside: share of what lies outside the band of the model.
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


class ReductionView(OfModel):
    """The size of measured FRFs and of their model, and how far each pair is off.

    Attributes:
        outputs: (outputs,) channel names.
        output_points: (outputs,) where they are; null where unknown.
        input_points: (inputs,) points that were driven; null where unknown.
        measured_numbers: real numbers in the measured FRFs.
        model_numbers: real numbers in the model.
        error: (outputs, inputs) effective value of the difference, over that of the measured FRF.
        frac: (outputs, inputs) FRAC of measured against regenerated.
    """

    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    measured_numbers: int
    model_numbers: int
    error: RealArray
    frac: RealArray


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


class NodesView(OfModel):
    """Where each mode moves most and where its nodes are.

    Attributes:
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

    frequency_hz: RealArray
    points: tuple[int, ...]
    axes: tuple[str, ...]
    motion: RealArray
    motion_sigma: RealArray
    antinode: tuple[int, ...]
    near_node: tuple[tuple[int, ...], ...]
    crossings: tuple[CrossingView, ...]
    advice: tuple[str, ...]


class ShapesView(OfModel):
    """A structure as points and lines, and how it moves in each mode.

    Attributes:
        frequency_hz: (modes,) of each mode.
        points: (places,) points of the rig; 0 for a clamp.
        places_m: (places, 3) where they are.
        lines: pairs of places, from 0, that are joined.
        surfaces: places, from 0, around a face each.
        motion: (modes, places, 3) complex, along x, y, z, the largest of each mode 1; 0 where it is not known.
    """

    frequency_hz: RealArray
    points: tuple[int, ...]
    places_m: RealArray
    lines: tuple[tuple[int, int], ...]
    surfaces: tuple[tuple[int, ...], ...]
    motion: ComplexArray


class DeflectionView(Frozen):
    """The operating deflection shape that measured FRFs show at their line nearest to a frequency.

    Attributes:
        test: whose FRFs.
        frequency_hz: of that line.
        at: point of the force.
        points: (points,) that move.
        axes: (points,) of motion at each.
        values: (points,) mobility, complex.
        sigma: (points,) one standard deviation of each, None where it is not known.
    """

    test: Test | None
    frequency_hz: float
    at: int
    points: tuple[int, ...]
    axes: tuple[str, ...]
    values: ComplexArray
    sigma: RealArray
