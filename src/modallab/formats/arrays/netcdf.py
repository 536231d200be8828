"""Time records of Rattlesnake: netCDF4, which is HDF5."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Channel, Rig
from modallab.formats.arrays.named import ALL, RATE, campaign_of_arrays
from modallab.formats.options import ImportOptions
from modallab.formats.unit_text import normal_unit, quantity_of

SAMPLES, SAMPLE_RATE = "time_data", "sample_rate"
_COLUMNS = ("node_number", "node_direction", "unit")


def is_rattlesnake(path: Path) -> bool:
    """Whether an HDF5 file holds what Rattlesnake streams."""
    try:
        with h5py.File(path, "r") as source:
            return isinstance(source.get(SAMPLES), h5py.Dataset) and SAMPLE_RATE in source.attrs
    except OSError:
        return False


def read_rattlesnake(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record. Channels are found by the file's table of nodes, directions and units; without one in rig order.

    Raises:
        FormatError: the file cannot be read to its end.
        DataError: not as many channels as the rig has, or one of it is no single row of the table.
    """
    table: dict[str, list[str]] = {}
    try:
        with h5py.File(path, "r") as source:
            # A new variable has as many columns as were streamed; h5py's types do not know that it is a dataset.
            samples: NDArray[Any] = np.asarray(source[SAMPLES])
            rate = np.asarray(source.attrs[SAMPLE_RATE], np.float64)
            if isinstance(group := source.get("channels"), h5py.Group):
                table = {key: [text.decode() for text in np.asarray(group[key])] for key in _COLUMNS if key in group}
    except (OSError, KeyError) as error:
        raise FormatError(
            f"is no whole netCDF4 file: {error}", where=str(path), remedy="copy the file again"
        ) from error
    if len(table) < len(_COLUMNS):
        return campaign_of_arrays({ALL: samples, RATE: rate}, path.stem, rig, options, str(path))
    places = [_row_of(channel, table, rig, str(path)) for channel in rig.channels]
    rows = {channel.name: samples[place] for channel, place in zip(rig.channels, places, strict=True)}
    campaign = campaign_of_arrays({**rows, RATE: rate}, path.stem, rig, options, str(path))
    units = tuple(normal_unit(table["unit"][place]) for place in places)
    return replace(campaign, blocks=tuple(replace(block, units=units) for block in campaign.blocks))


def _row_of(channel: Channel, table: Mapping[str, Sequence[str]], rig: Rig, where: str) -> int:
    """The place of a channel in the file: what it measures, at its point and along its direction."""
    found = [k for k, unit in enumerate(table["unit"]) if quantity_of(normal_unit(unit)) == channel.quantity]
    nodes, directions = table["node_number"], table["node_direction"]
    if channel.quantity != "force" and rig.points:
        sign, axis = channel.direction
        own = (axis, sign + axis, axis + sign)
        found = [k for k in found if nodes[k] == str(channel.point) and directions[k].strip().lower() in own]
    if len(found) != 1:
        rows = ", ".join(map(" ".join, zip(nodes, directions, table["unit"], strict=True)))
        raise DataError(
            f"channel {channel.name} (point {channel.point}, {channel.direction}, {channel.quantity}) is no single row "
            f"of the file's table: {rows}",
            where=where,
            remedy="give the rig's channel its point and direction, or leave it out with --ignore",
        )
    return found[0]
