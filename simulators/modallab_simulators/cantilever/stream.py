"""The stream of counts: stretches computed one after another, handed out in pieces of any size."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.cantilever.chain import Chain, Luck
from modallab_simulators.cantilever.excitation import Excitation
from modallab_simulators.cantilever.loads import BLOCK, Drive, Moving

StructureAt = Callable[[int], Moving]
"""The structure as it is in a stretch."""


class SampleStream:
    """Samples since the start.

    Stretches lie on a fixed grid and their noise is drawn once, so what is read does not depend on how it is read.
    When the excitation changes within a stretch, the stretch is computed again from the state at its beginning.
    """

    def __init__(
        self,
        structure_at: StructureAt,
        chain: Chain,
        excitation: Excitation,
        rate_hz: float,
        rng: np.random.Generator,
        flaws: np.random.Generator,
    ) -> None:
        self.position = 0
        self._structure_at, self._structure = structure_at, structure_at(0)
        self._chain, self._excitation, self._rng, self._flaws = chain, excitation, rng, flaws
        self._rate_hz = rate_hz
        self._step_s = 1 / (rate_hz * self._structure.oversample)
        self._block = -1
        self._before = self._after = self._structure.at_rest
        self._luck = Luck(np.zeros((0, 0), dtype=np.float32))
        self._counts: NDArray[np.generic] | None = None
        self._passed = np.zeros((0, 0), dtype=np.int16)

    def take(self, count: int) -> NDArray[np.generic]:
        """The next `count` samples, (channels, count)."""
        pieces: list[NDArray[np.generic]] = []
        end = self.position + count
        while self.position < end:
            block, offset = divmod(self.position, BLOCK)
            stop = min(BLOCK, offset + end - self.position)
            pieces.append(self._counts_of(block)[:, offset:stop])
            self.position += stop - offset
        return np.concatenate(pieces, axis=1)

    def skip(self, position: int) -> None:
        """Go on to a sample count; the beam moves on, but nothing is converted on the way."""
        block = position // BLOCK
        for passed in range(max(self._block, 0), block):
            if passed != self._block:
                self._step_to(passed)
            if self._counts is None:
                self._after = self._structure.pass_over(self._before, self._drives())
                # What follows starts from this stretch's end; it need not be computed again.
                self._counts = self._passed
        self.position = max(self.position, position)

    def changed(self) -> None:
        """The excitation from here on is another than it was."""
        self._counts = None

    def _counts_of(self, block: int) -> NDArray[np.generic]:
        if block != self._block:
            if self._counts is None and self._block >= 0:
                self._compute()
            self._step_to(block)
        return self._compute() if self._counts is None else self._counts

    def _step_to(self, block: int) -> None:
        structure = self._structure_at(block)
        if structure is not self._structure:
            self._after, self._structure = structure.taken_over(self._structure, self._after), structure
        self._block, self._before = block, self._after
        self._luck = self._chain.draw(self._rng, self._flaws, BLOCK)
        self._counts = None

    def _compute(self) -> NDArray[np.generic]:
        seen, self._after = self._structure.advance(self._before, self._drives())
        times = (self._block * BLOCK + np.arange(BLOCK)) / self._rate_hz
        self._counts = self._chain.convert(seen, self._luck, times)
        return self._counts

    def _drives(self) -> list[Drive]:
        first, count = self._structure.times(self._block)
        self._excitation.forget(first * self._step_s)
        return self._excitation.drives(first, count, self._step_s)
