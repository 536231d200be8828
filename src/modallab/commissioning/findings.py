"""What a check of a rig finds, and how it reads the bench."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Bench

Verdict = Literal["good", "look", "bad"]

CHUNK_S = 0.1
TIMEOUT_S = 10.0


@dataclass(frozen=True, slots=True)
class Finding:
    """One verdict.

    Attributes:
        channel: of the rig, or what else was looked at.
        what: supply, noise, offset, overload, polarity, sensitivity, clock, phase and the like.
        value: in words and numbers.
        verdict: `look` where a person must decide.
    """

    channel: str
    what: str
    value: str
    verdict: Verdict


def take(bench: Bench, rate_hz: float, seconds: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The next `seconds`: (channels, n) as delivered, and (channels,) which were beyond the range."""
    return take_samples(bench, rate_hz, round(seconds * rate_hz))


def take_samples(bench: Bench, rate_hz: float, count: int) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The next (channels, count) samples, and (channels,) which were beyond the range."""
    pieces: list[NDArray[np.float64]] = []
    step = max(1, round(CHUNK_S * rate_hz))
    over: NDArray[np.bool_] | None = None
    for first in range(0, count, step):
        chunk = bench.read(min(step, count - first), TIMEOUT_S)
        pieces.append(chunk.samples.astype(np.float64))
        over = chunk.overload if over is None else over | chunk.overload
    assert over is not None
    return np.concatenate(pieces, axis=1), over
