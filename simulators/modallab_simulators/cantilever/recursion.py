"""Poles stepped in time, many samples at once: the recursion, the force between samples, the anti-alias filter."""

from math import prod

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real, gauss_legendre
from modallab_simulators.cantilever.sensor import SensorTransfer

_MAX_LOG = 300.0


class LinearRecursion:
    """Runs `length` steps from a start value.

    With powers of lambda taken out, the recursion is a running sum. Its rounding is that of the largest state on the
    way, since older terms only shrink; the stretch is cut where the powers would leave double precision's range.
    """

    def __init__(self, poles: Complex128, step_s: float, length: int) -> None:
        decay = float(np.max(-poles.real, initial=0.0)) * step_s
        self._stretch = length if decay * length < _MAX_LOG else max(1, int(_MAX_LOG / decay))
        self._length = length
        self._decays: Complex128 = np.exp(np.multiply.outer(np.arange(length + 1) * step_s, poles))
        self._grows: Complex128 = np.exp(np.multiply.outer(-np.arange(1, self._stretch + 1) * step_s, poles))

    def undriven_states(self, start: Complex128) -> tuple[Complex128, Complex128]:
        """States of an undriven stretch, (length, poles), and the state after it."""
        return self._decays[:-1] * start, self._decays[-1] * start

    def driven_states(self, start: Complex128, driving: Complex128) -> tuple[Complex128, Complex128]:
        """States of a stretch driven by w, (length, poles), and the state after it."""
        states = np.empty_like(driving)
        for first in range(0, self._length, self._stretch):
            part = driving[first : first + self._stretch]
            count = len(part)
            sums = part * self._grows[:count]
            np.cumsum(sums, axis=0, out=sums)
            sums += start
            states[first] = start
            np.multiply(sums[:-1], self._decays[1:count], out=states[first + 1 : first + count])
            start = sums[-1] * self._decays[count]
        return states, start


REACH = 4
"""Internal samples the interpolation reaches back from a step's beginning; forward it is one more."""

_OFFSETS = tuple(range(-REACH, REACH + 2))
TAPS = len(_OFFSETS)


def step_taps(
    poles: NDArray[np.complex128], step_s: float, first: float = 0.0, last: float = 1.0
) -> NDArray[np.complex128]:
    """Integral of exp(p (T - s)) u(s) over one step T, as weights on the force samples about it, (poles, TAPS).

    With `first` and `last` the integral over that share of the step, of exp(p (last T - s)) u(s).

    Between samples u is the polynomial through the ten nearest, which up to a tenth of the internal rate is the
    band-limited signal to 3e-6. A first-order hold would err by 3 % there, and let images of the force through.
    The integral is exact to rounding (Gauss-Legendre).
    """
    nodes, weights = gauss_legendre(24)
    at = first + (last - first) * (nodes + 1) / 2
    basis = np.stack([_lagrange(at, k, _OFFSETS) for k in _OFFSETS])
    kernel: NDArray[np.complex128] = np.exp(np.multiply.outer(poles, (last - at) * step_s))
    return (kernel * (weights * (step_s * (last - first) / 2))) @ basis.T.astype(np.complex128)


def _lagrange(at: NDArray[np.float64], k: int, offsets: tuple[int, ...]) -> NDArray[np.float64]:
    others = [m for m in offsets if m != k]
    return np.prod([at - m for m in others], axis=0) / prod(k - m for m in others)


def difference_taps(order: int, step_s: float) -> NDArray[np.float64]:
    """Weights on the 2 REACH + 1 centred samples that give the derivative of order 0, 1 or 2, to eighth order."""
    table = {
        0: (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        1: (1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280),
        2: (-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560),
    }
    return np.array(table[order]) / step_s**order


def modal_taps(
    poles: NDArray[np.complex128], step_s: float, lowpass_taps: NDArray[np.float64]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """What a filtered mode owes to each force sample, (modes, taps), and to the state before, (modes,).

    Samples and taps run from the oldest to the newest.
    """
    step = np.exp(poles * step_s)
    length = len(lowpass_taps) - 1
    after = np.empty((length, len(poles)), dtype=np.complex128)
    total = np.full(len(poles), lowpass_taps[length], dtype=np.complex128)
    for s in range(length - 1, -1, -1):
        after[s] = total
        total = total * step + lowpass_taps[s]
    holds = step_taps(poles, step_s)
    modal = np.array([np.convolve(after[:, r], holds[r]) for r in range(len(poles))]).reshape(len(poles), -1)
    return modal, total


def state_taps(poles: NDArray[np.complex128], step_s: float, oversample: int) -> NDArray[np.complex128]:
    """Weights of the force samples in the state after one delivered sample, (taps, modes)."""
    step = np.exp(poles * step_s)
    holds = step_taps(poles, step_s)
    taps = np.zeros((oversample + TAPS - 1, len(poles)), dtype=np.complex128)
    for s in range(oversample):
        taps[s : s + TAPS] += (holds * step[:, None] ** (oversample - 1 - s)).T
    return taps


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


def sensed_feeds(feeds: Real, sensor: SensorTransfer) -> Real:
    """The same behind a sensor: of (w0 + w1 s + w2 s^2) H(s), the part that is a polynomial."""
    sensed = sensor.direct * feeds
    for pole, residue in sensor.poles_and_residues:
        sensed[0] += (residue * (feeds[1] + feeds[2] * pole)).real
        sensed[1] += (residue * feeds[2]).real
    return sensed


def point_transfer(c: Complex128, poles: Complex128, feeds: Real, s: complex) -> complex:
    """What a unit load makes of a point's motion at a complex frequency."""
    modal = (c / (s - poles) - np.conj(c) / (s - np.conj(poles))).sum() / 2j
    return complex(modal + feeds[0] + feeds[1] * s + feeds[2] * s * s)


DELAY = 30
"""Group delay in delivered samples, of the order of a delta-sigma converter's."""

_STOP_DB = 105.0


def lowpass_taps(oversample: int, later: float = 0.0, wait: int = 0) -> NDArray[np.float64]:
    """Taps at `oversample` times the delivered rate, (2 * DELAY * oversample + wait + 1,).

    Kaiser-windowed ideal low-pass at half the delivered rate (Oppenheim and Schafer, Discrete-Time Signal Processing,
    7.5). Flat within 1e-5 up to 0.44 of the delivered rate and 100 dB down from 0.56 of it, so that nothing folds
    back onto what is flat.

    Args:
        oversample: internal samples per delivered one.
        later: how much later than others this row is sampled, in internal samples, up to `wait`.
        wait: what the others wait for it, in internal samples.
    """
    half = DELAY * oversample
    # The first tap weighs the oldest sample.
    n = np.arange(2 * half + wait + 1) - half - later
    inside = np.sqrt(np.maximum(1 - (n / half) ** 2, 0.0))
    taps = np.sinc(n / oversample) * np.where(np.abs(n) <= half, np.i0(0.1102 * (_STOP_DB - 8.7) * inside), 0.0)
    return taps / taps.sum()
