"""Frequency response functions as data."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FrfQuantity = Literal["receptance", "mobility", "inertance"]

DERIVATIVES: dict[FrfQuantity, int] = {"receptance": 0, "mobility": 1, "inertance": 2}
"""Times the displacement is differentiated."""
UNIT: dict[FrfQuantity, str] = {"receptance": "m/N", "mobility": "m/(N s)", "inertance": "m/(N s^2)"}


@dataclass(frozen=True, eq=False, slots=True)
class Frf:
    """FRFs of all outputs to all inputs.

    Attributes:
        frequency_hz: (lines,) strictly ascending.
        values: (outputs, inputs, lines) complex, SI.
        quantity: receptance, mobility or inertance.
        outputs: (outputs,) channel names.
        output_points: (outputs,) points, None where unknown.
        input_points: (inputs,) drive points, None where unknown.
        coherence: (outputs, inputs, lines) ordinary coherence, None if there was no averaging.
        variance: (outputs, inputs, lines) variance of `values` (of the complex number), None if unknown.
        averages: (inputs,) blocks averaged per input.
        damping_shift: rate sigma in 1/s: the FRF is evaluated at s = sigma + j omega; 0 for a plain FRF.
    """

    frequency_hz: NDArray[np.float64]
    values: NDArray[np.complex128]
    quantity: FrfQuantity
    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    coherence: NDArray[np.float64] | None = None
    variance: NDArray[np.float64] | None = None
    averages: tuple[int, ...] = ()
    damping_shift: float = 0.0

    def of_rows(self, rows: Sequence[int]) -> "Frf":
        """The FRFs of these outputs only, in this order."""
        kept = list(rows)
        return replace(
            self,
            values=self.values[kept],
            outputs=tuple(self.outputs[row] for row in kept),
            output_points=tuple(self.output_points[row] for row in kept),
            coherence=None if self.coherence is None else self.coherence[kept],
            variance=None if self.variance is None else self.variance[kept],
        )
