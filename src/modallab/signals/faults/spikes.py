"""Single samples that no motion explains: a damaged digit or exponent, a bad contact, a mark for a missing value."""

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.repeats import Fault

ALONE = 50.0
"""How many times further than anything near it a sample stands off the middle of its neighbours."""
TOGETHER = 10.0
"""The same, from which on another channel moves as well: what is felt elsewhere is no fault."""
NEAR, OWN = 16, 1
"""Samples to either side that show how the channel moves, and those that one wrong sample bends itself."""
FELT = 2
"""Samples before, and twice as many behind, within which another channel feels what is no fault."""


def find_spikes(rows: Real, rate_hz: float, channels: tuple[str, ...], steps: Real) -> tuple[Fault, ...]:
    """Samples of (channels, n) rows that stand alone in time, and in which no other channel moves.

    Of a single channel nothing is known of others, and nothing is said. `steps` is (channels, n), as of `steps_of`.
    """
    if len(rows) < 2 or rows.shape[1] < 4 * NEAR:
        return ()
    off = np.zeros_like(rows)
    off[:, 1:-1] = np.abs(rows[:, 1:-1] - (rows[:, :-2] + rows[:, 2:]) / 2)
    least = np.maximum(steps, 1e-12 * np.abs(rows).max(axis=1, keepdims=True))
    found: list[Fault] = []
    for k, channel in enumerate(channels):
        alone = [i for i in _candidate_samples(off[k], least[k]) if _deviation_ratio(off[k], least[k], i) > ALONE]
        places = [i for i in alone if not _felt_elsewhere(np.delete(off, k, 0), np.delete(least, k, 0), i)]
        if places:
            what = f"a value of {rows[k, places[0]]:.6g} that neighbouring samples do not explain"
            found.append(Fault(channel, what, places[0] / rate_hz, len(places)))
    return tuple(found)


def _candidate_samples(off: Real, least: Real) -> list[int]:
    """Samples that stand further off than their neighbours, and than those a little before and after."""
    beside = np.maximum(np.roll(off, OWN + 1), np.roll(off, -OWN - 1))
    highest = off >= np.maximum(np.roll(off, 1), np.roll(off, -1))
    return [int(i) for i in np.flatnonzero(highest & (off > ALONE * np.maximum(beside, least)))]


def _deviation_ratio(off: Real, least: Real, place: int) -> float:
    """How far a sample stands off the middle of its neighbours, over the furthest near it but not beside it."""
    around = np.concatenate([off[max(0, place - NEAR) : max(0, place - OWN)], off[place + OWN + 1 : place + NEAR + 1]])
    return float(off[place] / max(float(around.max(initial=0.0)), float(least[place]), 1e-300))


def _felt_elsewhere(off: Real, least: Real, place: int) -> bool:
    span = range(max(0, place - FELT), min(off.shape[1], place + 2 * FELT + 1))
    return any(_deviation_ratio(row, low, i) > TOGETHER for row, low in zip(off, least, strict=True) for i in span)
