"""FRFs of several references without leakage: the local polynomial method.

Beside the FRF, a block's spectrum holds a transient: what was still ringing at its start, less what rings on beyond its
end. Both are smooth over a few lines, the input is not. In a window of lines about each, FRF and transient are
polynomials of the line, and least squares separates them. No window in time, no averaging needed. Where a peak is
narrower than a few lines no polynomial follows it: both are then divided by one more, which holds the poles nearby.
Sources: Pintelon, Schoukens, Vandersteen, Barbe, "Estimation of nonparametric noise and FRF models for multivariable
systems", Mechanical Systems and Signal Processing 24 (2010), 573-595; McKelvey, Guerin, "Non-parametric
frequency response estimation using a local rational model", IFAC SYSID 16 (2012), for the denominator.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError

Complex = NDArray[np.complex128]


def local_polynomial_frf(
    force: Complex, response: Complex, order: int = 4, poles: int = 2, half_width: int | None = None
) -> tuple[Complex, NDArray[np.float64]]:
    """FRF and the noise variance of the responses, line by line.

    Args:
        force: (blocks, inputs, lines) spectra of adjacent DFT lines, without any window in time. They must be rough: a
            random force, or several. A single hit's spectrum is as smooth as its transient: they do not separate.
        response: (blocks, outputs, lines), of the same blocks.
        order: of the polynomials in the line.
        poles: order of the denominator; 0 for polynomials alone, which noise cannot bias.
        half_width: lines to either side of each; None for the fewest that leave the noise to be estimated.

    Returns:
        FRF (outputs, inputs, lines), and the variance (outputs, lines) of the complex noise on a response's line.

    Raises:
        DataError: shapes that do not fit, NaN, too few lines, or forces that cannot be distinguished.
    """
    blocks, inputs, lines = _checked(force, response)
    unknowns = (inputs + blocks) * (order + 1) + poles
    half = -(-(unknowns + inputs + blocks) // (2 * blocks)) if half_width is None else half_width
    width = 2 * half + 1
    if width * blocks <= unknowns or width > lines:
        raise DataError(
            f"{lines} lines, {width} about each in {blocks} blocks, cannot determine {unknowns} unknowns",
            remedy="record longer, give more lines, or lower the order",
        )
    frf = np.empty((response.shape[1], inputs, lines), complex)
    variance = np.empty((response.shape[1], lines))
    for line in range(lines):
        # Near the ends the window is held inside, and the line is not at its centre.
        start = min(max(line - half, 0), lines - width)
        window = slice(start, start + width)
        power = ((np.arange(start, start + width) - line) / half)[:, None] ** np.arange(order + 1)
        frf[..., line], variance[:, line] = _at_line(force[..., window], response[..., window], power, poles)
    return frf, variance


def _at_line(
    force: Complex, response: Complex, power: NDArray[np.float64], poles: int
) -> tuple[Complex, NDArray[np.float64]]:
    """FRF (outputs, inputs) at the window's line, and the variance (outputs,) of the noise in the window."""
    blocks, inputs, width = force.shape
    terms = power.shape[1]
    by_force = force.transpose(0, 2, 1)[:, :, :, None] * power[None, :, None, :]
    transient = np.zeros((blocks, width, blocks, terms), complex)
    transient[np.arange(blocks), :, np.arange(blocks)] = power
    shared = np.concatenate([by_force.reshape(blocks * width, -1), transient.reshape(blocks * width, -1)], axis=1)
    bend = power[:, 1:2] ** np.arange(1, poles + 1)
    found, variance = [], []
    for rows in response.transpose(1, 0, 2):
        # The denominator is 1 at the line itself, so the numerator there is the FRF.
        own = -(rows[:, :, None] * bend).reshape(blocks * width, poles)
        solution, left = _least_squares(np.concatenate([shared, own], axis=1), rows.ravel(), shared.shape[1])
        found.append(solution[: inputs * terms : terms])
        variance.append(left)
    return np.array(found), np.array(variance)


def _least_squares(columns: Complex, rows: Complex, needed: int) -> tuple[Complex, float]:
    """Solution and the residual's variance; the first `needed` columns must be distinguished."""
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(scale > 0, scale, 1)
    found, _, rank, _ = np.linalg.lstsq(scaled, rows, rcond=1e-12)
    if rank < columns.shape[1] and np.linalg.matrix_rank(scaled[:, :needed], tol=1e-12) < needed:
        raise DataError(
            "about one line the forces cannot be distinguished from one another, or from what rings on",
            remedy="drive with random forces that differ, in as many blocks as there are forces",
        )
    left = rows - scaled @ found
    return found / np.where(scale > 0, scale, 1), float(np.sum(np.abs(left) ** 2) / (len(rows) - columns.shape[1]))


def _checked(force: Complex, response: Complex) -> tuple[int, int, int]:
    if force.ndim != 3 or response.ndim != 3 or force.shape[::2] != response.shape[::2]:
        raise DataError(
            f"force {force.shape} and response {response.shape} do not belong together",
            remedy="give spectra (blocks, inputs, lines) of the forces and (blocks, outputs, lines) of the responses",
        )
    if not (np.isfinite(force).all() and np.isfinite(response).all()):
        raise DataError("the spectra hold NaN or infinite values", remedy="look at the blocks they were made from")
    return force.shape
