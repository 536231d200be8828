"""Modes above the band as a sum of powers of s, which is what a modal model holds of them."""

import numpy as np
from numpy.typing import NDArray

POWERS = tuple(range(17))
"""Powers of s of the receptance; the odd ones for the modes' damping. So a mode 5 % above is met to 0.3 %, one at
the edge to 5 %, but for the last lines."""
LINES = 400
"""Frequencies at which they are made to stand for a mode."""


def fold_into_residuals(
    poles: NDArray[np.complex128], constants: NDArray[np.complex128], band_hz: tuple[float, float]
) -> NDArray[np.float64]:
    """Coefficients (powers, outputs, inputs) of the powers that stand in the band for modes above it.

    Args:
        poles: (modes,) rad/s, of positive imaginary part.
        constants: (modes, outputs, inputs) modal constants.
        band_hz: the band.
    """
    factors = np.array([_residual_factors(complex(pole), band_hz) for pole in poles]).reshape(
        len(poles), len(POWERS), 2
    )
    residues = constants / (2j * poles.imag[:, None, None])
    parts = np.stack([residues.real, residues.imag], axis=1)
    return np.asarray(np.einsum("rpk,rkoi->poi", factors, parts), np.float64)


def _residual_factors(pole: complex, band_hz: tuple[float, float]) -> NDArray[np.float64]:
    """Factors (powers, 2) of the powers of s that stand in the band for a pole pair of residue 1, and of residue j.

    By least squares over the band, relative to the mode: the Taylor series of a pole just above the band hardly
    converges, and absolute errors would be those of its resonance alone, wherever in the band they act.
    """
    omega = np.linspace(max(band_hz[0], 1e-3 * band_hz[1]), band_hz[1], LINES) * 2 * np.pi
    s, top = 1j * omega, float(omega[-1])
    up, down = 1 / (s - pole), 1 / (s - pole.conjugate())
    weight = 1 / np.abs(up - down)
    columns = weight[:, None] * np.stack([(s / top) ** power for power in POWERS], axis=1)
    values = weight[:, None] * np.stack([up + down, 1j * (up - down)], axis=1)
    factors = np.linalg.lstsq(np.vstack([columns.real, columns.imag]), np.vstack([values.real, values.imag]))[0]
    return np.asarray(factors / top ** np.array(POWERS, dtype=np.float64)[:, None], np.float64)
