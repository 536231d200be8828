"""How finely a column of numbers is written."""

from collections.abc import Sequence
from decimal import Decimal, InvalidOperation

import numpy as np
from numpy.typing import NDArray

_LOOKED_AT = 2000
"""Cells, evenly spread, that show how many digits a column has."""


def half_last_digits(texts: Sequence[str], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(rows,) half of the last digit with which each number of a column was written; 0 where that is not known.

    Either all have the same number of decimals, of which zeros at the end may be left out; or the same number of
    significant digits, so that decimals become fewer as numbers grow. The largest numbers show which.

    Args:
        texts: (rows,) the cells, with decimal points.
        values: (rows,) their numbers.
    """
    step = max(1, len(texts) // _LOOKED_AT)
    shown = [*texts[::step], *texts[-20:]]
    try:
        tuples = [Decimal(text).as_tuple() for text in shown]
        ends = np.array([int(t.exponent) for t in tuples])
    except (InvalidOperation, ValueError):
        return np.zeros(len(values))
    digits = np.array([len(t.digits) if any(t.digits) else 0 for t in tuples])
    heads = ends + digits - 1
    largest = heads[digits > 0].max(initial=-300)
    if abs(ends).max() > 300:
        return np.zeros(len(values))
    if ends[heads == largest].min(initial=0) <= ends.min():
        return np.full(len(values), 0.5 * 10.0 ** float(ends.min()))
    size = np.abs(values)
    head = np.floor(np.log10(np.where(size > 0, size, size[size > 0].min(initial=1.0))))
    return np.asarray(0.5 * 10.0 ** (head + 1 - float(digits.max())), np.float64)
