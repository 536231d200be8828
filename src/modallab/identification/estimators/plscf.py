"""Poly-reference least-squares complex frequency-domain estimator (pLSCF): poles of FRFs at rising orders.

Right matrix fraction H_o(z) = B_o(z) A(z)^-1 per output, z = exp(s dt), solved by reduced normal equations.
Source: Peeters, Van der Auweraer, Guillaume, Leuridan, "The PolyMAX frequency-domain method", Shock and Vibration
11 (2004); the Toeplitz structure after Guillaume et al., "A poly-reference implementation of the least-squares complex
frequency-domain estimator", IMAC 21 (2003).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg

from modallab.core.array_checks import check_frf
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.identification.estimator import Estimator, ModelOrder
from modallab.identification.start.stabilisation import OrderPoles

COLUMNS, LEAST_ORDER = 120, 60
"""Default order: as many columns of the polynomial as this, shared among the inputs, but no lower an order than this.
Every input sees the same modes: however many inputs share the columns, a mode far below the highest line shows only
from some order on.
"""
EVERY_ORDER_UP_TO, LEAST_ORDERS = 120, 20
"""Columns up to which every order is solved: the cost grows with their cube, what one more order shows does not. Of
fewer orders a pole that holds has too few to show it."""


def plscf(frf: Frf, max_order: int, min_order: int = 2) -> list[OrderPoles]:
    """Poles at orders from `min_order` to `max_order`: at every one, or at every second or third if they are large.

    Args:
        frf: any quantity; the numerator absorbs the power of s. A damping shift is taken off the poles again.
        max_order: order of the matrix polynomial; it holds up to order * inputs / 2 modes.
        min_order: lowest order to report.

    Raises:
        DataError: the FRF is not finite, its lines do not ascend, or it has no phase.
        IdentificationError: too few lines for the order.
    """
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=False)
    most = highest_order(frf)
    if max_order > most:
        n_out, n_in, n_lines = frf.values.shape
        raise IdentificationError(
            f"{n_lines} lines of {n_out} outputs and {n_in} inputs cannot carry order {max_order}",
            remedy=f"use an order of at most {most}, widen the band, or give FRFs with finer lines",
        )
    step = 1 / (2 * _circle_frequency(frf.frequency_hz))
    reduced = _reduced_normal_matrix(frf, max_order, step)
    stride = min(-(-max_order * frf.values.shape[1] // EVERY_ORDER_UP_TO), max(1, max_order // LEAST_ORDERS))
    return [_solve_order(reduced, n, frf, step) for n in range(min_order, max_order + 1, stride)]


def highest_order(frf: Frf) -> int:
    """The highest order for which there are twice as many equations as coefficients of the polynomials.

    Each line gives two of an input and output. An input has order * inputs coefficients in the denominator, and
    order + 1 in the numerator of each output.
    """
    n_out, n_in, n_lines = frf.values.shape
    return int(n_out * (n_lines - 1) / (n_in + n_out))


def _matrix_is_regular(frf: Frf) -> int:
    return max(2, min(max(COLUMNS // frf.values.shape[1], LEAST_ORDER), highest_order(frf)))


def _reduced_normal_matrix(frf: Frf, order: int, step: float) -> NDArray[np.float64]:
    """Sum over outputs of T - S^T R^-1 S, (order + 1) * inputs square; block j belongs to z^j."""
    n_in = frf.values.shape[1]
    lag = np.arange(order + 1)[None, :] - np.arange(order + 1)[:, None] + order
    energy = np.zeros((n_in, n_in, frf.frequency_hz.size), complex)
    moments = np.empty((len(frf.values), n_in, 2 * order + 1))
    # Output by output, which the processor's cache holds, and not all at once.
    for o, measured in enumerate(frf.values):
        values = measured / np.sqrt(np.mean(measured.real**2 + measured.imag**2))
        energy += values.conj()[:, None] * values
        moments[o] = _sums_of_powers(values, frf.frequency_hz, 1 / (2 * step), order)
    r = _sums_of_powers(np.ones((1, frf.frequency_hz.size)), frf.frequency_hz, 1 / (2 * step), order)[0, lag]
    s = -moments[..., lag]
    t = _sums_of_powers(energy, frf.frequency_hz, 1 / (2 * step), order)[..., lag]
    # (outputs, inputs, j, l) -> columns ordered by power, then input.
    s_matrix = s.transpose(0, 2, 3, 1).reshape(s.shape[0], order + 1, (order + 1) * n_in)
    t_matrix = t.transpose(2, 0, 3, 1).reshape((order + 1) * n_in, (order + 1) * n_in)
    factor = _cholesky_factor(r)
    whitened = linalg.solve_triangular(factor, s_matrix.transpose(1, 0, 2).reshape(order + 1, -1), lower=True)
    whitened = whitened.reshape(-1, (order + 1) * n_in)
    return t_matrix - whitened.T @ whitened


def _cholesky_factor(r: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cholesky factor of the numerators' matrix. Lines on a short arc of the circle leave it singular to rounding."""
    for share in (1e-14, 1e-13, 1e-12, 1e-11):
        try:
            return np.linalg.cholesky(r + share * r[0, 0] * np.eye(len(r)))
        except np.linalg.LinAlgError:
            continue
    raise IdentificationError(
        f"the lines cannot carry a polynomial of order {len(r) - 1}", remedy="widen the band, or lower the order"
    )


