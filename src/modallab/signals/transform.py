"""Fourier transforms of real records, and the numbers of samples that they take quickly.

SciPy keeps what it has worked out for a length, so its transforms of long records take a fifth of NumPy's time. Of
short ones they save microseconds, and loading SciPy takes a quarter of the time in which a bench's process begins. So
it is loaded where a long record is to be transformed.
"""

from functools import lru_cache
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError

SHORT = 2**15
"""Samples of a record up to which NumPy's transform is as good."""
QUICK_FACTORS = (2, 3, 5)


def spectrum(record: NDArray[Any], n: int | None = None) -> NDArray[Any]:
    """(n // 2 + 1,) lines of a real record (m,), cut or filled with zeros to `n` samples; in the record's precision."""
    if (record.size if n is None else n) <= SHORT:
        return np.fft.rfft(record, n)
    from scipy import fft

    return np.asarray(fft.rfft(record, n))


@lru_cache(maxsize=64)
def next_quick_length(n: int) -> int:
    """The least number of at least `n` samples that has no prime factor above 5, as a quick transform needs.

    Raises:
        DataError: no samples.
    """
    return next(m for m in count(_check_length(n)) if _is_quick(m))


@lru_cache(maxsize=64)
def previous_quick_length(n: int) -> int:
    """The greatest number of at most `n` samples that has no prime factor above 5.

    Raises:
        DataError: no samples.
    """
    return next(m for m in range(_check_length(n), 0, -1) if _is_quick(m))


def _check_length(n: int) -> int:
    if n < 1:
        raise DataError(f"a transform of {n} samples is none", remedy="give at least one sample")
    return n


def _is_quick(n: int) -> bool:
    for factor in QUICK_FACTORS:
        while n % factor == 0:
            n //= factor
    return n == 1
