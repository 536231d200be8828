"""Campaigns, FRFs and modal models as a universal file: datasets 151, 164, 15, 82, 58b and 55."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from modallab import __version__
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Rig
from modallab.core.units import Quantity
from modallab.formats.atomic import replacing
from modallab.formats.block_facts import BlockFacts
from modallab.formats.uff.uff_lines import (
    WIDTH,
    axis_of,
    binary_58,
    function_head,
    header_151,
    nodes_15,
    physical,
    shape_55,
    traces_82,
    units_164,
)
from modallab.signals.conversion import sign_of

_SPECIFIC: dict[Quantity, int] = {"displacement": 8, "velocity": 11, "acceleration": 12, "force": 13}
_ORDINATE: dict[FrfQuantity, tuple[int, str, str]] = {
    "receptance": (8, "Displacement", "m"),
    "mobility": (11, "Velocity", "m/s"),
    "inertance": (12, "Acceleration", "m/s^2"),
}
_NONE = (0, "NONE", "NONE")


def write_uff(campaign: Campaign, path: Path, models: Sequence[ModalModel] = ()) -> None:
    """Write everything of a campaign, and the shapes of models identified from it.

    Samples become doubles in the unit of their block, FRFs doubles in SI. Text fields hold six digits, so that the rate
    goes along in a remark too, with the record's name, test and level.

    Raises:
        DataError: a name is too long for the format.
        StorageError, DiskFullError: the file cannot be written.
    """
    with replacing(path) as draft, draft.open("wb") as out:
        for part in _parts(campaign, models):
            out.write(part)


def _parts(campaign: Campaign, models: Sequence[ModalModel]) -> Iterator[bytes]:
    rig = campaign.rig
    yield header_151(rig.name, f"modallab {__version__}", f"{datetime.now(UTC):%d-%b-%y  %H:%M:%S}")
    yield units_164()
    if rig.points:
        yield nodes_15([(point.id, point.x_m, point.y_m, point.z_m) for point in rig.points])
    if rig.lines:
        yield traces_82(rig.lines)
    for block in campaign.blocks:
        yield from _records(block, rig)
    for frf in campaign.frfs:
        yield from _frf(frf, rig)
    for model in models:
        yield from _shapes(model, rig)


def _records(block: Block, rig: Rig) -> Iterator[bytes]:
    remark = BlockFacts.of(block).text()
    lines = [remark[:WIDTH], remark[WIDTH:]]
    if len(lines[1]) > WIDTH:
        raise DataError(
            f"name and level of record {block.name} are too long for a universal file", remedy="use shorter names"
        )
    for channel, unit, values in zip(rig.channels, block.units, physical(block), strict=True):
        ids = [channel.name, f"record {block.name}", "NONE", *lines]
        form = (4, len(values), 0.0, 1 / block.rate_hz)
        specific = _SPECIFIC.get(channel.quantity, 0) if not unit.endswith("V") else 0
        labels = [(17, "Time", "s"), (specific, channel.quantity, unit), _NONE, _NONE]
        place = _place(channel, block.drive_point, rig)
        head = function_head(ids, 1, place, _reference(block.drive_point, rig), form, labels)
        yield binary_58(head, None, values)


def _place(channel: Channel, drive_point: int | None, rig: Rig) -> tuple[str, int, int]:
    others = {shaker.force: shaker.point for shaker in rig.shakers}
    if channel.quantity == "force":
        drive_point = others.get(channel.name, drive_point)
        return channel.name, drive_point or 0, axis_of(rig.drive_direction) if drive_point else 0
    return channel.name, channel.point or 0, axis_of(channel.direction)


def _reference(drive_point: int | None, rig: Rig) -> tuple[str, int, int]:
    if rig.force is None or not drive_point:
        return "NONE", 0, 0
    return rig.force.name, drive_point, axis_of(rig.drive_direction)


def _frf(frf: Frf, rig: Rig) -> Iterator[bytes]:
    channels = {channel.name: channel for channel in rig.channels}
    if frf.damping_shift:
        raise DataError("an FRF with exponential weighting has no place in a universal file", remedy="leave it out")
    for i, output in enumerate(frf.outputs):
        channel = channels[output]
        for j, point in enumerate(frf.input_points):
            place = _place(channel, None, rig)
            force = "NONE" if rig.force is None else rig.force.name
            reference = (force, point or 0, axis_of(rig.drive_direction))
            ids = [output, f"FRF to point {point}", "NONE", "NONE", "NONE"]
            labels = [(18, "Frequency", "Hz"), _ORDINATE[frf.quantity], (13, "Force", "N"), _NONE]
            lines = len(frf.frequency_hz)
            yield binary_58(
                function_head(ids, 4, place, reference, (6, lines), labels),
                frf.frequency_hz,
                sign_of(rig, channel) * frf.values[i, j],
            )
            if frf.coherence is not None:
                labels = [(18, "Frequency", "Hz"), (0, "Coherence", "NONE"), _NONE, _NONE]
                yield binary_58(
                    function_head(ids, 6, place, reference, (4, lines), labels), frf.frequency_hz, frf.coherence[i, j]
                )


def _shapes(model: ModalModel, rig: Rig) -> Iterator[bytes]:
    shapes = model.operating_shapes if model.shapes is None else model.shapes
    if shapes is None:
        raise DataError(
            f"the model of the {model.test or 'FRF'} has no shapes: {model.shapes_unavailable}", remedy="leave it out"
        )
    channels = {channel.name: channel for channel in rig.channels}
    for r in range(model.n_modes):
        omega, zeta = 2 * np.pi * model.frequency_hz[r], model.damping_ratio[r]
        if not (np.isfinite(zeta) and 0 <= zeta < 1):
            raise DataError(f"mode {r + 1} has the damping ratio {zeta:g}", remedy="leave this model out")
        pole = complex(-zeta * omega, omega * np.sqrt(1 - zeta**2))
        scale = "unit modal mass" if model.shapes is not None else "no scale: no force was measured"
        ids = [f"{rig.name}, {model.test or 'frf'}, {model.method}", f"mode {r + 1}", scale, "NONE", "NONE"]
        shape: dict[int, np.ndarray] = {}
        for name, point, value in zip(model.outputs, model.output_points, shapes[r], strict=True):
            if point is not None:
                direction = axis_of(channels[name].direction)
                at = shape.setdefault(point, np.zeros(3, dtype=np.complex128))
                at[abs(direction) - 1] = value * np.sign(direction) * sign_of(rig, channels[name])
        # A modal mass of 0 is none, as a shape without a scale has.
        yield shape_55(ids, r + 1, pole, float(model.shapes is not None), shape)
