"""H2 and Hv of one random force without leakage: the local polynomial method both ways round.

About a line the force is to the response as the response is to the force: their ratio is a quotient of polynomials, and
what was ringing at the record's start is smooth over a few lines in either. Taken as the response of the response, the
force may hold noise, the response none: that is H2. Hv is the geometric mean of both, as of averaged powers
(Rocklin, Crowley, Vold, "A comparison of H1, H2, and Hv frequency response functions", IMAC 3 (1985)).
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128
from modallab.core.errors import DataError
from modallab.frf.local_polynomial import local_polynomial_frf
from modallab.frf.sums import Estimator

HALF_WIDTH = 24
"""Lines to either side: with as few as H1 needs, the polynomials go through the noise, and both ways give the same."""


def one_force_frf(
    force: Complex128, response: Complex128, estimator: Estimator = "H1"
) -> tuple[Complex128, NDArray[np.float64]]:
    """FRF and the noise variance of the responses, line by line.

    Args:
        force: (blocks, 1, lines) spectra of adjacent DFT lines of a random force, without any window in time.
        response: (blocks, outputs, lines), of the same blocks.
        estimator: H1, H2 or Hv.

    Returns:
        FRF (outputs, 1, lines), and the variance (outputs, lines) of the complex noise on a line of a response: of H1.

    Raises:
        DataError: shapes that do not fit, NaN, several forces with H2 or Hv, too few lines, or no force.
    """
    if estimator == "H1":
        return local_polynomial_frf(force, response)
    if force.shape[1] != 1:
        raise DataError(f"{estimator} of {force.shape[1]} forces is not made so", remedy="give one force, or use H1")
    half = min(HALF_WIDTH, (force.shape[2] - 1) // 2)
    h1, variance = local_polynomial_frf(force, response, half_width=half)
    inverse = [local_polynomial_frf(response[:, o : o + 1], force, half_width=half)[0][0] for o in range(len(h1))]
    h2: Complex128 = np.reciprocal(np.stack(inverse))
    return h2 if estimator == "H2" else _h2_over_h1(h1, h2), variance


def _h2_over_h1(h1: Complex128, h2: Complex128) -> Complex128:
    middle: Complex128 = h1 * np.sqrt(h2 / h1)
    return middle
