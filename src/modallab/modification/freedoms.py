"""Points and axes of a model's outputs and inputs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Rig

Freedom = tuple[int, str]
"""A point and the axis of motion there: x, y or z; positive along the axis, or along the drive where it is its axis."""


def with_points(model: ModalModel, rig: Rig) -> ModalModel:
    """The model with the points of the rig's channels where it has none of its own: a file of FRFs may name none."""
    points = {channel.name: channel.point for channel in rig.channels}
    outputs = (points.get(n) if p is None else p for n, p in zip(model.outputs, model.output_points, strict=True))
    driven = None if rig.force is None else rig.force.point
    inputs = (driven if p is None and len(model.input_points) == 1 else p for p in model.input_points)
    return model.model_copy(update={"output_points": tuple(outputs), "input_points": tuple(inputs)})


def freedoms_of(model: ModalModel, rig: Rig) -> tuple[tuple[Freedom, ...], tuple[Freedom, ...]]:
    """Freedoms of outputs and inputs.

    Raises:
        DataError: an output or an input has no point, or an output is no channel of the rig.
    """
    if None in model.output_points or None in model.input_points:
        raise DataError(
            "an output or an input has no point", where=rig.name, remedy="give channels and records their points"
        )
    axes = [_channel_of_output(name, rig).direction[1] for name in model.outputs]
    drive = rig.drive_direction[1]
    outputs = tuple((int(p or 0), axis) for p, axis in zip(model.output_points, axes, strict=True))
    return outputs, tuple((int(p or 0), drive) for p in model.input_points)


def output_signs(model: ModalModel, rig: Rig) -> Real:
    """(outputs,) sign of a reading over the motion along its freedom.

    Raises:
        DataError: an output is no channel of the rig.
    """
    return np.array([rig.sense_of(_channel_of_output(name, rig)) for name in model.outputs])


def _channel_of_output(output: str, rig: Rig) -> Channel:
    # An output of several set-ups is named after its channel and its point.
    name = output.split("@")[0]
    for channel in rig.channels:
        if channel.name in (output, name):
            return channel
    raise DataError(
        f"output {output} is no channel of the rig, so that its axis is not known",
        where=rig.name,
        remedy="name a campaign with its own rig as the reference, or use the names of the rig",
    )


@dataclass(frozen=True, eq=False, slots=True)
class ModalFactors:
    """Of all modes at all freedoms; where only one of the two was measured, the other is as large (reciprocity).

    Attributes:
        seen: (modes, freedoms) what sensors show.
        driven: (modes, freedoms) what forces do, without the common phase.
        turn: factor exp(j phase) that all driving-point constants have in common. At a driving point the constants of
            a structure lie about the real axis; what turns them together is the measuring chain.
        scaled: whether there is a driving point; without one each mode has a scale of its own.
    """

    seen: Complex
    driven: Complex
    turn: complex
    scaled: bool


def factor_constants(constants: Complex, rows: Sequence[int], columns: Sequence[int], n: int) -> ModalFactors:
    """The factors of constants (modes, outputs, inputs) whose outputs and inputs are the freedoms rows and columns."""
    left, size, right = np.linalg.svd(constants, full_matrices=False)
    root = np.sqrt(size[:, :1])
    u, v = left[:, :, 0] * root, right[:, 0] * root
    seen, driven = _mean_at(u, rows, n), _mean_at(v, columns, n)
    both = [f for f in range(n) if f in rows and f in columns]
    total = np.sum(seen[:, both] * driven[:, both])
    turn = complex(total / abs(total)) if abs(total) > 0 else 1.0 + 0.0j
    if both:
        scale = _driving_point_scale(seen[:, both], driven[:, both] / turn)
        seen, driven = seen * scale, driven / scale / turn
    else:
        driven = driven / turn
    only_seen = [f for f in range(n) if f not in columns]
    only_driven = [f for f in range(n) if f not in rows]
    driven[:, only_seen], seen[:, only_driven] = seen[:, only_seen], driven[:, only_driven]
    return ModalFactors(seen, driven, turn, bool(both))


def _driving_point_scale(seen: Complex, driven: Complex) -> Complex:
    """(modes, 1) factor that makes what is seen and driven at the driving points alike, in the mean of squares."""
    square = np.sum(np.conj(seen) * driven, axis=1)
    power = np.sum(np.abs(seen) ** 2, axis=1)
    return np.sqrt(np.where(power > 0, square / np.where(power > 0, power, 1.0), 1.0) + 0j)[:, None]


def _mean_at(values: Complex, places: Sequence[int], n: int) -> Complex:
    """(modes, n) values (modes, listed) at their places, their mean where several stand at one."""
    at = np.equal.outer(np.asarray(places), np.arange(n))
    return values @ (at / np.maximum(at.sum(axis=0), 1))
