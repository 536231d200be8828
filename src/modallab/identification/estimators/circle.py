"""Circle fit: natural frequency, damping and modal constant from the mobility's circle about one resonance.

Near a mode with viscous damping Y = A / (2 zeta omega_0 + j (omega^2 - omega_0^2) / omega) + B is a circle of diameter
|A| / (2 zeta omega_0); the angle on it gives tan(theta / 2) = (omega^2 - omega_0^2) / (2 zeta omega_0 omega), linear in
the unknowns.
Source: Kennedy and Pancu (1947); Ewins, "Modal Testing", 2nd ed. (2000), section 4.3.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError, IdentificationError
from modallab.core.frf import Frf
from modallab.identification.estimator import Estimator
from modallab.identification.start.half_power import HalfPowerPeak, half_power_pole, pole_of_mode, poles_of_peaks

FALL = 0.4
"""A circle is fitted to the lines about a peak down to this share of its amplitude: well past half-power."""
LEAST_LINES = 5


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
    _require_lines(frequency_hz, mobility)
    centre, radius = _circle_fit(mobility)
    misfit = float(np.std(np.abs(mobility - centre)) / radius)
    if not np.isfinite(misfit) or misfit > 0.2:
        raise IdentificationError(
            f"the lines are off their circle by {100 * misfit:.0f} % of its radius",
            remedy="take lines about one resonance that stands alone",
        )
    omega, turn = 2 * np.pi * frequency_hz, np.unwrap(np.angle(mobility - centre))
    zero = _zero_angle(omega, turn)
    rate, square, _ = _straight_line_fit(omega, turn - zero)
    if square <= 0:
        raise IdentificationError("no resonance on the circle", remedy="take lines on both sides of the peak")
    resonance = float(np.sqrt(square))
    constant = complex(2 * radius * np.exp(1j * zero) * rate)
    return CircleFit(resonance / (2 * np.pi), rate / (2 * resonance), constant, misfit)


def _require_lines(frequency_hz: NDArray[np.float64], mobility: NDArray[np.complex128]) -> None:
    if frequency_hz.ndim != 1 or frequency_hz.size < 5 or mobility.shape != frequency_hz.shape:
        raise DataError(
            f"{frequency_hz.shape} frequencies and {mobility.shape} values make no circle",
            remedy="give at least 5 lines about one resonance, of one FRF",
        )
    ascending = np.all(np.diff(frequency_hz) > 0) and frequency_hz[0] > 0
    if not (ascending and np.isfinite(mobility).all() and np.any(mobility.imag != 0)):
        raise DataError("the lines do not ascend from above 0 Hz, or have NaN or no phase", remedy="correct the FRF")


def _zero_angle(omega: NDArray[np.float64], turn: NDArray[np.float64]) -> float:
    """The angle on the circle at resonance. A first guess is where the circle is run through fastest."""
    # Imported here: other estimators need none of it.
    from scipy import optimize

    place = int(np.argmax(np.abs(np.diff(turn) / np.diff(omega))))
    guess = float(turn[place] + turn[place + 1]) / 2
    best = optimize.minimize_scalar(
        lambda z: _straight_line_fit(omega, turn - z)[2],
        bounds=(guess - 1, guess + 1),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return float(best.x)


def _straight_line_fit(omega: NDArray[np.float64], turn: NDArray[np.float64]) -> tuple[float, float, float]:
    """2 zeta omega_0, omega_0^2 and the misfit of omega = -2 zeta omega_0 tan(turn / 2) + omega_0^2 / omega.

    Weighted by cos^2, since the tangent spreads the noise far from the resonance.
    """
    half = np.clip(turn / 2, -1.5, 1.5)
    weight = np.cos(half) ** 2
    basis = np.stack([-np.tan(half), omega[0] ** 2 / omega], axis=1) * weight[:, None]
    solution = np.linalg.lstsq(basis, omega * weight, rcond=None)[0]
    left = basis @ solution - omega * weight
    return float(solution[0]), float(solution[1]) * float(omega[0]) ** 2, float(left @ left)


def _circle_fit(values: NDArray[np.complex128]) -> tuple[complex, float]:
    """Centre and radius: |v|^2 = 2 Re(conj(c) v) + r^2 - |c|^2, linear in c and the constant."""
    basis = np.stack([2 * values.real, 2 * values.imag, np.ones(values.size)], axis=1)
    scale = float(np.abs(values).max())
    x, y, rest = np.linalg.lstsq(basis / [scale, scale, 1], np.abs(values) ** 2 / scale, rcond=None)[0]
    centre = complex(x, y)
    return centre, float(np.sqrt(max(rest * scale + abs(centre) ** 2, 0)))


def _circle_pole(mobility: Frf, peak: HalfPowerPeak) -> complex:
    """From the FRF that is loudest at the peak; where its lines stand on no circle, what half-power reads."""
    size = np.abs(mobility.values[..., peak.line])
    o, i = np.unravel_index(int(np.argmax(size)), size.shape)
    values = mobility.values[o, i]
    lines = _lines_about_peak(np.abs(values), peak.line)
    try:
        found = circle_fit(mobility.frequency_hz[lines], values[lines])
    except (DataError, IdentificationError):
        return half_power_pole(mobility, peak)
    f = mobility.frequency_hz
    beside = f[max(peak.line - 1, 0)] <= found.frequency_hz <= f[min(peak.line + 1, f.size - 1)]
    # Lines far apart make a circle of noise and neighbours, whose resonance lies anywhere but at the peak.
    sound = beside and found.damping_ratio > 0
    return pole_of_mode(found.frequency_hz, found.damping_ratio) if sound else half_power_pole(mobility, peak)


def _lines_about_peak(amplitude: NDArray[np.float64], line: int) -> slice:
    """The lines about a peak: down to a share of it, five at least."""
    low = high = line
    limit = FALL * amplitude[line]
    while low > 0 and (amplitude[low - 1] > limit or line - low < LEAST_LINES // 2):
        if amplitude[low - 1] > amplitude[low] and line - low >= LEAST_LINES // 2:
            break
        low -= 1
    while high < amplitude.size - 1 and (amplitude[high + 1] > limit or high - line < LEAST_LINES // 2):
        if amplitude[high + 1] > amplitude[high] and high - line >= LEAST_LINES // 2:
            break
        high += 1
    return slice(low, high + 1)


ESTIMATOR = Estimator(
    name="circle",
    title="circle fit",
    called="the circle fit",
    description="a circle through the lines about each peak",
    source='Kennedy and Pancu (1947); Ewins, "Modal Testing", 2nd ed. (2000), section 4.3',
    grid="any",
    refined=False,
    poles=lambda frf: poles_of_peaks(frf, _circle_pole),
)
