"""Stretches of equal samples in a row, and the step between values that the row can take at all."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real

MOST_DIGITS = 8
"""Numbers of more digits have steps too small to matter."""
ROUNDING = 1e-13
"""Relative error of a decimal number in double precision, and of the powers of ten here."""


@dataclass(frozen=True, eq=False, slots=True)
class SampleRuns:
    """Stretches of consecutive samples for which something holds: first samples and those after the last, (runs,)."""

    first: NDArray[np.int64]
    stop: NDArray[np.int64]

    @property
    def length(self) -> NDArray[np.int64]:
        """(runs,) samples of each."""
        return self.stop - self.first

    def longer(self, least: int) -> "SampleRuns":
        """Those of at least so many samples."""
        kept = self.length >= least
        return SampleRuns(self.first[kept], self.stop[kept])

    def within(self, n: int) -> "SampleRuns":
        """Those that touch neither end of a record of n samples."""
        kept = (self.first > 0) & (self.stop < n)
        return SampleRuns(self.first[kept], self.stop[kept])


def stretches_where(holds: NDArray[np.bool_]) -> SampleRuns:
    """The stretches in which (n,) holds."""
    edges = np.flatnonzero(np.diff(holds.astype(np.int8), prepend=0, append=0))
    return SampleRuns(edges[::2], edges[1::2])


def equal_runs(row: Real) -> SampleRuns:
    """The stretches of at least two equal samples."""
    pairs = stretches_where(row[1:] == row[:-1])
    return SampleRuns(pairs.first, pairs.stop + 1)


def steps_of(row: Real) -> Real:
    """(n,) the smallest change that each sample of a row can make: the converter's step, or its own last digit.

    Numbers of a text have a step of their size: with four digits 12.34 changes by 0.01, and 123.4 by 0.1.
    """
    values = np.unique(row)
    least = float(np.min(np.diff(values))) if values.size > 1 else 0.0
    sizes = np.abs(values[values != 0])
    for digits in range(2, MOST_DIGITS + 1):
        # A few values refute most numbers of digits.
        if _have_digits(sizes[:: max(1, sizes.size // 32)], digits) and _have_digits(sizes, digits):
            floor = np.floor(np.log10(np.maximum(np.abs(row), sizes.min(initial=np.inf))))
            return np.maximum(least, 10.0 ** (floor - digits + 1))
    return np.full(row.size, least)


def _have_digits(sizes: Real, digits: int) -> bool:
    """Whether all of some values above 0 are decimal numbers of so many digits."""
    if not sizes.size:
        return False
    scaled = sizes / 10.0 ** (np.floor(np.log10(sizes)) - digits + 1)
    return bool(np.all(np.abs(scaled - np.round(scaled)) <= ROUNDING * scaled))


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that samples show.

    Attributes:
        channel: its name.
        what: the fault, with its size, as "flat tops at 0.6".
        first_s: when it begins, in s from the first sample.
        samples: how many it spoils.
    """

    channel: str
    what: str
    first_s: float
    samples: int

    @property
    def in_words(self) -> str:
        """What, how long and when."""
        return f"{self.what}, {self.samples} samples from {self.first_s:.6g} s on"

    def __str__(self) -> str:
        return f"channel {self.channel}: {self.in_words}"
