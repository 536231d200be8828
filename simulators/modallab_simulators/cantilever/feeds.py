"""What a load does to an output at once, and through the poles of a sensor."""

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.sensor import Sensor


def plain_feeds(shares: Complex128 | Real, poles: Complex128, rest: float, order: int, base: bool) -> Real:
    """Weights of f, f' and f'' in the derivative of an order of a point's motion, (3,)."""
    feeds = np.zeros(3)
    feeds[order] = rest
    if order:
        feeds[order - 1] += float(np.sum(shares).imag)
    if order == 2:
        feeds[0] += float(np.sum(shares * poles).imag)
    if base:
        # An accelerometer feels the base's own acceleration too.
        feeds[0] += 1.0 if order == 2 else 0.0
    return feeds


def sensed_feeds(feeds: Real, sensor: Sensor) -> Real:
    """The same behind a sensor: of (w0 + w1 s + w2 s^2) H(s), the part that is a polynomial."""
    sensed = sensor.direct * feeds
    for pole, residue in sensor.pairs:
        sensed[0] += (residue * (feeds[1] + feeds[2] * pole)).real
        sensed[1] += (residue * feeds[2]).real
    return sensed


def transfer(c: Complex128, poles: Complex128, feeds: Real, s: complex) -> complex:
    """What a unit load makes of a point's motion at a complex frequency."""
    modal = (c / (s - poles) - np.conj(c) / (s - np.conj(poles))).sum() / 2j
    return complex(modal + feeds[0] + feeds[1] * s + feeds[2] * s * s)
