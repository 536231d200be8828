"""How the force runs between the internal samples, and what an oscillator makes of it."""

from math import prod

import numpy as np
from numpy.typing import NDArray

from modallab.core.quadrature import gauss_legendre

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
