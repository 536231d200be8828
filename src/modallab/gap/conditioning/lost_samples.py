"""Rows that lose samples: they hold a value where the signal moves on, or read nothing between two samples that do."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block

REPEATS = 0.025
"""Share of samples equal to the one before that no lively signal has."""
ZEROS = 0.01
"""Share of samples at exactly 0 beside one far from it that no signal has that passes through 0."""
LIVELY = 8.0
"""Times the noise that a signal moves from sample to sample where it is lively."""
COUNTS = 12.0
"""Counts of the converter that are far, however little noise there is: a slow signal repeats its counts."""
RECORDS = 3
"""Lively records that must show it."""


def channels_losing_samples(blocks: Sequence[Block], noise_v: Real, force: int) -> tuple[int, ...]:
    """Rows that lose samples, as most of their lively records show.

    Args:
        blocks: the records.
        noise_v: (rows,) V rms.
        force: row of the force, which is 0 most of the time.
    """
    found = [_shares_repeated_and_zero(b, noise_v) for b in blocks]
    repeats, zeros = (np.ma.masked_invalid(np.array(shares)) for shares in zip(*found, strict=True))
    lost = (_typical_share(repeats) > REPEATS) | (_typical_share(zeros) > ZEROS)
    return tuple(int(i) for i in np.flatnonzero(lost & (repeats.count(axis=0) >= RECORDS)) if i != force)


def _shares_repeated_and_zero(block: Block, noise_v: Real) -> tuple[Real, Real]:
    """(rows,) shares of one record's samples that repeat, and that are 0 beside others; NaN where little moves."""
    volts = block.samples * block.scale[:, None]
    far = np.maximum(LIVELY * noise_v, COUNTS * np.abs(block.scale))
    lively = np.median(np.abs(np.diff(volts, axis=1)), axis=1) > far
    repeats = np.mean(np.diff(block.samples, axis=1) == 0, axis=1)
    beside = np.minimum(np.abs(volts[:, :-2]), np.abs(volts[:, 2:])) > far[:, None]
    zeros = np.mean(beside & (block.samples[:, 1:-1] == 0), axis=1)
    return np.where(lively, repeats, np.nan), np.where(lively, zeros, np.nan)


def _typical_share(shares: "np.ma.MaskedArray[tuple[int, ...], np.dtype[np.float64]]") -> Real:
    return np.ma.median(shares, axis=0).filled(0.0)
