"""What every public function of this stage rejects: a wrong number here would look right ever after."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import LARGEST
from modallab.core.axis_checks import check_rate
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig


def check_rows(values: NDArray[Any], what: str = "record") -> None:
    """Reject what is no set of time records (rows, n), or one record (n,).

    Raises:
        DataError: not real numbers, empty, NaN, infinite or beyond 1e30, or more rows than samples.
    """
    if values.dtype.kind not in "iuf" or values.ndim not in (1, 2):
        found = f"the {what} has shape {values.shape} and type {values.dtype}"
        raise DataError(found, remedy="give real numbers, one row per channel, one column per sample")
    if values.size == 0:
        raise DataError(f"the {what} is empty", remedy="record again, or leave it out")
    if values.ndim == 2 and values.shape[0] > values.shape[1]:
        found = f"the {what} has shape {values.shape}, more rows than samples: the array looks transposed"
        raise DataError(found, remedy="transpose the array: one row per channel, one column per sample")
    # The extremes first: they need no copy, and a NaN anywhere is both of them.
    if values.dtype.kind == "f" and not (values.min() >= -LARGEST and values.max() <= LARGEST):
        bad = ~(np.abs(values) <= LARGEST)
        kind = f"beyond {LARGEST:g}" if np.isfinite(values).all() else "NaN or infinite"
        found = f"{int(bad.sum())} of {bad.size} samples of the {what} are {kind}"
        raise DataError(found, remedy="look at the recording there; leave it out, or record it again")


def check_channels(values: NDArray[Any], count: int, what: str = "record") -> None:
    """Reject what is not (channels, n) of so many channels; else as `check_rows`.

    Raises:
        DataError: it is not.
    """
    check_rows(values, what)
    if values.ndim != 2 or len(values) != count:
        raise DataError(
            f"the {what} has shape {values.shape}, not ({count} channels, samples)",
            remedy="give one row for each channel of the rig, in its order",
        )


def check_block(block: Block, rig: Rig) -> None:
    """Reject a block of other channels than the rig's, whose parts do not fit, or whose counts have no size.

    Raises:
        DataError: as said, with the record's name.
    """
    where = f"record {block.name}"
    check_rate(block.rate_hz, where)
    check_rows(block.samples, where)
    names = tuple(c.name for c in rig.channels)
    if block.channels != names:
        raise DataError(
            f"channels {list(block.channels)} are not the rig's {list(names)}",
            where=where,
            remedy="use the rig file the record was made with",
        )
    reported = len(block.channels) if block.overload is None else len(block.overload)
    parts = block.samples.shape[:1], block.scale.shape, (len(block.units),), (len(block.channels),), (reported,)
    if block.samples.ndim != 2 or len(set(parts)) > 1:
        raise DataError(
            f"samples {block.samples.shape}, scales {block.scale.shape}, {len(block.units)} units, "
            f"{len(block.channels)} channels and {reported} overload flags do not belong together",
            where=where,
            remedy="give one of each for every channel, and samples (channels, n)",
        )
    odd = [n for n, s in zip(block.channels, block.scale, strict=True) if not (np.isfinite(s) and s != 0)]
    if odd:
        found = f"the scale of {', '.join(odd)} is 0 or no number"
        raise DataError(found, where=where, remedy="give the unit per count, such as V per count")


def check_positive(value: float, what: str) -> None:
    """Reject a number that is not finite and above 0.

    Raises:
        DataError: it is not.
    """
    if not (np.isfinite(value) and value > 0):
        raise DataError(f"{what} is {value}", remedy="give a finite number above 0")
