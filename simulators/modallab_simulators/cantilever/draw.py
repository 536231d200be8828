"""What the seed draws: the true beam, its damping, the generator's clock; and the streams of random numbers."""

from dataclasses import dataclass
from enum import IntEnum
from math import pi

import numpy as np
from numpy.typing import NDArray

from modallab.core.plan import BLOCK_S
from modallab.core.rig import Beam, Tolerance
from modallab_simulators.cantilever.beam import CantileverBeam

ZETA_RANGE = (0.003, 0.01)
MAX_PPM = 20.0
OFF_LINE = 0.1
_TRIES = 1000


class Stream(IntEnum):
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


def generator(seed: int, stream: Stream, *place: int) -> np.random.Generator:
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
    rng = generator(seed, Stream.BEAM)
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
    drawn = generator(seed, Stream.DAMPING).uniform(*ZETA_RANGE, size=count)
    first = np.array(given[:count], dtype=np.float64)
    drawn[: len(first)] = first
    return drawn


def draw_clock(seed: int) -> float:
    """How fast the generator's clock runs, relative to the converter's: up to 20e-6 either way."""
    return float(generator(seed, Stream.CLOCK).uniform(-MAX_PPM, MAX_PPM)) * 1e-6
