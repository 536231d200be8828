"""What a response must read of a tone, by the other responses and the shapes of the bursts before.

A channel that shows nothing may be dead, or stand in a node of this frequency's shape. Where the other responses are a
combination of shapes that were seen before, the same combination says what the channel must read; where they are not,
nothing follows.
"""

import numpy as np

from modallab.core.arrays import Complex128

MOST = 24
"""Shapes that are remembered, the latest."""

KEPT_PART = 0.01
"""What is below this part of the largest direction of all shapes is noise."""

SURE = 5.0
"""What a channel must read stands so many times above what the combination leaves of the others."""


class KnownShapes:
    """Remembers the responses to the bursts that have settled."""

    def __init__(self) -> None:
        self._shapes: list[Complex128] = []
        self._sizes: list[float] = []

    def keep(self, tone: Complex128) -> None:
        """Remember the (responses,) complex amplitudes of a burst, over their noise."""
        size = float(np.linalg.norm(tone))
        if size > 0:
            self._shapes = [*self._shapes, tone / size][-MOST:]
            self._sizes = [*self._sizes, size][-MOST:]

    def must_read(self, channel: int, tone: Complex128) -> float:
        """The least that one of (responses,) must read, over its noise, by the others; 0 where nothing is known."""
        if not self._shapes or tone.size < 2:
            return 0.0
        shapes = np.array(self._shapes).T
        others = np.delete(np.arange(tone.size), channel)
        left, sizes, right = np.linalg.svd(shapes[others], full_matrices=False)
        kept = sizes > KEPT_PART * sizes[0]
        parts = left[:, kept].conj().T @ tone[others]
        combination = right[kept].conj().T @ (parts / sizes[kept])
        left_over = np.linalg.norm(tone[others] - left[:, kept] @ parts)
        # The shapes themselves are known to their own noise only.
        unsure = np.linalg.norm(combination / np.array(self._sizes))
        return max(0.0, float(np.abs(shapes[channel] @ combination) - SURE * (left_over + unsure)))
