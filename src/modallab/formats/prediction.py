"""The file of predicted records: written by `modallab gap predict`, or by any simulation for the same forces."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from modallab.core.arrays import Real
from modallab.core.errors import DataError, FormatError, StorageError
from modallab.core.rig import Channel, Rig
from modallab.core.units import SI_UNIT, Quantity, si_factor
from modallab.core.versions import PREDICTION
from modallab.formats.atomic import replacing


def read_columns(path: Path) -> Real:
    """(columns, rows) of a file of numbers: .csv or .txt with commas, semicolons or spaces and # before remarks; .npy.

    Raises:
        StorageError: there is no such file, or it holds no table of numbers.
    """
    try:
        if path.suffix == ".npy":
            table = np.load(path, allow_pickle=False)
        else:
            text = path.read_text(encoding="utf-8").translate(str.maketrans(",;", "  "))
            table = np.loadtxt(text.splitlines(), ndmin=2)
        return np.atleast_2d(np.asarray(table, np.float64).T)
    except (OSError, ValueError) as error:
        raise StorageError(
            f"{path.name} holds no table of numbers: {error}",
            where=str(path),
            remedy="give a .csv or .npy file with a row for each sample and a column for each force",
        ) from error


def write_motion(path: Path, time: Real, values: Real, sigma: Real, names: Sequence[str], quantity: Quantity) -> Path:
    """Write motion (points, samples) and its deviation over time (samples,) as .csv or .mat; returns the path.

    Raises:
        StorageError: the name ends otherwise, or the file cannot be written.
    """
    if path.suffix not in (".csv", ".mat"):
        raise StorageError(f"{path.name} ends with neither .csv nor .mat", where=str(path), remedy="name it so")
    unit = SI_UNIT[quantity]
    with replacing(path) as draft:
        if path.suffix == ".mat":
            content = {"t": time, "y": values, "sigma": sigma, "points": list(names), "quantity": quantity}
            savemat(str(draft), content | {"unit": unit}, appendmat=False)
            return path
        heads = ["time [s]", *(f"{quantity} {n} [{unit}]" for n in names), *(f"sigma {n} [{unit}]" for n in names)]
        table = np.concatenate([time[None], values, sigma]).T
        np.savetxt(draft, table, fmt="%.9g", delimiter=",", header=",".join(heads), comments="")
    return path


Array = NDArray[np.float64]

PREDICT = "name a file of predicted records, as modallab gap predict writes it"


def write_prediction(path: Path, rig: Rig, records: Mapping[str, Array]) -> None:
    """Write predicted records: record -> (channels, n), each row in its channel's own unit and direction.

    Raises:
        StorageError: the file cannot be written.
    """
    responses = rig.responses
    with replacing(path) as draft, h5py.File(draft, "w") as target:
        target.attrs["format_version"] = PREDICTION
        target.attrs["channels"] = [c.name for c in responses]
        target.attrs["units"] = [c.unit for c in responses]
        target.attrs["directions"] = [c.direction for c in responses]
        for name, values in records.items():
            target.create_dataset(name, data=values)


def read_prediction(path: Path, rig: Rig) -> dict[str, Array]:
    """Read them as they were written, in the units and directions of this rig's channels.

    Raises:
        FormatError: it is no such file, or of an unknown version.
        DataError: it lacks a response channel of the rig, or holds it in a unit of another quantity.
    """
    try:
        with h5py.File(path) as source:
            if isinstance(source.get("records"), h5py.Group):
                raise FormatError("is a campaign, not predicted records", where=str(path), remedy=PREDICT)
            attributes: dict[str, Any] = dict(source.attrs)
            records: dict[str, Array] = {
                name: np.asarray(values, dtype=np.float64)
                for name, values in source.items()
                if isinstance(values, h5py.Dataset)
            }
    except (OSError, ValueError, TypeError) as error:
        no_hdf5 = path.is_file() and not h5py.is_hdf5(path)
        found = "is no HDF5 file" if no_hdf5 else f"cannot be read: {error}"
        raise FormatError(found, where=str(path), remedy=PREDICT) from error
    order, factors = _rows(attributes, rig, str(path))
    for name, values in records.items():
        if values.ndim != 2 or len(values) <= max(order):
            found = f"{name} holds an array of shape {values.shape}"
            raise DataError(found, where=str(path), remedy="give (channels, n), the channels as the attribute has them")
    return {name: values[order] * factors[:, None] for name, values in records.items()}


def _rows(attributes: Mapping[str, Any], rig: Rig, where: str) -> tuple[list[int], Array]:
    """Which row of the file belongs to each response channel, and its factor."""
    version = int(attributes.get("format_version", PREDICTION))
    if version not in (1, PREDICTION):
        raise FormatError(f"is of version {version}", where=where, remedy=f"write version {PREDICTION}")
    names = [str(name) for name in attributes.get("channels", [c.name for c in rig.responses])]
    missing = [c.name for c in rig.responses if c.name not in names]
    if missing:
        raise DataError(f"lacks {', '.join(missing)}", where=where, remedy="predict every response channel of the rig")
    order = [names.index(c.name) for c in rig.responses]
    # Version 1, and a file that says nothing, are in SI units along the drive.
    units = list(map(str, attributes["units"])) if "units" in attributes else None
    directions = (
        list(map(str, attributes["directions"])) if "directions" in attributes else [rig.drive_direction] * len(names)
    )
    factors = [
        _factor(c, None if units is None else units[row], directions[row], where)
        for c, row in zip(rig.responses, order, strict=True)
    ]
    return order, np.array(factors)


def _factor(channel: Channel, unit: str | None, direction: str, where: str) -> float:
    si = 1.0 if unit is None else si_factor(channel.quantity, unit, f"{where}, {channel.name}")
    turned = 1.0 if direction == channel.direction else -1.0
    return turned * si / si_factor(channel.quantity, channel.unit)
