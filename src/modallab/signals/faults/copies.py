"""Stretches of a record that stand twice: a buffer that was written again in place of the next."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.signals.faults.runs import Fault, SampleRuns, stretches_where

WINDOW, VALUES = 16, 8
"""Samples of a window, and different values in it from which on no chance repeats it."""
MOVES = 16.0
"""Steps by which a record differs from itself so much later: what repeats as a whole does so by its own motion."""
LOOKED_AT = 256
"""Pairs of windows: more show no other lag."""
MOST = 0.25
"""Share of a record from which on a repetition is the drive's own: records without noise repeat with it."""


def copies(rows: Real, rate_hz: float, channels: tuple[str, ...], steps: Real) -> tuple[Fault, ...]:
    """Whether all channels (channels, n) repeat samples of theirs, to the last digit; `steps` as of `steps_of`."""
    key = int(np.count_nonzero(np.diff(rows), axis=1).argmax())
    lag = _lag(rows[key])
    if not lag:
        return ()
    found: SampleRuns = stretches_where((rows[:, lag:] == rows[:, :-lag]).all(axis=0)).longer(WINDOW)
    moving = [k for k in range(found.first.size) if np.unique(rows[key, found.first[k] : found.stop[k]]).size >= VALUES]
    if np.median(np.abs(rows[key, lag:] - rows[key, :-lag])) < MOVES * float(np.median(steps[key])):
        return ()
    samples = int(found.length[moving].sum())
    if not 0 < samples < MOST * rows.shape[1]:
        return ()
    first = int(found.first[moving[0]]) + lag
    what = f"repeats to the last digit, with all others, what stood {lag / rate_hz:.6g} s before"
    return (Fault(channels[key], what, first / rate_hz, samples),)


def _lag(row: Real) -> int:
    """Samples between a window that moves and the next that equals it; 0 if there is none."""
    mixed = _mixed(row)
    order = np.argsort(mixed, kind="stable")
    again = np.flatnonzero(mixed[order][1:] == mixed[order][:-1])
    lags = [
        int(order[k + 1] - order[k])
        for k in again[:: max(1, again.size // LOOKED_AT)]
        if np.unique(row[order[k] : order[k] + WINDOW]).size >= VALUES
    ]
    return max(set(lags), key=lags.count) if lags else 0


def _mixed(row: Real) -> NDArray[np.uint64]:
    """(n - window + 1,) a number for each window, alike where all of its samples are."""
    bits, odd = np.ascontiguousarray(row).view(np.uint64), np.uint64(0x9E3779B97F4A7C15)
    mixed = np.zeros(row.size - WINDOW + 1, np.uint64)
    for k in range(WINDOW):
        part = bits[k : k + mixed.size]
        mixed = mixed * odd + (part ^ (part >> np.uint64(29)))
    return mixed
