"""Bending modes of a prismatic Euler-Bernoulli cantilever on a root rotational spring.

The shape is W = A cos(b xi) + B sin(b xi) + C cosh(b xi) + D sinh(b xi), xi = x/L, with W(0) = 0, EI W''(0) = k W'(0)
and a free tip. With kappa = k L / EI the frequency equation is
kappa (1 + cos b cosh b) = b (sin b cosh b - cos b sinh b), which follows from these four conditions (Blevins, Formulas
for Natural Frequency and Mode Shape, table 8-1, has its limits kappa = 0 and infinity).
All expressions are divided by cosh b, or have their growing and falling exponentials taken apart, so that no mode is
too high for double precision.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from math import inf, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.plan import BLOCK_S
from modallab.core.rig import Beam, Tolerance

HALVINGS = 56


@dataclass(frozen=True, slots=True)
class CantileverBeam:
    """A uniform beam in SI units.

    Attributes:
        length_m: L.
        bending_stiffness_n_m2: EI.
        mass_kg_m: rho A.
        kappa: root rotational spring in EI/L; inf is a rigid clamp.
    """

    length_m: float
    bending_stiffness_n_m2: float
    mass_kg_m: float
    kappa: float

    @property
    def root_stiffness_nm_rad(self) -> float:
        """The root spring in N m/rad."""
        return self.kappa * self.bending_stiffness_n_m2 / self.length_m

    @property
    def _rate(self) -> float:
        return float(np.sqrt(self.bending_stiffness_n_m2 / self.mass_kg_m)) / self.length_m**2

    def omega(self, count: int) -> Real:
        """Natural frequencies of the first `count` modes in rad/s, (count,)."""
        return wave_numbers(count, self.kappa) ** 2 * self._rate

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        # Mode n has b between (n - 1) pi and n pi, so only one mode is in doubt.
        limit = float(np.sqrt(omega / self._rate))
        sure = int(limit / pi)
        return sure + bool(_roots(sure + 1, sure + 1, self.kappa)[0] < limit)

    @property
    def total_mass_kg(self) -> float:
        """Of the beam."""
        return self.mass_kg_m * self.length_m

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Mode shapes, or their derivative of an order along x, at unit modal mass in kg^-1/2, (points, count)."""
        unit = unit_shapes(x_m / self.length_m, wave_numbers(count, self.kappa), self.kappa, order)
        return unit / np.sqrt(self.mass_kg_m * self.length_m) / self.length_m**order

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,): what the shear at the root carries in free vibration."""
        shear = self.bending_stiffness_n_m2 * self.shapes(np.zeros(1), count, 3)[0]
        return -shear / self.omega(count) ** 2

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`: bending of the beam and turn of the root, (points,).

        Args:
            x_m: where it is seen, (points,).
            force_x_m: where the load stands.
            seen: 0 the displacement, 1 the slope.
            put: 0 a force, 1 a moment.
        """
        near = np.minimum(x_m, force_x_m)
        if seen == put == 0:
            bend = near**2 * (3 * np.maximum(x_m, force_x_m) - near) / (6 * self.bending_stiffness_n_m2)
        else:
            # The integral over both moment diagrams, of which at least one is constant.
            arm = {(0, 1): x_m * near - near**2 / 2, (1, 0): force_x_m * near - near**2 / 2, (1, 1): near}
            bend = arm[seen, put] / self.bending_stiffness_n_m2
        if self.kappa == inf:
            return bend
        return bend + x_m ** (1 - seen) * force_x_m ** (1 - put) / self.root_stiffness_nm_rad


def wave_numbers(count: int, kappa: float) -> Real:
    """Roots b = beta L of the frequency equation for kappa > 0, ascending, (count,)."""
    return _roots(1, count, kappa).copy()


@lru_cache(maxsize=256)
def _roots(first: int, last: int, kappa: float) -> Real:
    """Of modes `first` to `last`: one root between (n - 1) pi, where the equation has the sign of cos b, and n pi."""
    # Dividing by kappa or by b keeps the terms of order one for a soft as for a stiff root.
    soft, stiff = (kappa, 1.0) if kappa < 1 else (1.0, 0.0 if kappa == inf else 1.0 / kappa)
    n = np.arange(first, last + 1)
    low, high, sign = (n - 1) * pi, n * pi, np.where(n % 2, 1.0, -1.0)
    # Halved down to rounding, all at once: a solver of SciPy's would take every process longer to import.
    for _ in range(HALVINGS):
        b = (low + high) / 2
        before = sign * (soft * (_sech(b) + np.cos(b)) - stiff * b * (np.sin(b) - np.cos(b) * np.tanh(b))) > 0
        low, high = np.where(before, b, low), np.where(before, high, b)
    return (low + high) / 2


def _sech(b: Any) -> Any:
    # cosh itself overflows from mode 226 on.
    return 2 * np.exp(-b) / (1 + np.exp(-2 * b))


