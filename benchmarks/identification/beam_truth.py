"""Natural frequencies of a prismatic cantilever with rotary inertia and without shear, in closed form (Rayleigh beam).

EI w'''' + rho A w_tt - rho I w_ttxx = 0, clamped at 0; at the free end no moment, and no shear, which is
E w''' + rho omega^2 w' = 0.
"""

import numpy as np
from cases import BETA
from numpy.typing import NDArray
from scipy.optimize import brentq


def rayleigh_hz(
    n_modes: int, length_m: float, thickness_m: float, youngs_modulus_pa: float, density_kg_m3: float
) -> NDArray[np.float64]:
    """(modes,) natural frequencies in Hz of a rectangular section; the width cancels."""
    gyration2 = thickness_m**2 / 12
    ratio = density_kg_m3 / youngs_modulus_pa
    slender = (BETA[:n_modes] / length_m) ** 2 * np.sqrt(gyration2 / ratio)
    # Rotary inertia lowers each frequency by far less than half the way to its neighbour.
    bounds = [(0.88 * w, 1.02 * w) for w in slender]
    roots = [brentq(_free_end, *b, args=(length_m, gyration2, ratio), xtol=1e-12, rtol=1e-14) for b in bounds]
    return np.array(roots) / (2 * np.pi)


def _free_end(omega: float, length: float, gyration2: float, ratio: float) -> float:
    """Determinant of the conditions at the free end, divided by its growth, cosh^2 - sinh^2 taken out by hand."""
    rotary = ratio * omega**2
    middle = np.sqrt(rotary**2 / 4 + rotary / gyration2)
    a, b = np.sqrt(middle + rotary / 2), np.sqrt(middle - rotary / 2)
    cos, sin = np.cos(a * length), np.sin(a * length)
    ch = np.cosh(b * length)
    return float(2 * a**2 * b**2 / ch + (a**4 + b**4) * cos - a * b * rotary * np.tanh(b * length) * sin)
