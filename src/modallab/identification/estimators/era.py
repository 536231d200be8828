"""Eigensystem realization algorithm (ERA): poles from the impulse responses of evenly spaced FRFs."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frf
from modallab.core.errors import DataError, IdentificationError
from modallab.core.frf import Frf
from modallab.identification.estimator import Estimator, ModelOrder
from modallab.identification.realization import block_hankel, state_poles
from modallab.identification.start.stabilisation import OrderPoles

STATES = 120
"""Default order, where the lines can carry it."""


def era(frf: Frf, max_order: int, rows: int | None = None) -> list[OrderPoles]:
    """Poles at every even order up to `max_order`, to be read like those of pLSCF.

    Best on data with hardly any noise, and where the ring-down ends within 1 / (line spacing): what wraps around is not
    that of a pole.

    Args:
        frf: lines at whole multiples of their spacing; what is missing below the first line counts as zero.
        max_order: number of states, two for each mode.
        rows: block rows of the Hankel matrix; by default enough for `max_order` states, at least 40.

    Raises:
        DataError: no FRF, or lines that are no multiples of their spacing.
        IdentificationError: the impulse response is too short for the order.
    """
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=True)
    if max_order < 2:
        raise IdentificationError(f"order {max_order} holds no mode", remedy="ask for at least 2 states")
    f = frf.frequency_hz
    spacing = float(f[-1] - f[0]) / (f.size - 1)
    place = np.round(f / spacing).astype(int)
    if np.abs(f / spacing - place).max() > 0.01:
        raise DataError(
            f"the lines from {f[0]:g} Hz on are no multiples of their spacing of {spacing:g} Hz",
            remedy="give lines k df of a DFT",
        )
    n_out, n_in, _ = frf.values.shape
    padded = np.zeros((n_out, n_in, int(place[-1]) + 1), complex)
    padded[..., place] = frf.values
    dt = 1 / (2 * spacing * int(place[-1]))
    markov = np.fft.irfft(padded, 2 * int(place[-1]), axis=-1)
    height = rows if rows is not None else max(40, 2 * max_order // n_out + 2)
    width = min(markov.shape[-1] // 2 - height, max(4 * max_order // n_in, 80))
    if width * n_in < max_order or height * n_out < max_order:
        raise IdentificationError(
            f"{markov.shape[-1]} samples of impulse response cannot carry {max_order} states",
            remedy="lower the order, or give more lines",
        )
    return _poles_of_realizations(markov, height, width, max_order, dt, frf)


def _poles_of_realizations(
    markov: NDArray[np.float64], height: int, width: int, max_order: int, dt: float, frf: Frf
) -> list[OrderPoles]:
    """Poles of the realizations of rising order, all from one singular value decomposition."""
    u, values, vh = np.linalg.svd(block_hankel(markov, height, width, 1), full_matrices=False)
    moved = u[:, :max_order].T @ block_hankel(markov, height, width, 2) @ vh[:max_order].T
    enough = int(np.sum(values > 1e-12 * values[0]))
    found: list[OrderPoles] = []
    for order in range(2, min(max_order, enough) + 1, 2):
        root = np.sqrt(values[:order])
        poles = state_poles(moved[:order, :order] / np.outer(root, root), dt) + frf.damping_shift
        keep = np.abs(poles) > 2 * np.pi * frf.frequency_hz[0]
        keep &= (poles.imag > 0) & (poles.imag < 2 * np.pi * frf.frequency_hz[-1])
        kept = np.asarray(poles[keep], np.complex128)
        found.append(OrderPoles(order, kept[np.argsort(kept.imag)]))
    return found


ESTIMATOR = Estimator(
    name="era",
    title="eigensystem realization algorithm (ERA)",
    called="ERA",
    description="eigensystem realization of the impulse responses: the poles that hold over rising orders",
    source="Juang and Pappa, J. Guidance 8 (1985)",
    grid="even",
    refined=True,
    order=ModelOrder(
        meaning="number of states",
        lowest=2,
        highest=400,
        default="120, at most a quarter of the lines",
        suits=lambda frf: max(2, min(STATES, frf.frequency_hz.size // 4)),
        modes=lambda _: 0.5,
        solve=era,
    ),
)
