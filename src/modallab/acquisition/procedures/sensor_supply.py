"""Waiting until fed sensors have settled: their bias steps when the supply comes on, and the AC coupling lets it fade.

The bias is some 10 V; after a coupling of 0.35 Hz it takes 3 s until a few mV are left. The mean of a window under a
Hann weight shows what is left of it, since a ringing beam hardly reaches that mean. While the bias fades, means of
neighbouring windows differ by more than twice the scatter within a window, however slow it is; noise makes them
differ by less than a tenth.
"""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.bench.abilities import FeedsSensors
from modallab.bench.protocol import Bench
from modallab.core.rig import Rig

Pull = Callable[[int], NDArray[np.generic]]
"""Reads the next so many samples: (channels, n) as delivered."""

WINDOW_S = 0.5
WINDOWS = 4
"""So many windows before are compared, since a slow bias moves little from one to the next."""

STEADY = 0.3
"""Largest difference of means, in scatters of a window."""

PATIENCE_S = 60.0
"""Low-frequency sensors discharge with 10 s; after six of these it is no bias that fades."""


@dataclass(frozen=True, slots=True)
class SupplyWait:
    """What waiting came to.

    Attributes:
        seconds: waited.
        unsettled: channels whose bias still moved at the end.
    """

    seconds: float
    unsettled: tuple[str, ...]


def fed_channels(bench: Bench, rig: Rig) -> dict[int, str]:
    """Channels, by their place in the rig, whose sensors this bench feeds."""
    fed = set(bench.fed_channels()) if isinstance(bench, FeedsSensors) else set[str]()
    return {channel.index: channel.name for channel in rig.channels if channel.name in fed}


def wait_until_settled(
    pull: Pull, fed: Mapping[int, str], rate_hz: float, patience_s: float = PATIENCE_S
) -> SupplyWait:
    """Read until the bias of no fed channel moves any more, at most so long; nothing is read where none is fed.

    Args:
        pull: reads on.
        fed: names of the channels by row.
        rate_hz: at which the samples come.
        patience_s: at most to wait.
    """
    if not fed:
        return SupplyWait(0.0, ())
    rows, count = list(fed), max(16, round(WINDOW_S * rate_hz))
    weight = np.hanning(count + 2)[1:-1]
    weight /= weight.sum()
    before: deque[NDArray[np.float64]] = deque(maxlen=WINDOWS)
    moving = np.ones(len(rows), dtype=np.bool_)
    for n in range(1, max(2, int(patience_s / WINDOW_S)) + 1):
        window = pull(count)[rows].astype(np.float64)
        mean = window @ weight
        if before:
            moving = np.abs(mean - np.array(before)).max(axis=0) > STEADY * window.std(axis=1)
            if not moving.any():
                return SupplyWait(n * WINDOW_S, ())
        before.append(mean)
    return SupplyWait(patience_s, tuple(fed[row] for row, left in zip(rows, moving, strict=True) if left))
