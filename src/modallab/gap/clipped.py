"""Flat tops: a channel that is cut at one level, in whatever record reaches it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.schema.block import Block

Array = NDArray[np.float64]

SHARE = 0.02
"""Smallest share of a record's samples that counts as a flat top."""


@dataclass(frozen=True, slots=True)
class Clipped:
    """A channel that is cut.

    Attributes:
        row: its row, 0 is the force.
        volts: the level.
        records: names of the records that reach it.
    """

    row: int
    volts: float
    records: tuple[str, ...]


def find_clipped(blocks: Sequence[Block], noise_v: Array, rail_v: float) -> list[Clipped]:
    """Channels with flat tops below the converter's own rail."""
    found: list[Clipped] = []
    for row in range(1, len(noise_v)):
        peaks = np.array([np.max(np.abs(b.samples[row])) * b.scale[row] for b in blocks])
        level = float(np.max(peaks))
        if level > 0.999 * rail_v:
            continue
        near = 6 * noise_v[row]
        flat = [i for i, b in enumerate(blocks) if peaks[i] > level - near and _is_flat(b, row, peaks[i], near)]
        if flat:
            level = float(np.median([_level(blocks[i], row, peaks[i], near) for i in flat]))
            reached = tuple(b.name for b, p in zip(blocks, peaks, strict=True) if p > level - near)
            found.append(Clipped(row, level, reached))
    return found


def _level(block: Block, row: int, peak: float, near: float) -> float:
    volts = np.abs(block.samples[row]) * block.scale[row]
    return float(np.median(volts[volts > peak - near]))


def _is_flat(block: Block, row: int, peak: float, near: float) -> bool:
    """Whether runs of samples stay at the top longer than a sine of this frequency could."""
    volts = np.abs(block.samples[row]) * block.scale[row]
    top = volts > peak - near
    share = float(np.mean(top))
    if block.test == "impact" or not block.frequency_hz or share < SHARE:
        return False
    arc = 2 * np.arccos(1 - min(near / peak, 1.0)) / (2 * np.pi * block.frequency_hz) * block.rate_hz
    edges = np.diff(np.concatenate([[0], top.astype(int), [0]]))
    runs = np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
    return float(np.mean(runs)) > 1.8 * arc + 1
