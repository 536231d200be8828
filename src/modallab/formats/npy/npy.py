"""NPY files: fields with the channels' names, or rows in rig order after a row of times unless a rate is given."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.arrays.array_map import without_singleton_axes
from modallab.formats.arrays.variables import campaign_of_variables
from modallab.formats.block_facts import facts_or_options
from modallab.formats.options import ImportOptions

_LAYOUT = "give an array of floating-point numbers: one row of times in s, then one row per channel in rig order"


def read_npy(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """Read one block; of an archive of several arrays (.npz) by their names.

    Named fields are channels and `time`, in any order. Else the array is (1 + channels, n) with times in s in its first
    row, or (channels, n) if the options give a rate.
    Numbers are in each channel's own unit, or volts if the options say so.

    Raises:
        FormatError: not an NPY file, or cut off.
        DataError: another layout or type, uneven times, not the channels of the rig.
    """
    where = str(path)
    if path.suffix.lower() == ".npz":
        held = _load_several(path)
        texts = {name: tuple(map(str, one.ravel())) for name, one in held.items() if one.dtype.kind == "U"}
        return campaign_of_variables({n: one for n, one in held.items() if n not in texts}, texts, path, rig, options)
    array = _load(path)
    if array.dtype.names:
        fields = {name: array[name] for name in array.dtype.names}
        return campaign_of_variables(fields, {}, path, rig, options)
    _check_layout(array, rig, options, where)
    rate, samples = _split(array, rig, options, where)
    units = [""] * len(rig.channels)
    block = facts_or_options(None, path.stem, rate, options).block(samples, units, rig)
    return Campaign(rig, (block,), source=where)


def _load_several(path: Path) -> dict[str, NDArray[Any]]:
    try:
        with path.open("rb") as source, np.load(source, allow_pickle=False) as held:
            return {name: without_singleton_axes(held[name]) for name in held.files}
    except Exception as error:  # On damaged files NumPy raises nearly every type there is.
        raise FormatError(
            f"is no whole archive of NPY files: {error}",
            where=str(path),
            remedy="copy the file again, or save it again with numpy.savez, numbers only",
        ) from error


def _load(path: Path) -> NDArray[Any]:
    try:
        with warnings.catch_warnings():
            # NumPy's remarks on old or odd headers say nothing to the user.
            warnings.simplefilter("ignore")
            mapped = np.load(path, mmap_mode="r", allow_pickle=False)
            expected = int(mapped.offset) + int(mapped.nbytes)
            array = np.array(mapped)
            del mapped
    except Exception as error:  # On damaged headers NumPy raises nearly every type there is.
        raise FormatError(
            f"is no whole NPY file: {str(error).splitlines()[0] if str(error) else type(error).__name__}",
            where=str(path),
            remedy="copy the file again, or save it again with numpy.save",
        ) from error
    if path.stat().st_size != expected:
        raise FormatError(
            f"has {path.stat().st_size} bytes where its header says {expected}",
            where=str(path),
            remedy="copy the file again",
        )
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def _check_layout(array: NDArray[Any], rig: Rig, options: ImportOptions, where: str) -> None:
    n = len(rig.channels)
    if array.dtype.kind in "iu":
        raise DataError(
            f"holds whole numbers ({array.dtype}), whose scale is not known",
            where=where,
            remedy="save them in volts or in the channels' units as floating-point numbers",
        )
    if array.dtype.kind != "f" or array.dtype.itemsize not in (4, 8):
        raise DataError(f"holds values of type {array.dtype}", where=where, remedy=_LAYOUT)
    if array.ndim != 2 or array.size == 0:
        raise DataError(f"holds an array of shape {array.shape}", where=where, remedy=_LAYOUT)
    if array.shape[0] > array.shape[1]:
        raise DataError(
            f"holds an array of shape {array.shape}: more rows than columns, it looks transposed",
            where=where,
            remedy="save its transpose: one row per channel, one column per sample",
        )
    if array.shape[0] == n and options.rate_hz is None:
        raise DataError(
            f"has {n} rows, as many as the rig has channels: no times, and no rate is given",
            where=where,
            remedy="give the rate with --rate, or put a row of times in s first",
        )
    if array.shape[0] not in (n, n + 1):
        raise DataError(
            f"has {array.shape[0]} rows; the rig has {n} channels ({', '.join(c.name for c in rig.channels)}), "
            f"so {n + 1} rows with times or {n} with --rate",
            where=where,
            remedy="make rig and recording name the same channels, in the same order",
        )


def _split(array: NDArray[Any], rig: Rig, options: ImportOptions, where: str) -> tuple[float, NDArray[Any]]:
    if len(array) == len(rig.channels):
        return check_rate(options.rate_hz or 0.0, where), array
    times = array[0]
    rate = check_time(times, f"{where}, row 0 (times)")
    return options.agreed(rate, where), np.ascontiguousarray(array[1:])
