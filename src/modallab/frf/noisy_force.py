"""H2 and Hv of one random force without leakage: the local polynomial method both ways round.

About a line the force is to the response as the response is to the force: their ratio is a quotient of polynomials, and
what was ringing at the record's start is smooth over a few lines in either. Taken as the response of the response, the
force may hold noise, the response none: that is H2. Hv is the geometric mean of both, as of averaged powers
(Rocklin, Crowley, Vold, "A comparison of H1, H2, and Hv frequency response functions", IMAC 3 (1985)).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.frf.local_polynomial import common_residual, local_polynomial_frf
from modallab.frf.sums import Estimator

Complex = NDArray[np.complex128]

HALF_WIDTH = 24
"""Lines to either side: with as few as H1 needs, the polynomials go through the noise, and both ways give the same."""


def one_force_frf(
    force: Complex, response: Complex, estimator: Estimator = "H1"
) -> tuple[Complex, NDArray[np.float64]]:
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
    h2: Complex = np.reciprocal(np.stack(inverse))
    return h2 if estimator == "H2" else _between(h1, h2), variance


def _between(h1: Complex, h2: Complex) -> Complex:
    middle: Complex = h1 * np.sqrt(h2 / h1)
    return middle


SAID = 1e-3
"""A bias of less is not said."""


@dataclass(frozen=True, slots=True)
class NoiseShares:
    """What of force and responses does not follow the other, as a share of their power.

    Attributes:
        force: of the force; at most so much where there is one response, which cannot tell whose noise it is.
        response: of the responses, where they are loudest.
        known: whether several responses show whose noise it is.
    """

    force: float
    response: float
    known: bool

    def bias(self, estimator: Estimator) -> float:
        """Relative, of an FRF: H1 is low by the noise of the force, H2 high by that of the responses, Hv half each."""
        h1, h2 = -self.force, self.response
        return {"H1": h1, "H2": h2, "Hv": (h1 + h2) / 2}[estimator]

    def words(self, estimator: Estimator) -> str:
        """A sentence on the bias; none where it is small."""
        bias = self.bias(estimator)
        if not self.known:
            return _of_one(self.force, estimator) if self.force > SAID else ""
        if max(self.force, abs(bias)) < SAID:
            return ""
        side = "low" if bias < 0 else "high"
        return (
            f"Noise on the force: {100 * np.sqrt(self.force):.2g} % of it, by what the responses share that does not "
            f"follow it. {estimator} is {100 * abs(bias):.2g} % {side} by the noise: so are the modal constants."
        )


def noise_shares(force: Complex, response: Complex) -> NoiseShares:
    """How noisy one force and its responses are.

    Args:
        force: (blocks, 1, lines) spectra of adjacent DFT lines of a random force, without any window in time.
        response: (blocks, outputs, lines), of the same blocks.

    Raises:
        DataError: as `local_polynomial_frf`.
    """
    shared, pairs, own, fourth = common_residual(force, response)
    power, known = float(np.mean(np.abs(force) ** 2)), pairs > 0
    noise = max(0.0, shared / pairs) if known else own / fourth
    of_force = min(noise / power, 1.0)
    left = max(0.0, own - noise * fourth) if known else own
    return NoiseShares(of_force, left / (fourth * power), bool(known))


def _of_one(share: float, estimator: Estimator) -> str:
    said = {"H1": "H1 is low by as much", "H2": "H2 is right", "Hv": "Hv is low by half of it"}[estimator]
    other = {"H1": "H1 is right", "H2": "H2 is high by as much", "Hv": "Hv is high by half of it"}[estimator]
    return (
        f"{100 * share:.2g} % of the power does not follow. One response cannot say whose noise it is: if it is the "
        f"force's, {said}; if it is the response's, {other}."
    )
