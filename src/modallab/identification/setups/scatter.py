"""The common poles of points that scatter: a random effect of each set-up, whose size the data say.

Points that were measured in one set-up share the shift of the poles in that set-up. Points whose shifts agree in
all modes within their sigmas are taken for one set-up, so that a shift counts once and not at every point.
Sources: DerSimonian and Laird, "Meta-analysis in clinical trials", Controlled Clinical Trials 7 (1986); Paule and
Mandel, "Consensus values and weighting factors", J. Res. NBS 87 (1982).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from modallab.core.arrays import Real
from modallab.core.errors import IdentificationError

ALIKE = 4.0
"""Sigmas of the sum of squares by which two points of one set-up may differ."""
OFF = 5.0
"""Scatters from the middle by which a set-up is off."""
OFF_LEAST = 1e-4
"""Relative, of the frequency; less is not said."""
ROUNDS = 60


@dataclass(frozen=True, eq=False, slots=True)
class CommonPoles:
    """What points agree on.

    Attributes:
        value: (modes, 2) omega and zeta.
        sigma: (modes, 2) of them, scatter between set-ups included.
        between: (modes, 2) standard deviation between set-ups.
        setup: (points,) which set-up each point is of.
        shift: (set-ups,) relative shift of the frequencies, all modes together.
    """

    value: Real
    sigma: Real
    between: Real
    setup: NDArray[np.int64]
    shift: Real


def common_poles(values: Real, variance: Real) -> CommonPoles:
    """The mean poles of points that scatter, with sigmas that hold whatever their set-ups did.

    Args:
        values: (points, modes, 2) omega and zeta.
        variance: (points, modes, 2) of each point alone, inf where it does not see a mode.

    Raises:
        IdentificationError: a mode that no point sees: it has no mean.
    """
    unseen = np.any(np.isinf(variance).all(axis=0), axis=1)
    if np.any(unseen):
        listed = ", ".join(f"{omega / (2 * np.pi):.5g}" for omega in values[:, unseen, 0].mean(axis=0))
        raise IdentificationError(f"no point knows the mode at {listed} Hz by itself", remedy="narrow the band")
    setup = same_setup(values[..., 0], variance[..., 0])
    n = int(setup.max()) + 1
    weight = np.where(np.isfinite(variance), 1 / variance, 0.0)
    total = np.stack([weight[setup == c].sum(axis=0) for c in range(n)])
    summed = np.stack([(weight * values)[setup == c].sum(axis=0) for c in range(n)])
    seen = total > 0
    mean = np.where(seen, summed / np.where(seen, total, 1), 0.0)
    own = np.where(seen, 1 / np.where(seen, total, 1), np.inf)
    modes = values.shape[1]
    found = np.array([[random_effects(mean[:, r, p], own[:, r, p]) for p in range(2)] for r in range(modes)])
    value, sigma, between = np.moveaxis(found, -1, 0)
    relative = np.where(seen[..., 0], mean[..., 0] / value[:, 0] - 1, 0.0)
    w = np.where(seen[..., 0], value[:, 0] ** 2 / (own[..., 0] + between[:, 0] ** 2 + 1e-300), 0.0)
    return CommonPoles(value, sigma, between, setup, np.sum(w * relative, axis=1) / np.maximum(w.sum(axis=1), 1e-300))


def random_effects(values: Real, variance: Real) -> tuple[float, float, float]:
    """Mean of set-ups, its sigma and the standard deviation between them; of an infinite variance all but one may be.

    The sigma is that of a normal number whose 95 % interval is as wide as Student's: few set-ups hardly say how much
    they scatter.
    """
    known = np.isfinite(variance)
    x, v = values[known], variance[known]
    between = _variance_between_setups(x, v)
    w = 1 / (v + between)
    mean = float(np.sum(w * x) / np.sum(w))
    if x.size == 1:
        return mean, float(np.sqrt(1 / w.sum())), 0.0
    wider = float(stdtrit(x.size - 1, 0.975) / ndtri(0.975)) if between > 0 else 1.0
    return mean, wider * float(np.sqrt(1 / w.sum())), float(np.sqrt(between))


def _variance_between_setups(x: Real, v: Real) -> float:
    """The variance between set-ups by which the weighted sum of squares is what it should be (Paule and Mandel)."""

    def excess(between: float) -> float:
        w = 1 / (v + between)
        return float(np.sum(w * (x - np.sum(w * x) / np.sum(w)) ** 2)) - (x.size - 1)

    if x.size < 2 or excess(0.0) <= 0:
        return 0.0
    low, high = 0.0, float(np.var(x)) * x.size + 1e-300
    for _ in range(ROUNDS):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return (low + high) / 2


def same_setup(values: Real, variance: Real) -> NDArray[np.int64]:
    """(points,) number of each one's set-up: points share one where values (points, modes) agree within variances."""
    setup = np.full(len(values), -1, np.int64)
    held: list[tuple[Real, Real]] = []
    for k, (x, v) in enumerate(zip(values, variance, strict=True)):
        distance = [_sigmas_apart(x, v, *one) for one in held]
        if distance and min(distance) < ALIKE:
            setup[k] = c = int(np.argmin(distance))
            held[c] = _merge_two(x, v, *held[c])
        else:
            setup[k] = len(held)
            held.append((x, v))
    return setup


def _sigmas_apart(x: Real, v: Real, y: Real, u: Real) -> float:
    """How many sigmas of its own the sum of squares of their differences is too large."""
    both = np.isfinite(v) & np.isfinite(u)
    n = int(np.count_nonzero(both))
    if n == 0:
        return 0.0
    squares = float(np.sum((x[both] - y[both]) ** 2 / (v[both] + u[both])))
    return (squares - n) / float(np.sqrt(2 * n))


def _merge_two(x: Real, v: Real, y: Real, u: Real) -> tuple[Real, Real]:
    a, b = np.where(np.isfinite(v), 1 / v, 0.0), np.where(np.isfinite(u), 1 / u, 0.0)
    total = a + b
    seen = total > 0
    safe = np.where(seen, total, 1.0)
    return np.where(seen, (a * x + b * y) / safe, x), np.where(seen, 1 / safe, np.inf)


def setups_with_other_frequencies(common: CommonPoles) -> NDArray[np.int64]:
    """Set-ups whose frequencies differ from those of the others by more than these scatter."""
    if common.shift.size < 4:
        return np.zeros(0, np.int64)
    away = common.shift - np.median(common.shift)
    usual = 1.4826 * float(np.median(np.abs(away)))
    return np.flatnonzero(np.abs(away) > max(OFF * usual, OFF_LEAST))
