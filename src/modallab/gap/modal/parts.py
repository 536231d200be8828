"""The gap channel by channel and mode by mode: shares of the response, as of the whole."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.modal_diagnosis import PartOfGap
from modallab.gap.modal.fitting import FittedExplanation
from modallab.gap.modal.free import Free


@dataclass(frozen=True, eq=False, slots=True)
class RelativeMisfits:
    """(lines, outputs, inputs) each: predicted less measured over the size of the measured.

    Attributes:
        nominal: of the reference as it came.
        before: with the tolerances fitted.
        after: with the change.
    """

    nominal: Real
    before: Real
    after: Real

    @classmethod
    def of(cls, free: Free, base: FittedExplanation, best: FittedExplanation) -> "RelativeMisfits":
        """Of a comparison, its fit without a change, and the explanation that counts."""
        return cls(free.missed(np.zeros(free.size)), base.missed, best.missed)

    def part(self, name: str, of: tuple[slice | NDArray[np.bool_], ...], hz: float | None = None) -> PartOfGap:
        """The rms of some of them."""
        nominal, before, after = (float(np.sqrt(np.mean(m[of] ** 2))) for m in (self.nominal, self.before, self.after))
        return PartOfGap(name=name, frequency_hz=hz, nominal=nominal, before=before, after=after)


def by_channel(free: Free, misses: RelativeMisfits) -> list[PartOfGap]:
    """Of each output."""
    every = slice(None)
    return [misses.part(name, (every, slice(n, n + 1))) for n, name in enumerate(free.of.model.outputs)]


def by_mode(free: Free, misses: RelativeMisfits) -> list[PartOfGap]:
    """Of the lines that are nearest to each of the bench's modes, as a ratio; without modes that have no line."""
    modes_hz = free.of.bench.frequency_hz
    away = np.abs(np.log(free.of.s.imag[:, None] / (2 * np.pi * modes_hz)))
    nearest = np.argmin(away, axis=1)
    return [
        misses.part(str(r + 1), (nearest == r,), float(hz)) for r, hz in enumerate(modes_hz) if np.any(nearest == r)
    ]