def unit_shapes(xi: Real, b: Real, kappa: float, order: int = 0) -> Real:
    """Shapes with integral of W^2 over xi of one, positive at the tip, or a derivative of them, (points, modes)."""
    s, c, t, sech = np.sin(b), np.cos(b), np.tanh(b), _sech(b)
    d = s - c * t
    growing = (1 + (s + c) * np.exp(-b)) / (1 + np.exp(-2 * b))
    falling = (s - c - c * t - sech + s * t) / 2
    z = np.multiply.outer(xi, b)
    sine, cosine = _turned(c + sech + s * t, d, order)
    shape = sine * np.sin(z) - cosine * np.cos(z) + growing * np.exp(z - b) + (-1) ** order * falling * np.exp(-z)
    tip = (c + sech + s * t) * s - d * c + growing + falling * np.exp(-b)
    return shape * np.sign(tip) / np.sqrt(_norm(tip, d, c + sech, b, kappa)) * b**order


def _turned(sine: Real, cosine: Real, order: int) -> tuple[Real, Real]:
    # The derivative of a sin z - d cos z is d sin z + a cos z.
    for _ in range(order):
        sine, cosine = cosine, -sine
    return sine, cosine


def _norm(tip: Real, d: Real, turn: Real, b: Real, kappa: float) -> Real:
    # Integral of W^2 = (W(1)^2 + W'(0) W''(0) / b^4) / 4. The root's two forms are equal at a root of the frequency
    # equation; each is free of cancellation on its own side.
    root = 4 * kappa * turn**2 / b**2 if kappa < 1 else 4 * d**2 / kappa
    return (tip**2 + root) / 4


ZETA_RANGE = (0.003, 0.01)
MAX_PPM = 20.0
OFF_LINE = 0.1
_TRIES = 1000


class RandomStream(IntEnum):
    """Independent streams of one seed."""

    BEAM = 1
    DAMPING = 2
    CLOCK = 3
    NOISE = 4
    HITS = 5
    HUM = 6
    FLOOR = 7
    KNOCKS = 8
    EFFECT = 9
    GAP = 10
    FLAWS = 11
    TOLERANCES = 12
    SCATTER = 13


def random_generator(seed: int, stream: RandomStream, *place: int) -> np.random.Generator:
    """The random numbers of one stream, which depend on nothing drawn elsewhere."""
    return np.random.default_rng([seed, stream, *place])


@dataclass(frozen=True, slots=True)
class TrueBeam:
    """The beam as it is, within the tolerances of what the rig file says."""

    youngs_modulus_pa: float
    thickness_m: float
    density_kg_m3: float
    beam: CantileverBeam


def draw_beam(seed: int, nominal: Beam, tolerance: Tolerance, kappa: float) -> TrueBeam:
    """Draw E, thickness and density (normal, one relative standard deviation each).

    A first mode on a line of the 1.024 s block would hide what the block's resolution does to its reading, so the
    first draw at least 0.1 line away from every line is taken; where a tolerance of almost nothing leaves the beam
    on a line, the draw farthest from it.
    """
    rng = random_generator(seed, RandomStream.BEAM)
    sigma = [tolerance.youngs_modulus, tolerance.thickness, tolerance.density]
    best, best_off = None, -1.0
    for _ in range(_TRIES):
        true = _true_beam(nominal, kappa, 1 + np.clip(rng.standard_normal(3), -3, 3) * sigma)
        lines = float(true.beam.omega(1)[0]) / (2 * pi) * BLOCK_S
        off = abs(lines - round(lines))
        if off > best_off:
            best, best_off = true, off
        if off >= OFF_LINE:
            break
    assert best is not None
    return best


def _true_beam(nominal: Beam, kappa: float, factors: NDArray[np.float64]) -> TrueBeam:
    modulus = nominal.youngs_modulus_pa * float(factors[0])
    thickness = nominal.thickness_m * float(factors[1])
    density = nominal.density_kg_m3 * float(factors[2])
    area = nominal.width_m * thickness
    beam = CantileverBeam(nominal.length_m, modulus * area * thickness**2 / 12, density * area, kappa)
    return TrueBeam(modulus, thickness, density, beam)


def draw_damping(seed: int, count: int, given: tuple[float, ...]) -> NDArray[np.float64]:
    """Damping ratios of the first `count` modes: uniform in 0.3 to 1 %, or as given, (count,)."""
    if len(given) == 1:
        return np.full(count, given[0])
    drawn = random_generator(seed, RandomStream.DAMPING).uniform(*ZETA_RANGE, size=count)
    first = np.array(given[:count], dtype=np.float64)
    drawn[: len(first)] = first
    return drawn


def draw_clock(seed: int) -> float:
    """How fast the generator's clock runs, relative to the converter's: up to 20e-6 either way."""
    return float(random_generator(seed, RandomStream.CLOCK).uniform(-MAX_PPM, MAX_PPM)) * 1e-6
