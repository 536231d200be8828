"""Flat tops: a channel that is cut at one level, in whatever record reaches it.

A sine of amplitude A spends the share 2 / pi arccos(1 - d / A) of its time within d of its peaks, the arcsine law
behind the histogram test of IEEE Std 1057.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import gcd

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block

SHARE = 0.02
"""Smallest share of a record's samples that counts as a flat top."""
MORE, FEW = 3.0, 4
"""Times a sine's own share at its top, and how many of its phases besides may stand there by chance."""


REPEATS_IN = 4
"""A sine that repeats at least so many times in a block, sample by sample, has a few phases only."""


@dataclass(frozen=True, slots=True)
class ClippedChannel:
    """A channel that is cut.

    Attributes:
        row: its row.
        volts: the level.
        records: names of the records that reach it.
    """

    row: int
    volts: float
    records: tuple[str, ...]


def find_clipped(blocks: Sequence[Block], noise_v: Real, full_scale_v: Real, force: int) -> list[ClippedChannel]:
    """Channels but the force's with flat tops below their (rows,) full scale in V."""
    found: list[ClippedChannel] = []
    for row in (r for r in range(len(noise_v)) if r != force):
        peaks = np.array([np.max(np.abs(b.samples[row] * b.scale[row])) for b in blocks])
        level = float(np.max(peaks))
        if level > 0.999 * full_scale_v[row]:
            continue
        near = 6 * noise_v[row]
        flat = [i for i, b in enumerate(blocks) if peaks[i] > level - near and _is_flat(b, row, peaks[i], near)]
        if flat:
            level = float(np.median([_clipping_level(blocks[i], row, peaks[i], near) for i in flat]))
            reached = tuple(b.name for b, p in zip(blocks, peaks, strict=True) if p > level - near)
            found.append(ClippedChannel(row, level, reached))
    return found


def _clipping_level(block: Block, row: int, peak: float, near: float) -> float:
    volts = np.abs(block.samples[row] * block.scale[row])
    return float(np.median(volts[volts > peak - near]))


def _is_flat(block: Block, row: int, peak: float, near: float) -> bool:
    """Whether more samples, or longer runs of them, stay at the top than a sine of this frequency could."""
    volts = np.abs(block.samples[row] * block.scale[row])
    top = volts > peak - near
    share = float(np.mean(top))
    # What noise fills to half the peak and beyond has no top of its own.
    if block.test == "impact" or not block.frequency_hz or share < SHARE or near > peak / 2:
        return False
    own = 2 / np.pi * np.arccos(1 - min(near / peak, 1.0))
    if share > MORE * own + FEW / _phases_of_sine(block.frequency_hz / block.rate_hz, block.n_samples):
        return True
    arc = 2 * np.arccos(1 - min(near / peak, 1.0)) / (2 * np.pi * block.frequency_hz) * block.rate_hz
    edges = np.diff(np.concatenate([[0], top.astype(int), [0]]))
    runs = np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
    # A sine that repeats after few samples may have the same two of them beside its top in every period.
    repeats = _phases_of_sine(block.frequency_hz / block.rate_hz, block.n_samples) * REPEATS_IN < block.n_samples
    return float(np.mean(runs)) > 1.8 * arc + (2 if repeats else 1)


def _phases_of_sine(per_sample: float, n: int) -> int:
    """How many different phases the samples of a sine see: few, where it repeats after some samples."""
    periods = round(per_sample * n)
    return n // gcd(periods, n) if periods and abs(per_sample * n - periods) < 0.02 else n
