"""The static curve that one channel's records follow over what the twin predicts of it.

Families of one or two numbers by nonlinear least squares on the samples (Bard, Nonlinear Parameter Estimation, 1974),
the best by the Bayesian information criterion (Schwarz, Ann. Stat. 6, 1978, 461). Its numbers are then brought to their
end by Gauss-Newton steps on the lines that a diagnosis weighs: a hit holds content above them that no twin predicts
sample by sample.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from modallab.core.arrays import Real
from modallab.gap.unknown.volts import ChannelOperator
from modallab.twin.learned.row_curve import apply_curve

FAMILIES = (
    ("tanh_v",),
    ("tanh_share",),
    ("knee_v",),
    ("knee_share",),
    ("knee_v", "power"),
    ("cubic",),
    ("square",),
    ("square", "cubic"),
)
EVERY = 2
"""One sample of so many counts: neighbours say the same."""
STEPS = 4
STEP = 1e-3
NEAR = (0.02, 10.0)
"""Levels that a saturation may have, over the largest number of the records."""
WIDEST = 0.5
"""Largest step of a number, as its logarithm or in what it does at the peak."""


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """A static curve of a channel, by the numbers of its family.

    Attributes:
        family: names of its numbers.
        q: what they are in the coordinates of a fit.
        peak: V to which coefficients refer.
    """

    family: tuple[str, ...]
    q: tuple[float, ...]
    peak: float

    @property
    def law(self) -> dict[str, float]:
        """Its numbers, SI."""
        scale = {"square": 1 / self.peak, "cubic": 1 / self.peak**2}
        return {
            n: x * scale[n] if n in scale else float(np.exp(np.clip(x, -30, 30)))
            for n, x in zip(self.family, self.q, strict=True)
        }

    def made(self, channel: ChannelOperator) -> dict[str, Real]:
        """Record -> (n,) V that it makes of what the twin predicts."""
        law = self.law
        return {name: apply_curve(u, law) for name, u in channel.expected.items()}

    def moved(self, q: Real) -> "ForceCurve":
        """The same with other numbers."""
        return ForceCurve(self.family, tuple(q.tolist()), self.peak)


def curve_of(channel: ChannelOperator, names: Collection[str]) -> ForceCurve:
    """The curve that describes a channel's records of these names best, sample by sample."""
    pairs = [(channel.expected[n], channel.read[n][::EVERY]) for n in names]
    peak = max(float(np.max(np.abs(u))) for u, _ in pairs)
    v = np.concatenate([read for _, read in pairs])

    def fitted(family: tuple[str, ...]) -> tuple[float, ForceCurve]:
        begin = ForceCurve(family, tuple(_first_value(n, peak) for n in family), peak)

        def off(q: Real) -> Real:
            law = begin.moved(q).law
            return np.concatenate([apply_curve(u, law)[::EVERY] for u, _ in pairs]) - v

        least, most = np.array([_range(n, peak) for n in family]).T
        q = least_squares(off, np.array(begin.q), bounds=(least, most), x_scale=0.1, max_nfev=30).x
        rms = float(np.sqrt(np.mean(off(q) ** 2)))
        return len(v) * np.log(rms) + 0.5 * len(family) * np.log(len(v)), begin.moved(q)

    return min((fitted(family) for family in FAMILIES), key=lambda f: f[0])[1]


def _first_value(name: str, peak: float) -> float:
    return {"power": float(np.log(2.0)), "square": 0.0, "cubic": 0.0, "tanh_share": 0.4, "knee_share": 0.4}.get(
        name, float(np.log(1.5 * peak))
    )


def _range(name: str, peak: float) -> tuple[float, float]:
    """Between which a number stays, as in `Curve.q`: a level that no record comes near cannot be seen."""
    if name in ("square", "cubic"):
        return -np.inf, np.inf
    least, most = {"power": (0.5, 50.0), "tanh_share": NEAR, "knee_share": NEAR}.get(
        name, (NEAR[0] * peak, NEAR[1] * peak)
    )
    return float(np.log(least)), float(np.log(most))


def refined(
    curve: ForceCurve, residual: Callable[[ForceCurve], Real]
) -> tuple[ForceCurve, dict[str, tuple[float, float]]]:
    """The curve whose residual on the lines is least, and 95 % intervals of its numbers.

    Args:
        curve: where to begin.
        residual: of a curve, in noise units.
    """
    q: Real = np.array(curve.q)
    r = residual(curve)
    J = np.zeros((len(r), len(q)))
    for _ in range(STEPS):
        for k in range(len(q)):
            moved = q.copy()
            moved[k] += STEP
            J[:, k] = (residual(curve.moved(moved)) - r) / STEP
        step = np.clip(-np.linalg.lstsq(J, r, rcond=1e-9)[0], -WIDEST, WIDEST).astype(np.float64)
        there = residual(curve.moved(q + step))
        if there @ there >= r @ r:
            break
        q, r = (q + step).astype(np.float64), there
    spread: Real = 1.96 * np.sqrt(
        np.diag(np.linalg.pinv(J.T @ J)) * max(float(r @ r) / max(np.count_nonzero(r), 1), 1.0)
    )
    low, high = curve.moved(q - spread).law, curve.moved(q + spread).law
    return curve.moved(q), {n: (min(low[n], high[n]), max(low[n], high[n])) for n in curve.family}
