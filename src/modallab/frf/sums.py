"""What the FRF of one input is made of: powers and cross powers, summed over blocks as they come."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Self

import numpy as np

from modallab.core.array_checks import check_spectra
from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.core.units import FrfEstimator

Estimator = FrfEstimator


@dataclass(frozen=True, eq=False, slots=True)
class PowerSums:
    """Sums over the blocks of one input.

    Attributes:
        force: (lines,) power of the force.
        response: (outputs, lines) powers of the responses.
        cross: (outputs, lines) cross power, conj(force) times response.
        averages: blocks summed.
    """

    force: Real
    response: Real
    cross: Complex128
    averages: int

    @classmethod
    def of(cls, force: Complex128, response: Complex128) -> Self:
        """Of some blocks.

        Args:
            force: (blocks, lines) spectra.
            response: (blocks, outputs, lines) spectra.

        Raises:
            DataError: shapes that do not belong together, or numbers that are not finite.
        """
        check_spectra(force[:, None], response)
        # Block by block: a sum over an axis would copy what is the largest array of a run.
        each = (cls(_power(f), _power(y), np.conj(f) * y, 1) for f, y in zip(force, response, strict=True))
        return reduce(cls.with_more, each)

    def with_more(self, other: Self) -> Self:
        """Of the blocks of both."""
        return type(self)(
            self.force + other.force,
            self.response + other.response,
            self.cross + other.cross,
            self.averages + other.averages,
        )

    def frf(self, estimator: Estimator = "H1") -> tuple[Complex128, Real]:
        """The FRF and the ordinary coherence.

        H1 = Sfy / Sff is unbiased under noise on the response, H2 = Syy / Syf under noise on the force,
        Hv (total least squares of the two, equal relative noise) lies between.

        Args:
            estimator: which of the three.

        Returns:
            FRF (outputs, lines) and coherence (outputs, lines) in 0 to 1; with one block it is 1 by construction.

        Raises:
            DataError: a line without force.
        """
        if np.any(self.force == 0):
            raise DataError("the force has no content at some lines of the band", remedy="narrow the band")
        h1 = self.cross / self.force
        common = _power(self.cross)
        product = self.force * self.response
        coherence = np.divide(common, product, out=np.zeros_like(common), where=product > 0)
        if estimator == "H1":
            return h1, coherence
        magnitude = np.sqrt(common)
        safe = np.where(magnitude > 0, magnitude, 1.0)
        h2_magnitude = self.response / safe
        phase: Complex128 = np.where(magnitude > 0, self.cross / safe, 1.0 + 0j)
        if estimator == "H2":
            return phase * h2_magnitude, coherence
        return phase * np.sqrt(np.abs(h1) * h2_magnitude), coherence


def check_averages(estimator: Estimator, averages: Sequence[int], what: str) -> None:
    """Reject H2 and Hv of single blocks: they are H1 by construction, and say nothing that it does not.

    Args:
        estimator: H1, H2 or Hv.
        averages: blocks of each input.
        what: these are, in the plural: hits, blocks.

    Raises:
        DataError: an input has one block only.
    """
    if estimator != "H1" and min(averages) < 2:
        raise DataError(
            f"{estimator} asks for several {what} of each input, and there is one: for one it equals H1",
            remedy=f"record more {what}, or use H1",
        )


def _power(spectrum: Complex128) -> Real:
    # Without the root that an absolute value takes, which costs more than all the rest.
    return spectrum.real**2 + spectrum.imag**2
