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

from modallab.core.array_checks import check_spectra
from modallab.core.arrays import Complex128
from modallab.core.errors import DataError
from modallab.frf.sums import Estimator

MOST_VALUES = 100_000
"""Of the matrices that are worked on at once: as many as a processor keeps at hand."""
DISTINGUISHED = 1e-12
"""Columns of length 1 whose least singular value is above it."""
_HALF_WIDTH = 24
"""Lines to either side: with as few as H1 needs, the polynomials go through the noise, and both ways give the same."""


def local_polynomial_frf(
    force: Complex128, response: Complex128, order: int = 4, poles: int = 2, half_width: int | None = None
) -> tuple[Complex128, NDArray[np.float64]]:
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
    check_spectra(force, response)
    blocks, inputs, lines = force.shape
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
    at_once = max(1, MOST_VALUES // (blocks * width * unknowns))
    for first in range(0, lines, at_once):
        line = np.arange(first, min(first + at_once, lines))
        # Near the ends the window is held inside, and the line is not at its centre.
        window = np.clip(line - half, 0, lines - width)[:, None] + np.arange(width)
        power = ((window - line[:, None]) / half)[..., None] ** np.arange(order + 1)
        there = force[..., window].transpose(2, 0, 3, 1), response[..., window].transpose(2, 0, 3, 1)
        frf[..., line], variance[:, line] = _frf_in_windows(*there, power, poles)
    return frf, variance


def _frf_in_windows(
    force: Complex128, response: Complex128, power: NDArray[np.float64], poles: int
) -> tuple[Complex128, NDArray[np.float64]]:
    """FRF (outputs, inputs, lines) in the middle of windows, and the variance (outputs, lines) of the noise in each.

    Args:
        force: (lines, blocks, width, inputs) the spectra in each line's window.
        response: (lines, blocks, width, outputs)
        power: (lines, width, terms) of the polynomials.
        poles: order of the denominator.
    """
    lines, blocks, width, inputs = force.shape
    rows = response.reshape(lines, blocks * width, -1)
    columns, scale = _scaled_columns(_shared_columns(force, power))
    q, r = np.linalg.qr(columns)
    if np.linalg.svd(r, compute_uv=False).min() < DISTINGUISHED:
        raise DataError(
            "at some lines the forces cannot be distinguished from one another, or from a free decay",
            remedy="drive with random forces that differ, in as many blocks as there are forces",
        )
    # The denominator is 1 at the line itself, so the numerator there is the FRF.
    bend = np.tile(power[..., 1], (1, blocks))[..., None] ** np.arange(1, poles + 1)
    with_powers = rows.transpose(0, 2, 1)[..., None] * bend[:, None]
    by_poles = _denominators(q, rows, with_powers)
    explained = rows + np.einsum("lomp,lop->lmo", with_powers, by_poles)
    by_shared = np.linalg.solve(r, q.conj().transpose(0, 2, 1) @ explained)
    left = explained - columns @ by_shared
    free = blocks * width - columns.shape[2] - poles
    terms = power.shape[2]
    found = by_shared[:, : inputs * terms : terms] / scale[:, : inputs * terms : terms, None]
    return found.transpose(2, 1, 0), (np.sum(np.abs(left) ** 2, axis=1) / free).T


def _shared_columns(force: Complex128, power: NDArray[np.float64]) -> Complex128:
    """(lines, rows, columns) what all responses have: each force and each block's transient, times the polynomials."""
    lines, blocks, width, _ = force.shape
    by_force = force[..., None] * power[:, None, :, None, :]
    transient = np.zeros((lines, blocks, width, blocks, power.shape[2]), complex)
    transient[:, np.arange(blocks), :, np.arange(blocks)] = power
    flat = (lines, blocks * width, -1)
    return np.concatenate([by_force.reshape(flat), transient.reshape(flat)], axis=2)


def _denominators(q: Complex128, rows: Complex128, with_powers: Complex128) -> Complex128:
    """(lines, outputs, poles) coefficients of each response's denominator, from what no shared column (`q`) explains.

    Where the polynomials alone explain a response, its denominator is not determined, and is 1.
    """
    lines, outputs, rows_each, poles = with_powers.shape
    if not poles:
        return np.zeros((lines, outputs, 0), complex)
    own, scale = _scaled_columns(-with_powers)
    all_rows = np.concatenate([rows.transpose(0, 2, 1)[..., None], own], axis=3)
    columns = all_rows.transpose(0, 2, 1, 3).reshape(lines, rows_each, -1)
    columns = columns - q @ (q.conj().transpose(0, 2, 1) @ columns)
    left_over = columns.reshape(lines, rows_each, outputs, 1 + poles).transpose(0, 2, 1, 3)
    u, s, vh = np.linalg.svd(left_over[..., 1:], full_matrices=False)
    inverse = np.where(s > DISTINGUISHED, 1 / np.where(s > DISTINGUISHED, s, 1), 0)
    along = (u.conj().swapaxes(2, 3) @ left_over[..., :1]) * inverse[..., None]
    return (vh.conj().swapaxes(2, 3) @ along)[..., 0] / scale


def _scaled_columns(columns: Complex128) -> tuple[Complex128, NDArray[np.float64]]:
    """Columns of length 1, and the lengths that they had; a column of zeros stays."""
    length = np.linalg.norm(columns, axis=-2)
    length = np.where(length > 0, length, 1)
    return columns / length[..., None, :], length


def frf_of_one_force(
    force: Complex128, response: Complex128, estimator: Estimator = "H1"
) -> tuple[Complex128, NDArray[np.float64]]:
    """FRF by H1, H2 or Hv of one random force, and the noise variance of the responses, line by line.

    About a line the force is to the response as the response is to the force: their ratio is a quotient of polynomials,
    and what was ringing at the record's start is smooth over a few lines in either. Taken as the response of the
    response, the force may hold noise, the response none: that is H2. Hv is the geometric mean of both, as of averaged
    powers (Rocklin, Crowley, Vold, "A comparison of H1, H2, and Hv frequency response functions", IMAC 3 (1985)).

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
    half = min(_HALF_WIDTH, (force.shape[2] - 1) // 2)
    h1, variance = local_polynomial_frf(force, response, half_width=half)
    inverse = [local_polynomial_frf(response[:, o : o + 1], force, half_width=half)[0][0] for o in range(len(h1))]
    h2: Complex128 = np.reciprocal(np.stack(inverse))
    return h2 if estimator == "H2" else _h2_over_h1(h1, h2), variance


def _h2_over_h1(h1: Complex128, h2: Complex128) -> Complex128:
    middle: Complex128 = h1 * np.sqrt(h2 / h1)
    return middle
