"""Points and axes of a model's outputs and inputs."""

import numpy as np

from modallab.core.arrays import Real
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


def senses_of(model: ModalModel, rig: Rig) -> Real:
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
