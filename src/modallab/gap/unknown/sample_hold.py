"""Samples that one channel has lost: where it repeats itself or reads nothing while the twin says that it moves."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.unknown.volts import ChannelOperator

EXCEEDING = 6.0
"""Times the noise by which a sample must have been expected elsewhere to count as lost."""
LEAST = 0.002
"""Smallest share of lost samples that is no chance."""


@dataclass(frozen=True, eq=False, slots=True)
class SampleHold:
    """Lost samples.

    Attributes:
        kept: 1 where the sample before stands in place of a lost one, 0 where nothing does.
        share: of the samples at which a loss can be seen, that are lost.
        spread: one standard deviation of it.
        made: record -> (n,) V that the twin predicts, the losses of that record in it.
    """

    kept: float
    share: float
    spread: float
    made: dict[str, Real]


def hold_of(channel: ChannelOperator, noise_v: float) -> SampleHold | None:
    """What a channel has lost; None where it has lost nothing."""
    found = [_hold(channel, noise_v, kept) for kept in (1.0, 0.0)]
    best = max(found, key=lambda h: h.share)
    return best if best.share > LEAST else None


def _hold(channel: ChannelOperator, noise_v: float, kept: float) -> SampleHold:
    lost = seen = 0
    made: dict[str, Real] = {}
    for name, counts in channel.counts.items():
        u = channel.expected[name]
        same = np.zeros(len(u), dtype=np.bool_)
        same[1:] = counts[1:] == (counts[:-1] if kept else 0.0)
        # Of a run of lost samples each is held from the last that was not.
        last = np.maximum.accumulate(np.where(same, 0, np.arange(len(u))))
        instead = u[last] if kept else np.zeros(len(u))
        could = np.abs(u - (np.concatenate([u[:1], u[:-1]]) if kept else 0.0)) > EXCEEDING * noise_v
        gone = same & (could | (np.abs(u - instead) > EXCEEDING * noise_v))
        made[name] = np.where(gone, instead, u)
        lost, seen = lost + int(np.count_nonzero(gone & could)), seen + int(np.count_nonzero(could))
    share = lost / max(seen, 1)
    return SampleHold(kept, share, float(np.sqrt(share * (1 - share) / max(seen, 1))), made)
