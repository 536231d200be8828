"""Poles of modes."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real


def poles_of(omega: Real, zeta: Real) -> NDArray[np.complex128]:
    """Poles lambda = -zeta omega + j omega sqrt(1 - zeta^2), in rad/s."""
    return -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)
