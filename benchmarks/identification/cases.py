"""The cases of the comparison: structures whose modes are known, and FRFs of them in white noise.

Every case is a function of a seed. FRFs are mobilities with white complex noise of 1 % of each one's RMS over the band.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BETA = np.array(
    [1.875104068711961, 4.694091132974175, 7.854757438237613, 10.995540734875467, 14.13716839104647]
    + [(2 * n - 1) * np.pi / 2 for n in range(6, 13)]
)
"""Roots of cos x cosh x = -1; beyond the fifth the asymptote is right to 12 digits."""
NOISE = 0.01


@dataclass(frozen=True)
class Structure:
    """Modes: frequency (Hz), damping ratio, shapes (modes, outputs) at unit modal mass, and the driven outputs."""

    frequency_hz: NDArray[np.float64]
    zeta: NDArray[np.float64]
    phi: NDArray[np.float64]
    drive: tuple[int, ...]


@dataclass(frozen=True)
class Case:
    """A measured mobility (outputs, inputs, lines), its structure, and the noise's sigma (outputs, inputs)."""

    frequency_hz: NDArray[np.float64]
    mobility: NDArray[np.complex128]
    truth: Structure
    sigma: NDArray[np.float64]


def cantilever_shapes(n_modes: int, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shapes (modes, points) of a clamped-free beam at x in 0 to 1, of unit mean square over the beam."""
    b = BETA[:n_modes, None]
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    # cosh - ratio sinh, without the difference of two huge numbers.
    grow = 0.5 * ((1 - ratio) * np.exp(b * x) + (1 + ratio) * np.exp(-b * x))
    return grow - np.cos(b * x) + ratio * np.sin(b * x)


def mobility(structure: Structure, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Mobility (outputs, inputs, lines): sum of phi phi s / (s^2 + 2 zeta w s + w^2)."""
    s = 2j * np.pi * frequency_hz
    w = 2 * np.pi * structure.frequency_hz[:, None]
    modes = s / (s**2 + 2 * structure.zeta[:, None] * w * s + w**2)
    outer = structure.phi[:, :, None] * structure.phi[:, None, list(structure.drive)]
    return (outer.reshape(len(w), -1).T @ modes).reshape(*outer.shape[1:], frequency_hz.size)


def in_noise(structure: Structure, frequency_hz: NDArray[np.float64], seed: int, level: float = NOISE) -> Case:
    clean = mobility(structure, frequency_hz)
    sigma = level * np.sqrt(np.mean(np.abs(clean) ** 2, axis=-1))
    rng = np.random.default_rng(seed)
    white = rng.standard_normal((2, *clean.shape))
    return Case(frequency_hz, clean + sigma[..., None] * (white[0] + 1j * white[1]) / np.sqrt(2), structure, sigma)


def case_a(seed: int, level: float = NOISE) -> Case:
    """A cantilever driven at its tip: 10 x 1 x 4096 lines, 0 to 1900 Hz, 9 modes from 8 Hz, zeta 0.5 %."""
    x = np.arange(1, 11) / 10
    structure = Structure(8 * (BETA[:9] / BETA[0]) ** 2, np.full(9, 0.005), cantilever_shapes(9, x), (9,))
    return in_noise(structure, np.linspace(0, 1900, 4096), seed, level)


def case_b(seed: int, level: float = NOISE) -> Case:
    """A plate-like structure: 200 outputs x 3 references x 8192 lines, 25 modes."""
    rng = np.random.default_rng(12345)
    frequency = 40.0 * np.arange(1, 26) ** 0.9 * rng.uniform(0.985, 1.015, 25)
    structure = Structure(frequency, rng.uniform(0.002, 0.01, 25), rng.standard_normal((25, 200)), (0, 70, 140))
    return in_noise(structure, np.linspace(0, 800, 8192), seed, level)


def close_modes(seed: int, level: float = NOISE) -> Case:
    """500 and 502.5 Hz with 0.5 % and 0.1 % damping: 10 x 1 x 4096 lines to 1000 Hz."""
    shapes = cantilever_shapes(6, np.arange(1, 11) / 10)[[2, 3]]
    structure = Structure(np.array([500.0, 502.5]), np.array([0.005, 0.001]), shapes, (9,))
    return in_noise(structure, np.linspace(0, 1000, 4096), seed, level)


def pure_noise(seed: int) -> Case:
    """No structure at all, as large as case A in outputs and lines."""
    rng = np.random.default_rng(seed)
    white = rng.standard_normal((2, 10, 1, 4096))
    nothing = Structure(np.zeros(0), np.zeros(0), np.zeros((0, 10)), (9,))
    return Case(np.linspace(0, 1900, 4096), (white[0] + 1j * white[1]) / np.sqrt(2), nothing, np.ones((10, 1)))


CASES = {"A": case_a, "B": case_b, "close": close_modes, "noise": pure_noise}
NO_TRUTH = ("paper", "noise")
"""Cases without a bound: the truth changes with the seed, or there is none."""
