"""Variables with names, of whichever file: as a map says, as the file itself does, or by the usual names."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.arrays.arrays_draft import draft_arrays
from modallab.formats.arrays.mapped import campaign_of_map
from modallab.formats.arrays.named import (
    FREQUENCY,
    STEP,
    TIME,
    Arrays,
    Texts,
    campaign_of_arrays,
    owner_of,
    unit_beside,
    usual_name,
)
from modallab.formats.arrays.names_in_file import names_in_file
from modallab.formats.csv.clock_times import is_clock, seconds_of
from modallab.formats.options import ImportOptions
from modallab.formats.unit_text import is_of_frequency, is_of_time, to_hertz, to_seconds

_STANDARD = ("scale_factor", "add_offset")
"""As the CF conventions of netCDF call them: numbers times the one, plus the other."""
_UNITS_OF = (
    (TIME, is_of_time, to_seconds),
    (STEP, is_of_time, to_seconds),
    (FREQUENCY, is_of_frequency, to_hertz),
)
_UNCLEAR = ("gain", "scale", "factor", "slope", "lsb", "multiplier")


def campaign_of_variables(arrays: Arrays, texts: Texts, path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record, or one matrix of FRFs, as a map says, the file itself, or the usual names.

    Raises:
        DataError: variables that are missing or do not fit.
    """
    found, options = options.array_map, _by_points(options)
    arrays = _abscissae(_scaled_arrays({**arrays, **_clocks(texts)}, str(path)), texts, options)
    if found is None and not options.variables:
        arrays, texts, found = names_in_file(arrays, texts, rig, str(path))
    if found is not None:
        return campaign_of_map(arrays, found, path.stem, rig, options, str(path))
    return campaign_of_arrays(arrays, path.stem, rig, options, str(path), texts)


def _by_points(options: ImportOptions) -> ImportOptions:
    """With names as they are called here, group.dataset, where the user writes them as HDF5 does, /group/dataset."""
    named = tuple((c, n.strip("/").replace("/", ".")) for c, n in options.variables)
    return replace(options, variables=named)


def _clocks(texts: Texts) -> Arrays:
    """The columns of clock times among texts, in s."""
    found = {key: rows for key, rows in texts.items() if len(rows) > 1 and all(map(is_clock, rows))}
    return {key: np.array(seconds_of(rows), np.float64) for key, rows in found.items()}


def _abscissae(arrays: Arrays, texts: Texts, options: ImportOptions) -> Arrays:
    """The arrays, those of times in s and of frequencies in Hz where the file gives them another unit."""
    found, said = dict(arrays), dict(options.variables)
    for key, values in arrays.items():
        unit = unit_beside(texts, key).partition(" since ")[0] or key.rpartition("_")[2]
        for what, is_of, factor in _UNITS_OF:
            if is_of(unit) and factor(unit) != 1 and (said.get(what) == key or usual_name({key: values}, what)):
                found[key] = values * factor(unit)
    return found


def rig_of_variables(arrays: Arrays, texts: Texts, path: Path, options: ImportOptions) -> Rig:
    """The rig that variables are of, as a map says, the file itself, or the usual names.

    Raises:
        DataError: what a variable is cannot be known.
    """
    found = options.array_map
    if found is None:
        arrays, texts, found = names_in_file(arrays, texts, None, str(path))
    return draft_arrays(arrays, texts, found, path, options.drive_point)


def _scaled_arrays(arrays: Mapping[str, NDArray[Any]], where: str) -> Mapping[str, NDArray[Any]]:
    """The arrays, with `scale_factor` and `add_offset` of whole numbers applied, and times in s from the first date.

    Raises:
        DataError: whole numbers have a scale beside them of which nothing says how it is meant.
    """
    dates = [values.min() for values in arrays.values() if values.dtype.kind == "M" and values.size]
    found = {key: _in_seconds(values, min(dates, default=None)) for key, values in arrays.items()}
    for key, values in arrays.items():
        if values.dtype.kind not in "iu" or values.size < 2:
            continue
        factor, offset = (_beside(arrays, key, name) for name in _STANDARD)
        if factor is not None or offset is not None:
            found[key] = values * (1.0 if factor is None else factor) + (offset or 0.0)
            continue
        unclear = {name: _beside(arrays, key, name) for name in _UNCLEAR}
        for name, value in unclear.items():
            if value not in (None, 1.0):
                raise DataError(
                    f"{key} holds whole numbers beside a {name} of {value:g}; whether that multiplies them is not said",
                    where=where,
                    remedy="save the numbers in their unit, or call the scale scale_factor (and add_offset)",
                )
    return found


def _in_seconds(values: NDArray[Any], first: Any) -> NDArray[Any]:
    if values.dtype.kind not in "mM":
        return values
    return (values - first if values.dtype.kind == "M" else values) / np.timedelta64(1, "s")


def _beside(arrays: Mapping[str, NDArray[Any]], key: str, name: str) -> float | None:
    """The one number of this name beside an array, or in the structure that holds it."""
    lowered = {k.lower(): value for k, value in arrays.items()}
    for owner in (key, owner_of(key)):
        value = lowered.get(f"{owner}.{name}".lower())
        if value is not None and value.size == 1:
            return float(np.ravel(value)[0])
    return None
