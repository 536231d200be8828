"""Arrays as numbers in their unit: whole numbers beside their scale, dates, and lengths of time."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.formats.arrays.named import owner_of

_STANDARD = ("scale_factor", "add_offset")
"""As the CF conventions of netCDF call them: numbers times the one, plus the other."""
_UNCLEAR = ("gain", "scale", "factor", "slope", "lsb", "multiplier")


def scaled_arrays(arrays: Mapping[str, NDArray[Any]], where: str) -> Mapping[str, NDArray[Any]]:
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
