"""Circle fit: natural frequency, damping and modal constant from the mobility's circle about one resonance.

Near a mode with viscous damping Y = A / (2 zeta omega_0 + j (omega^2 - omega_0^2) / omega) + B is a circle of diameter
|A| / (2 zeta omega_0); the angle on it gives tan(theta / 2) = (omega^2 - omega_0^2) / (2 zeta omega_0 omega), linear in
the unknowns.
Source: Kennedy and Pancu (1947); Ewins, "Modal Testing", 2nd ed. (2000), section 4.3.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from modallab.core.errors import DataError, IdentificationError


@dataclass(frozen=True, slots=True)
class CircleFit:
    """A mode by its circle: frequency (Hz), zeta, modal constant (kg^-1), and the misfit as a share of the radius."""

    frequency_hz: float
    damping_ratio: float
    constant: complex
    misfit: float


def circle_fit(frequency_hz: NDArray[np.float64], mobility: NDArray[np.complex128]) -> CircleFit:
    """One mode from the lines about its resonance.

    Args:
        frequency_hz: (lines,) above 0, ascending, at least 5 that span a good part of the circle.
        mobility: (lines,) one FRF.

    Raises:
        DataError: too few lines, wrong shapes, NaN.
        IdentificationError: the lines stand on no circle.
    """
    if frequency_hz.ndim != 1 or frequency_hz.size < 5 or mobility.shape != frequency_hz.shape:
        raise DataError(
            f"{frequency_hz.shape} frequencies and {mobility.shape} values make no circle",
            remedy="give at least 5 lines about one resonance, of one FRF",
        )
    ascending = np.all(np.diff(frequency_hz) > 0) and frequency_hz[0] > 0
    if not (ascending and np.isfinite(mobility).all() and np.any(mobility.imag != 0)):
        raise DataError("the lines do not ascend from above 0 Hz, or have NaN or no phase", remedy="mend the FRF")
    centre, radius = _circle(mobility)
    misfit = float(np.std(np.abs(mobility - centre)) / radius)
    if not np.isfinite(misfit) or misfit > 0.2:
        raise IdentificationError(
            f"the lines stand off their circle by {100 * misfit:.0f} % of its radius",
            remedy="take lines about one resonance that stands alone",
        )
    omega = 2 * np.pi * frequency_hz
    # Where the circle is run through fastest lies the resonance: the first guess of where the angle is zero.
    turn = np.unwrap(np.angle(mobility - centre))
    speed = np.abs(np.diff(turn) / np.diff(omega))
    place = int(np.argmax(speed))
    zero = float(turn[place] + turn[place + 1]) / 2
    best = optimize.minimize_scalar(
        lambda z: _line(omega, turn - z)[2], bounds=(zero - 1, zero + 1), method="bounded", options={"xatol": 1e-12}
    )
    zero = float(best.x)
    rate, square, _ = _line(omega, turn - zero)
    if square <= 0:
        raise IdentificationError("no resonance on the circle", remedy="take lines on both sides of the peak")
    resonance = float(np.sqrt(square))
    constant = complex(2 * radius * np.exp(1j * zero) * rate)
    return CircleFit(resonance / (2 * np.pi), rate / (2 * resonance), constant, misfit)


def _line(omega: NDArray[np.float64], turn: NDArray[np.float64]) -> tuple[float, float, float]:
    """2 zeta omega_0, omega_0^2 and the misfit of omega = -2 zeta omega_0 tan(turn / 2) + omega_0^2 / omega.

    Weighted by cos^2, since the tangent spreads the noise far from the resonance.
    """
    half = np.clip(turn / 2, -1.5, 1.5)
    weight = np.cos(half) ** 2
    basis = np.stack([-np.tan(half), omega[0] ** 2 / omega], axis=1) * weight[:, None]
    solution = np.linalg.lstsq(basis, omega * weight, rcond=None)[0]
    left = basis @ solution - omega * weight
    return float(solution[0]), float(solution[1]) * float(omega[0]) ** 2, float(left @ left)


def _circle(values: NDArray[np.complex128]) -> tuple[complex, float]:
    """Centre and radius: |v|^2 = 2 Re(conj(c) v) + r^2 - |c|^2, linear in c and the constant."""
    basis = np.stack([2 * values.real, 2 * values.imag, np.ones(values.size)], axis=1)
    scale = float(np.abs(values).max())
    x, y, rest = np.linalg.lstsq(basis / [scale, scale, 1], np.abs(values) ** 2 / scale, rcond=None)[0]
    centre = complex(x, y)
    return centre, float(np.sqrt(max(rest * scale + abs(centre) ** 2, 0)))
