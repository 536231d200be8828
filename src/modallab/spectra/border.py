"""What every public function of this stage refuses: a wrong number here would look right ever after."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.errors import DataError
from modallab.schema.block import Signals
from modallab.schema.check import check_signals
from modallab.schema.check_axis import check_rate


def check_rows(values: NDArray[Any], what: str = "record") -> None:
    """Refuse what is no set of time records (rows, n), or one record (n,).

    Raises:
        DataError: not real numbers, empty, NaN or infinite, or more rows than samples.
    """
    if values.dtype.kind not in "iuf" or values.ndim not in (1, 2):
        found = f"the {what} has shape {values.shape} and type {values.dtype}"
        raise DataError(found, remedy="give real numbers, one row per channel, one column per sample")
    if values.size == 0:
        raise DataError(f"the {what} is empty", remedy="record again, or leave it out")
    if values.ndim == 2 and values.shape[0] > values.shape[1]:
        found = f"the {what} has shape {values.shape}, more rows than samples: it looks transposed"
        raise DataError(found, remedy="transpose it: one row per channel, one column per sample")
    bad = ~np.isfinite(values)
    if bad.any():
        found = f"{int(bad.sum())} of {bad.size} samples of the {what} are NaN or infinite"
        raise DataError(found, remedy="look at the recording there; leave it out, or record it again")


def check_positive(value: float, what: str) -> None:
    """Refuse a number that is not finite and above 0.

    Raises:
        DataError: it is not.
    """
    if not (np.isfinite(value) and value > 0):
        raise DataError(f"{what} is {value}", remedy="give a finite number above 0")


def check_test(signals: Sequence[Signals]) -> None:
    """Refuse blocks that make no test: none at all, unequal ones, or blocks that no living bench records.

    Raises:
        DataError: as said, with the record's name.
    """
    if not signals:
        raise DataError("there is no block", remedy="give the blocks of one test")
    shapes = {(s.rate_hz, s.force.size, s.outputs) for s in signals}
    if len(shapes) > 1:
        listed = "; ".join(sorted(f"{n} samples of {len(o)} outputs at {rate:g} Hz" for rate, n, o in shapes))
        raise DataError(f"the blocks of one test differ: {listed}", remedy="identify them apart, each kind by itself")
    for s in signals:
        where = f"record {s.block.name}"
        check_rate(s.rate_hz, where)
        if s.force.ndim != 1 or s.responses.ndim != 2 or s.responses.shape[1] != s.force.size:
            found = f"force {s.force.shape} and responses {s.responses.shape} do not belong together"
            raise DataError(found, where=where, remedy="give force (n,) and responses (outputs, n)")
        check_signals(np.vstack([s.force, s.responses]), ("force", *s.outputs), where, force="force")
