"""The law of a missing force: which few terms of a library say how it follows the motion at its place.

The force is regressed on the displacement times 1, s and s^2 (a spring, a damper, a mass) and times the dynamic
stiffness of a mass on a spring, whose resonance is searched. Terms are kept by the Bayesian information criterion
(Schwarz, Ann. Stat. 6, 1978, 461), over all small subsets: sparse regression over a library (Brunton, Proctor and Kutz,
PNAS 113, 2016, 3932), here with complex data and their noise.
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.unknown.missing_force import ForceEstimate

SUBSETS = (("k",), ("m",), ("c",), ("k", "c"), ("k", "m"), ("hung",), ("k", "hung"), ("c", "hung"))
"""Terms that are tried together."""
RESONANCES = 120
"""Resonances tried between the first line and the last."""
FINER = 21
"""Those tried again between the neighbours of the best."""
WIDTH = 0.01
"""Damping ratio of a hung mass, so that no line lies on its pole."""
FORGIVEN = 0.02
"""Relative error of the force and of the motion: the twin beside it is right to first order only."""


@dataclass(frozen=True, slots=True)
class PointLawFit:
    """Terms of a law with their numbers.

    Attributes:
        x: the place, a share of the length.
        numbers: k in N/m, c in N s/m, m in kg, hung_m in kg, hung_hz in Hz.
        left: squares in noise units that stay once the force follows the law, those that no force takes away included.
        price: the same with the price of its numbers.
    """

    x: float
    numbers: dict[str, float]
    left: float
    price: float


def laws(missing: ForceEstimate) -> list[PointLawFit]:
    """The laws that the force at one place may follow, the likeliest first; those of negative damping left out."""
    s, w = missing.s, missing.motion
    sigma = np.hypot(missing.sigma, FORGIVEN * np.abs(missing.force))
    plain = {"k": w, "c": s * w, "m": s**2 * w}
    hz = np.geomspace(max(np.min(np.abs(s.imag)) / (2 * np.pi), 1.0), np.max(np.abs(s.imag)) / (2 * np.pi), RESONANCES)
    target = -missing.force / sigma
    found: list[PointLawFit] = []
    for terms in SUBSETS:
        best = _best_terms(
            [plain[t] / sigma for t in terms if t != "hung"], "hung" in terms, (s, w / sigma), hz, target
        )
        law = _law(missing, terms, best, len(target))
        if law is not None:
            found.append(law)
    return sorted(found, key=lambda law: law.price)


def _best_terms(
    columns: list[Complex], hung: bool, motion: tuple[Complex, Complex], hz: Real, target: Complex
) -> tuple[float, Real, float]:
    """What stays, the terms' numbers, and the resonance of the mass that hangs, if there is one."""
    if not hung:
        return (*_least_squares(columns, target), 0.0)
    s, w = motion

    def tried(at: Real) -> list[tuple[float, Real, float]]:
        return [(*_least_squares([*columns, _absorber(s, float(f)) * w], target), float(f)) for f in at]

    coarse = min(tried(hz), key=_residual)
    step = float(hz[1] / hz[0])
    # A light mass is felt within a percent of its resonance: a fit begun farther off does not find it.
    return min([coarse, *tried(np.geomspace(coarse[2] / step, coarse[2] * step, FINER))], key=_residual)


def _residual(solved: tuple[float, Real, float]) -> float:
    return solved[0]


def _absorber(s: Complex, hz: float) -> Complex:
    omega = 2 * np.pi * hz
    # Per kg of the mass that hangs.
    pull = omega**2 + 2 * WIDTH * omega * s
    return s**2 * pull / (s**2 + pull)


def _least_squares(columns: list[Complex], target: Complex) -> tuple[float, Real]:
    A = np.stack(columns, axis=1)
    real, y = np.concatenate([A.real, A.imag]), np.concatenate([target.real, target.imag])
    size = np.maximum(np.linalg.norm(real, axis=0), 1e-300)
    values = np.linalg.lstsq(real / size, y, rcond=1e-10)[0]
    return float(np.sum((y - real / size @ values) ** 2)), values / size


def _law(
    missing: ForceEstimate, terms: tuple[str, ...], best: tuple[float, Real, float], lines: int
) -> PointLawFit | None:
    cost, values, hz = best
    numbers = {"hung_m" if t == "hung" else t: float(v) for t, v in zip(terms, values, strict=True)}
    if numbers.get("c", 1.0) <= 0 or numbers.get("hung_m", 1.0) <= 0:
        return None
    if "hung" in terms:
        numbers["hung_hz"] = hz
    left = missing.left + cost
    return PointLawFit(missing.x, numbers, left, left + len(numbers) * float(np.log(2 * lines)))
