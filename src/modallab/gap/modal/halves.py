"""By how much two measurements of one thing differ, from the hits of one: each half of them is a measurement."""

from collections.abc import Sequence

import numpy as np

from modallab.core.rig import Rig
from modallab.gap.modal.errors import sizes
from modallab.identification.impact import start_frf
from modallab.signals.signals import Signals


def share_between_halves(groups: Sequence[Sequence[Signals]], rig: Rig, band_hz: tuple[float, float]) -> float | None:
    """Share of the response by which two measurements like this one differ; None where a point has one hit.

    Every second hit at each point is one half. Halves hold half the hits each: measurements as long as this one differ
    by less, by the root of 2.

    Args:
        groups: hits by their point.
        rig: its sensors.
        band_hz: where FRFs are compared.
    """
    if min(map(len, groups)) < 2:
        return None
    halves = (start_frf([list(hits[n::2]) for hits in groups], rig, band_hz) for n in (0, 1))
    one, other = (np.moveaxis(half.values, -1, 0) for half in halves)
    return float(np.sqrt(np.mean((np.abs(one - other) / sizes((one + other) / 2)) ** 2) / 2))
