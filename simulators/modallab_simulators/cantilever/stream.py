"""The stream of counts: stretches computed one after another, handed out in pieces of any size."""

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.cantilever.chain import Chain
from modallab_simulators.cantilever.excitation import Excitation
from modallab_simulators.cantilever.structure import BLOCK, Structure


class SampleStream:
    """Samples since the start.

    Stretches lie on a fixed grid and their noise is drawn once, so what is read does not depend on how it is read.
    When the excitation changes within a stretch, the stretch is computed anew from the state at its beginning.
    """

    def __init__(
        self, structure: Structure, chain: Chain, excitation: Excitation, rate_hz: float, rng: np.random.Generator
    ) -> None:
        self.position = 0
        self._structure, self._chain, self._excitation, self._rng = structure, chain, excitation, rng
        self._step_s = 1 / (rate_hz * structure.oversample)
        self._block = -1
        self._before = self._after = structure.at_rest
        self._noise = np.zeros((0, 0), dtype=np.float32)
        self._counts: NDArray[np.generic] | None = None

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

    def changed(self) -> None:
        """The excitation from here on is another than it was."""
        self._counts = None

    def _counts_of(self, block: int) -> NDArray[np.generic]:
        if block != self._block:
            if self._counts is None and self._block >= 0:
                self._compute()
            self._block, self._before = block, self._after
            self._noise = self._rng.standard_normal((len(self._chain.volts_per_si), BLOCK), dtype=np.float32)
            self._counts = None
        return self._compute() if self._counts is None else self._counts

    def _compute(self) -> NDArray[np.generic]:
        first, count = self._structure.times(self._block)
        self._excitation.forget(first * self._step_s)
        seen, self._after = self._structure.advance(self._before, self._excitation.drives(first, count, self._step_s))
        self._counts = self._chain.convert(seen, self._noise)
        return self._counts
