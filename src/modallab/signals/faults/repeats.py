"""Samples that repeat others: equal ones in a row, those of a slower converter, or a stretch that stands twice.

A slower converter's values are held, or joined by straight lines. Either puts images of the signal about each multiple
of the slower rate, which look like modes. A stretch stands twice where a buffer was written again in place of the next.
"""

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

    def at_least(self, least: int) -> "SampleRuns":
        """Those of at least so many samples."""
        kept = self.length >= least
        return SampleRuns(self.first[kept], self.stop[kept])

    def away_from_ends(self, n: int) -> "SampleRuns":
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


def smallest_steps(row: Real) -> Real:
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
class SampleFault:
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


MOVES = 32.0
"""Steps of the converter from which on a channel moves: by chance one of 80 samples then repeats another."""
LEAST = 8
MOST_BY_CHANCE = 10.0
"""How many times more often than by chance."""
LEAST_SHARE = 0.01
STRAIGHT = 4.0
"""Steps by which a sample may miss the middle between its neighbours and still lie on a line with them."""
MOST_STRAIGHT, LEAST_STRAIGHT = 0.4, 32
"""Share and number of samples on straight lines: a smooth signal that turns has 4 %, one of noise 20 % at most."""
BESIDE = 8
WINDOW, VALUES = 16, 8
"""Samples of a window, and different values in it from which on no chance repeats it."""
_COPY_MOVES = 16.0
"""Steps by which a record differs from itself so much later: what repeats as a whole does so by its own motion."""
_LOOKED_AT = 256
"""Pairs of windows: more show no other lag."""
_MOST_COPIED = 0.25
"""Share of a record from which on a repetition is the drive's own: records without noise repeat with it."""


def repeated_values(row: Real, rate_hz: float, channel: str, steps: Real) -> tuple[SampleFault, ...]:
    """Whether a channel (n,) holds its values, or joins them by straight lines; `steps` (n,) as of `steps_of`."""
    return _holds_values(row, rate_hz, channel, steps) or _joins_by_lines(row, rate_hz, channel, steps)


def _holds_values(row: Real, rate_hz: float, channel: str, steps: Real) -> tuple[SampleFault, ...]:
    runs, moves = equal_runs(row).away_from_ends(row.size), np.diff(row)
    before, after = moves[runs.first - 1], moves[runs.stop - 1]
    # On a slope: at a top two equal samples are nothing rare.
    on_slope = (np.minimum(np.abs(before), np.abs(after)) >= MOVES * steps[runs.first]) & (before * after > 0)
    moves = np.abs(moves) / np.maximum(steps[1:], 1e-300)
    moving = moves[moves >= MOVES]
    by_chance = 1 / float(np.median(moving)) if moving.size else 1.0
    for least in (3, 2):
        held = SampleRuns(runs.first[on_slope], runs.stop[on_slope]).at_least(least)
        count = held.first.size
        # Of a part of a record that is held, longer runs tell: by chance they are rarer by this power.
        if count < max(LEAST, moving.size * max(MOST_BY_CHANCE * by_chance ** (least - 1), LEAST_SHARE)):
            continue
        length = float(np.median(held.length))
        what = f"values held for {length:g} samples, as from a slower converter"
        first = int(held.first[(held.length >= length).argmax()])
        return (SampleFault(channel, what, first / rate_hz, int((held.length - 1).sum())),)
    return ()


def _joins_by_lines(row: Real, rate_hz: float, channel: str, steps: Real) -> tuple[SampleFault, ...]:
    if row.size < 4 * BESIDE:
        return ()
    step = np.maximum(steps[1:-1], np.maximum(steps[2:], steps[:-2]))
    bend, moves = np.abs(np.diff(row, 2)) / np.maximum(step, 1e-300), np.abs(np.diff(row))
    moving, straight = np.minimum(moves[1:], moves[:-1]) >= MOVES * step, bend <= STRAIGHT
    # Next to all rows are done with here; the rest asks what lies beside each sample.
    if (moving & straight).sum() < LEAST_STRAIGHT:
        return ()
    turns = moving & (_largest_beside(bend) >= 16 * STRAIGHT)
    if (turns & straight).sum() < max(LEAST_STRAIGHT, MOST_STRAIGHT * turns.sum()):
        return ()
    length = float(np.median(np.diff(np.flatnonzero(moving & ~straight))))
    what = f"straight lines over {length:g} samples, as between the values of a slower converter"
    first = int((turns & straight).argmax()) + 1
    return (SampleFault(channel, what, first / rate_hz, int((turns & straight).sum())),)


def _largest_beside(values: Real) -> Real:
    """(n,) the largest of each value and so many to either side."""
    padded = np.pad(values, BESIDE, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * BESIDE + 1).max(axis=1)


def repeated_in_all_channels(
    rows: Real, rate_hz: float, channels: tuple[str, ...], steps: Real
) -> tuple[SampleFault, ...]:
    """Whether all channels (channels, n) repeat samples of theirs, to the last digit; `steps` as of `steps_of`."""
    key = int(np.count_nonzero(np.diff(rows), axis=1).argmax())
    lag = _lag(rows[key])
    if not lag:
        return ()
    found: SampleRuns = stretches_where((rows[:, lag:] == rows[:, :-lag]).all(axis=0)).at_least(WINDOW)
    moving = [k for k in range(found.first.size) if np.unique(rows[key, found.first[k] : found.stop[k]]).size >= VALUES]
    if np.median(np.abs(rows[key, lag:] - rows[key, :-lag])) < _COPY_MOVES * float(np.median(steps[key])):
        return ()
    samples = int(found.length[moving].sum())
    if not 0 < samples < _MOST_COPIED * rows.shape[1]:
        return ()
    first = int(found.first[moving[0]]) + lag
    what = f"repeats exactly, with all other channels, the samples from {lag / rate_hz:.6g} s before"
    return (SampleFault(channels[key], what, first / rate_hz, samples),)


def _lag(row: Real) -> int:
    """Samples between a window that moves and the next that equals it; 0 if there is none."""
    mixed = _mixed(row)
    order = np.argsort(mixed, kind="stable")
    again = np.flatnonzero(mixed[order][1:] == mixed[order][:-1])
    lags = [
        int(order[k + 1] - order[k])
        for k in again[:: max(1, again.size // _LOOKED_AT)]
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
