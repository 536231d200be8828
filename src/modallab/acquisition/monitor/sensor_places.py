"""Whether two channels have changed places: by the few shapes in which the structure moves, however it moves in them.

In a rise, or while two motions beat, no channel goes on as it did a moment ago, and what another channel should read
is no more certain. But channels keep moving together in the few shapes in which they have moved so far in the burst and
before it. With the second moments C of that motion, x' inv(C) x is small for what keeps to these shapes and large for
what leaves them (the squared distance of Mahalanobis). Where a window leaves them, and keeps to them far better
once two of its channels are exchanged, these two have changed places. A new shape, such as a mode that is only now
excited, is not corrected by an exchange.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real

BETTER = 16.0
"""An exchange must explain the window so many times better: amplitudes four times."""

LEAVES = 50.0
"""Mean square, over what the channels moved before or their noise, from which on a window leaves the shapes."""

LOOKS = 2
"""In so many looks in a row."""


class ExchangedChannels:
    """Learns the shapes of one burst, and holds each window against them."""

    def __init__(self, rest: Real, noise: Real) -> None:
        """Learn from the (channels, n) rest before the burst, whose noise is (channels,) rms, all in one unit."""
        self._noise, self._offset = np.diag(noise**2), rest.mean(axis=1, keepdims=True)
        self._moments = np.zeros((len(noise), len(noise)))
        self._count = 0
        self._suspect: tuple[int, int] | None = None
        self._looks = 0
        self.learn(rest)

    def learn(self, values: Real) -> None:
        """Take in (channels, n) samples that are older than the window looked at."""
        moves = values - self._offset
        self._moments += moves @ moves.T
        self._count += moves.shape[1]

    def kept_to(self, learned: Real, latest: Real) -> tuple[NDArray[np.bool_], Real]:
        """Whether looks one after another keep to the shapes, (looks,), and the moments each adds to them.

        Args:
            learned: (looks, channels, n) what each look learns first.
            latest: (looks, channels, m) the window it looks at.
        """
        moves = learned - self._offset
        moments = moves @ np.swapaxes(moves, 1, 2)
        count = self._count + learned.shape[2] * np.arange(1, len(learned) + 1)
        known = (self._moments + np.cumsum(moments, axis=0)) / count[:, None, None]
        now = latest - self._offset
        seconds = now @ np.swapaxes(now, 1, 2) / now.shape[2]
        own = np.sum(np.linalg.inv(known + self._noise) * seconds, axis=(1, 2))
        return own < LEAVES * learned.shape[1], moments

    def pass_over(self, moments: Real, count: int) -> None:
        """Take in the (channels, channels) moments of `count` samples, and that the look kept to the shapes."""
        self._moments += moments
        self._count += count
        self._suspect, self._looks = None, 0

    def look(self, values: Real) -> tuple[int, int] | None:
        """The two channels that have changed places, if a (channels, n) window is the last of several that say so."""
        found = self._exchanged(values)
        self._looks = self._looks + 1 if found is not None and found == self._suspect else int(found is not None)
        self._suspect = found
        return found if self._looks >= LOOKS else None

    def _exchanged(self, values: Real) -> tuple[int, int] | None:
        moves = values - self._offset
        size = len(moves)
        now = moves @ moves.T / moves.shape[1]
        away = np.linalg.inv(self._moments / max(self._count, 1) + self._noise)
        own = float(np.sum(away * now))
        if own < LEAVES * size:
            return None
        best, pair = own, None
        for one, other in combinations(range(size), 2):
            order = np.arange(size)
            order[[one, other]] = other, one
            exchanged = float(np.sum(away * now[np.ix_(order, order)]))
            if exchanged < best:
                best, pair = exchanged, (one, other)
        return pair if best < own / BETTER else None
