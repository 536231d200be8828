"""FRFs of several forces that act at once, with coherence, variance and intervals.

Every force is noisy, and so is every response. H1 takes the forces as exact, H2 the responses, Hv neither: with both
scaled to unit power it is the total least squares solution. One force gives the same as `combine`.
Sources: Rocklin, Crowley, Vold, "A comparison of H1, H2, and Hv frequency response functions", IMAC 3 (1985); Bendat,
Piersol, "Random Data", 4th ed. (2010), section 9.3, for the random error and its F distribution.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtri

from modallab.core.array_checks import check_spectra
from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.frf.sums import Estimator

ALIKE = 1e10
"""Condition of the forces' correlation from which they are one force."""


@dataclass(frozen=True, eq=False, slots=True)
class EstimatedFrf:
    """FRFs and what is known of their error.

    Attributes:
        frf: (outputs, inputs, lines).
        coherence: (outputs, lines) multiple coherence, 0 to 1: the share of a response that the forces explain.
        variance: (outputs, inputs, lines) of the complex FRF, from what the forces do not explain: that of H1.
        freedom: real degrees of freedom of that variance.
    """

    frf: Complex128
    coherence: Real
    variance: Real
    freedom: float

    def confidence_radius(self, level: float = 0.95) -> Real:
        """(outputs, inputs, lines) radius of the circle about each value that holds the true one with this probability.

        |H - H_true|^2 / variance follows F with 2 and `freedom` degrees of freedom.

        Raises:
            DataError: a level that is no probability.
        """
        if not 0 < level < 1:
            raise DataError(f"{level} is no probability", remedy="give one between 0 and 1, such as 0.95")
        return np.sqrt(self.variance * float(fdtri(2, self.freedom, level)))


def estimate_frf(
    force: Complex128, response: Complex128, estimator: Estimator = "H1", averages: float | None = None
) -> EstimatedFrf:
    """FRFs of all responses to all forces from spectra of several blocks.

    Args:
        force: (blocks, inputs, lines); at least one block more than inputs, and forces that differ between blocks.
        response: (blocks, outputs, lines); for H2 at least as many outputs as inputs.
        estimator: H1, H2 or Hv.
        averages: number of independent averages, where blocks overlap; None for their number.

    Raises:
        DataError: shapes that do not fit, NaN, too few blocks, or forces that cannot be distinguished.
    """
    independent = _number_of_averages(force, response, estimator, averages)
    scale_f, scale_y = _rms_level(force), _rms_level(response)
    f, y = np.moveaxis(force / scale_f[:, None], -1, 0), np.moveaxis(response / scale_y[:, None], -1, 0)
    # (lines, inputs, inputs), (lines, outputs, inputs), (lines, outputs, outputs): means over the blocks.
    ff, yf = f.transpose(0, 2, 1) @ f.conj() / len(force), y.transpose(0, 2, 1) @ f.conj() / len(force)
    if np.linalg.cond(ff).max() > ALIKE:
        raise DataError(
            "at some lines the forces cannot be distinguished from one another, or are zero",
            remedy="drive with forces that differ, in more blocks than there are forces, or narrow the band",
        )
    inverse = np.linalg.inv(ff)
    h1 = yf @ inverse
    power = np.mean(np.abs(y) ** 2, axis=1)
    left = np.maximum(power - np.einsum("loi,loi->lo", h1, yf.conj()).real, 0.0)
    coherence = 1 - np.divide(left, power, out=np.zeros_like(left), where=power > 0)
    inputs = force.shape[1]
    noise = left * independent / (independent - inputs)
    variance = noise[:, :, None] * np.einsum("lii->li", inverse).real[:, None, :] / independent
    value = h1 if estimator == "H1" else _h2(y, yf) if estimator == "H2" else _hv(ff, yf, power)
    by_line = scale_y[:, None] / scale_f
    return EstimatedFrf(
        np.moveaxis(value, 0, -1) * by_line[..., None],
        coherence.T,
        np.moveaxis(variance, 0, -1) * by_line[..., None] ** 2,
        2 * (independent - inputs),
    )


def _h2(y: Complex128, yf: Complex128) -> Complex128:
    """Gyy = H Gfy, solved for H: the pseudoinverse where there are more outputs than inputs."""
    yy = y.transpose(0, 2, 1) @ y.conj() / y.shape[1]
    return yy @ np.linalg.pinv(yf.conj().transpose(0, 2, 1), rcond=1e-10)


def _hv(ff: Complex128, yf: Complex128, power: Real) -> Complex128:
    """Each output with all forces: the direction in which forces and output together have the least power."""
    lines, outputs, inputs = yf.shape
    both = np.empty((lines, outputs, inputs + 1, inputs + 1), complex)
    both[..., :-1, :-1] = ff[:, None]
    both[..., -1, :-1] = yf
    both[..., :-1, -1] = yf.conj()
    both[..., -1, -1] = power
    # Unit power line by line: H1 and H2 of one force then err alike, and Hv is their geometric mean.
    root = np.sqrt(np.maximum(np.einsum("loii->loi", both).real, np.finfo(float).tiny))
    _, vectors = np.linalg.eigh(both / (root[..., :, None] * root[..., None, :]))
    least = vectors[..., 0].conj()
    last = least[..., -1:]
    safe = np.where(np.abs(last) > 0, last, 1)
    return np.where(np.abs(last) > 0, -least[..., :-1] / safe, 0) * root[..., -1:] / root[..., :-1]


def _rms_level(spectra: Complex128) -> Real:
    """(channels,) RMS, 1 for one that is zero: responses and forces may differ by many powers of ten."""
    size = np.sqrt(np.mean(np.abs(spectra) ** 2, axis=(0, 2)))
    return np.where(size > 0, size, 1.0)


def _number_of_averages(force: Complex128, response: Complex128, estimator: Estimator, averages: float | None) -> float:
    """The number of independent averages."""
    check_spectra(force, response)
    blocks, inputs, _ = force.shape
    independent = float(blocks if averages is None else averages)
    if inputs < 1 or not inputs < independent <= blocks:
        found = f"{blocks} blocks, {independent:g} independent averages, cannot determine {inputs} forces and the noise"
        raise DataError(found, remedy="record more blocks than there are forces")
    if estimator == "H2" and response.shape[1] < inputs:
        found = f"H2 of {inputs} forces needs as many responses, not {response.shape[1]}"
        raise DataError(found, remedy="use H1 or Hv, or more responses")
    return independent
