"""A rig from the arrays of a file: as a map says, or where their names and sizes leave no choice."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.core.units import Quantity
from modallab.formats.arrays.array_map import REMEDY, ArrayMap, array_named, listed
from modallab.formats.arrays.channel_times import channel_times
from modallab.formats.arrays.named import (
    FREQUENCY,
    FRF,
    RATE,
    STEP,
    TIME,
    Arrays,
    Texts,
    find_usual,
    owner_of,
    unit_beside,
)
from modallab.formats.draft import FORCE_NAMES, MEASURED, DraftChannel, rig_of
from modallab.formats.unit_text import frf_unit, normal_unit, quantity_of


def draft_arrays(
    arrays: Arrays, texts: Texts, array_map: ArrayMap | None, path: Path, drive_point: int | None = None
) -> Rig:
    """The rig that the arrays of a file were made on.

    Args:
        arrays: by name.
        texts: of the file, which may hold the units of channels.
        array_map: what they are; None if nobody says it.
        path: of the file.
        drive_point: of the only input; None if nobody says it.

    Raises:
        DataError: what an array is cannot be known; the message lists all of them.
    """
    if array_map is not None:
        return _of_map(arrays, array_map, path)
    found = {key: find_usual(arrays, key) for key in (FREQUENCY, FRF, TIME, RATE, STEP)}
    frf, frequency = found[FRF], found[FREQUENCY]
    if frf is not None and frequency is not None:
        names = [f"y{k}" for k in range(1, _outputs(frf, frequency, arrays, path, drive_point) + 1)]
        return rig_of([DraftChannel("force", "force", "N"), *(DraftChannel(name) for name in names)], path)
    own = {key: owner_of(key) for key, a in arrays.items() if owner_of(key) != key and a.size > 1}
    if own and all(channel_times(arrays, key, arrays[key].size, str(path)).rate_hz for key in own):
        units = {key: unit_beside(texts, key) for key in own}
        return rig_of(
            [DraftChannel(n.rpartition(".")[2], quantity_of(units[k]), units[k]) for k, n in own.items()], path
        )
    if all(found[key] is None for key in (TIME, RATE, STEP)):
        raise _unclear("says neither frequency and FRF nor time or rate", arrays, path)
    return rig_of(_channels(arrays, texts, found, path), path)


def _of_map(arrays: Arrays, array_map: ArrayMap, path: Path) -> Rig:
    of_frf = frf_unit(normal_unit(array_map.unit), "") if array_map.unit else None
    unit = normal_unit(array_map.response_unit)
    quantity: Quantity | None = MEASURED[of_frf[0]] if of_frf else quantity_of(unit)
    if isinstance(array_map.responses, dict):
        rows = [DraftChannel(name, quantity, unit) for name in array_map.responses]
    else:
        outputs = array_map.outputs or tuple(f"y{k}" for k in range(1, _mapped_outputs(arrays, array_map, path) + 1))
        rows = [DraftChannel(o if isinstance(o, str) else f"p{o}", quantity, unit, o if isinstance(o, int) else None)
                for o in outputs]  # fmt: skip
    if array_map.frf or array_map.force:
        at = array_map.inputs[0] if len(array_map.inputs) == 1 else None
        rows.insert(0, DraftChannel("force", "force", normal_unit(array_map.force_unit) or "N", at))
    return rig_of(rows, path, driven=array_map.inputs)


def _mapped_outputs(arrays: Arrays, array_map: ArrayMap, path: Path) -> int:
    values = array_named(arrays, array_map.frf or str(array_map.responses), str(path))
    if "outputs" not in array_map.axes:
        if array_map.axes or values.ndim == 1:
            return 1
        raise DataError(
            f"how many responses an array {values.shape} holds is not certain",
            where=str(path),
            remedy="write axes into the map, or outputs",
        )
    # MATLAB drops axes of one element.
    return values.shape[array_map.axes.index("outputs")] if values.ndim == len(array_map.axes) else 1


def _outputs(frf: NDArray[Any], frequency: NDArray[Any], arrays: Arrays, path: Path, drive_point: int | None) -> int:
    rest = [n for n in np.squeeze(frf).shape if n != frequency.size]
    if frequency.size not in frf.shape or len(rest) > 1 or frf.shape.count(frequency.size) > 1:
        raise _unclear("holds FRFs whose axes are not known", arrays, path)
    if rest and drive_point is None and [n for n in frf.shape if n != frequency.size] == [1, *rest]:
        raise DataError(
            f"FRFs of shape {frf.shape} are {rest[0]} outputs of one input, or one output of {rest[0]} inputs",
            where=str(path),
            remedy="give the point of the one input by --drive-point, or say --map with axes: [outputs, inputs, lines]",
        )
    return rest[0] if rest else 1


def _channels(arrays: Arrays, texts: Texts, found: dict[str, NDArray[Any] | None], path: Path) -> list[DraftChannel]:
    """A channel for every array as long as the record, and for every column of one that is."""
    of_time = {id(found[key]) for key in (TIME, RATE, STEP)}
    held = {name: a for name, a in arrays.items() if id(a) not in of_time and a.size > 1 and a.dtype.kind in "fiu"}
    time = found[TIME]
    n = time.size if time is not None and time.size > 1 else max((max(a.shape) for a in held.values()), default=0)
    if not held or any(n not in a.shape or a.ndim > 2 or min(a.shape) == n < max(a.shape) for a in held.values()):
        raise _unclear("holds arrays that differ in length or have more than two axes", arrays, path)
    forces = [name for name, a in held.items() if a.ndim == 1 and name.rpartition(".")[2].lower() in FORCE_NAMES]
    if any(a.ndim == 2 for a in held.values()) and len(forces) != 1:
        raise _unclear("does not say which column is the force", arrays, path)
    units = {name: unit_beside(texts, name) for name in held}
    return [
        DraftChannel(
            name if a.ndim == 1 else f"{name}:{k}",
            "force" if name in forces else quantity_of(units[name]),
            units[name],
        )
        for name, a in held.items()
        for k in range(1, (1 if a.ndim == 1 else min(a.shape)) + 1)
    ]


def _unclear(what: str, arrays: Arrays, path: Path) -> DataError:
    return DataError(f"{what}; there are {listed(arrays)}", where=str(path), remedy=REMEDY)