def _multiples_of_spacing(frequency_hz: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """The lines as whole multiples of their spacing, or None if they are not, or begin far above it."""
    spacing = (float(frequency_hz[-1]) - float(frequency_hz[0])) / (frequency_hz.size - 1)
    exact = frequency_hz / spacing
    whole = np.round(exact).astype(np.int64)
    return whole if np.abs(exact - whole).max() < 1e-6 and whole[-1] <= 4 * whole.size else None


def _circle_frequency(frequency_hz: NDArray[np.float64]) -> float:
    """The frequency that stands at z = -1: the highest, or where that makes an FFT slow, one a little above."""
    places = _multiples_of_spacing(frequency_hz)
    top = float(frequency_hz[-1])
    return top if places is None else top * fft.next_fast_len(int(places[-1]), real=True) / int(places[-1])


def _sums_of_powers(
    values: NDArray[Any], frequency_hz: NDArray[np.float64], circle_hz: float, order: int
) -> NDArray[np.float64]:
    """Re sum over lines of values z^m, z = exp(j pi f / circle), for m = -order to order: (..., 2 order + 1).

    Lines at whole multiples of their spacing stand on the circle like those of a DFT.
    """
    places, last = _multiples_of_spacing(frequency_hz), 0
    if places is not None:
        last = round(circle_hz * int(places[-1]) / float(frequency_hz[-1]))
    if places is not None and last > order:
        padded = np.zeros((*values.shape[:-1], last + 1), complex)
        padded[..., places] = values
        # An inverse real FFT counts every line but the two at its ends twice.
        padded[..., [0, -1]] *= 2
        moments = last * fft.irfft(padded, 2 * last)
        return np.take(moments, np.arange(-order, order + 1), axis=-1, mode="wrap")
    powers = np.exp(1j * np.pi * np.outer(frequency_hz / circle_hz, np.arange(-order, order + 1)))
    return np.real(np.asarray(values @ powers, np.complex128))


def _solve_coefficients(head: NDArray[np.float64], tail: NDArray[np.float64]) -> NDArray[np.float64]:
    """The solution, the smallest where noise-free data have fewer modes and rounding leaves a pivot of zero."""
    try:
        return np.asarray(np.linalg.solve(head, tail), np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(head, tail, rcond=None)[0], np.float64)


def _solve_order(reduced: NDArray[np.float64], order: int, frf: Frf, step: float) -> OrderPoles:
    n_in = frf.values.shape[1]
    size = order * n_in
    # The highest coefficient is the identity: with z = exp(+s dt) this leaves most computational poles outside the
    # unit circle (negative damping), where they are known by their sign.
    head, tail = reduced[:size, :size], reduced[:size, size : size + n_in]
    alpha = -_solve_coefficients(head, tail)
    companion = np.zeros((size, size))
    companion[: size - n_in, n_in:] = np.eye(size - n_in)
    companion[size - n_in :] = -alpha.reshape(order, n_in, n_in).transpose(1, 0, 2).reshape(n_in, size)
    z = np.linalg.eigvals(companion)
    with np.errstate(divide="ignore"):
        poles = np.log(z.astype(np.complex128)) / step + frf.damping_shift
    top = 2 * np.pi * frf.frequency_hz[-1]
    keep = (poles.imag > 2 * np.pi * frf.frequency_hz[0]) & (poles.imag < top) & np.isfinite(poles)
    kept = np.asarray(poles[keep], np.complex128)
    return OrderPoles(order, kept[np.argsort(kept.imag)])


ESTIMATOR = Estimator(
    name="plscf",
    title="least-squares complex frequency-domain estimator (pLSCF)",
    called="pLSCF",
    description="poly-reference LSCF: the poles that hold over rising orders",
    source="Peeters, Van der Auweraer, Guillaume, Leuridan, Shock and Vibration 11 (2004)",
    grid="any",
    refined=True,
    order=ModelOrder(
        meaning="order",
        lowest=2,
        highest=400,
        default="120 shared among the inputs, 60 at least, at most what the lines of all FRFs can carry",
        suits=_matrix_is_regular,
        modes=lambda frf: frf.values.shape[1] / 2,
        solve=plscf,
    ),
)
