"""What an output's trace shows of a stop: how it left the sine, and how steeply it came to 0 V."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from modallab.bench.ramp_down import MOST_PER_S

RATE_HZ = 51_200.0
HOLD = 25
"""So many equal samples are the output's hold after the stop."""


@dataclass(frozen=True)
class Stop:
    """Attributes, in parts of the level.

    Attributes:
        jump: most that one sample differs from the one before, beyond what the sine itself or a fall does.
        per_ms: most that the output changes in a ms from the stop on.
        took_s: from the stop to exactly 0 V.
        end_v: the last value.
    """

    jump: float
    per_ms: float
    took_s: float
    end_v: float


def seen(volts: NDArray[np.float64], frequency_hz: float, level_v: float) -> Stop:
    """The stop in a trace at RATE_HZ that begins in the burst and ends after it."""
    step = np.abs(np.diff(volts))
    last = int(np.flatnonzero(volts)[-1])
    still = np.convolve(step[:last] == 0, np.ones(HOLD), "valid") == HOLD
    held = np.flatnonzero(still & (volts[: len(still)] != 0))
    # The first of the last ones that follow each other; without a hold it was a step.
    stop = int(held[np.flatnonzero(np.diff(held, prepend=-2) > 1)[-1]]) if held.size else last
    after = volts[stop:]
    in_a_ms = round(1e-3 * RATE_HZ)
    zero = int(np.argmax(after == 0)) if after[-1] == 0 else len(after)
    own = max(2 * pi * frequency_hz, MOST_PER_S) * level_v / RATE_HZ
    return Stop(
        jump=float(max(0.0, step.max() - 1.01 * own)) / level_v,
        per_ms=float(np.abs(after[in_a_ms:] - after[:-in_a_ms]).max()) / level_v,
        took_s=zero / RATE_HZ,
        end_v=float(volts[-1]),
    )
