"""What is fitted: the twin's free numbers to the reduced data, in noise units, priors included.

The most probable numbers under Gaussian noise and Gaussian priors (Tarantola, Inverse Problem Theory, 2005). A relative
error of the model, `floor`, is added to the noise in quadrature, as a discrepancy of the model (Kennedy and O'Hagan, J.
R. Stat. Soc. B 63, 2001, 425), and lowered as the fit goes on.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.effect import RowsOfPlace, channels_of_place
from modallab.core.effects import Effect
from modallab.gap.conditioning.rows import Reduced, Rows
from modallab.gap.model.forward import forward
from modallab.gap.model.nuisances import Nuisances
from modallab.twin.bench import Twin
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effects import apply_effect, search_of

HELD_WEIGHT = 300.0
"""Weight that holds the beam, in deviations of its priors, per unit of the relative error that is forgiven."""
GENERATOR = 2e-5
"""Relative deviation of a generator's own frequency: quartz, some tens of parts in a million."""


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """Data and what is free.

    Attributes:
        data: the reduced campaign.
        free: the nuisances.
        candidates: effects whose numbers are free.
        floor: relative error of the model that is forgiven, for the first steps of a fit.
        drift_curve: share of a drift over the campaign, where it is known; see `Twin`.
        held: Young's modulus, thickness and density, in deviations of their priors, where a fit of a wrong model stays.
    """

    data: Reduced
    free: Nuisances
    candidates: tuple[CandidateEffect, ...] = ()
    floor: float = 0.0
    drift_curve: tuple[tuple[float, float], ...] = ()
    held: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def held_weight(self) -> float:
        """Weight that keeps the beam at `held`: while the model is wrong the beam must not be strained to it."""
        return HELD_WEIGHT * self.floor

    def priors(self, u: Real) -> tuple[float, Real, Real]:
        """Squares of the priors at u, half their slope and half their curvature, one entry a nuisance each."""
        own = u[: self.free.size]
        away = np.zeros(len(own))
        away[:3] = self.held_weight * (own[:3] - np.array(self.held))
        weight = np.ones(len(own))
        weight[:3] += self.held_weight**2
        slope = own.copy()
        slope[:3] += self.held_weight * away[:3]
        return float(own @ own + away @ away), slope, weight

    @property
    def size(self) -> int:
        """Free numbers in all."""
        return self.free.size + sum(len(c.slots) for c in self.candidates)

    @property
    def replaced(self) -> set[tuple[str, RowsOfPlace | None]]:
        """(tolerance, channel or None) that effects stand for: one quantity is one number."""
        own = [(tolerance, c) for c in self.candidates if (tolerance := search_of(c.effect).tolerance.replaces)]
        return {(tolerance, channels_of_place(c.place)) for tolerance, c in own}

    def effects(self, u: Real) -> list[Effect]:
        """The effects at u."""
        found, at = [], self.free.size
        for candidate in self.candidates:
            found.append(candidate.effect_at(u[at : at + len(candidate.slots)]))
            at += len(candidate.slots)
        return found

    def twin(self, u: Real) -> Twin:
        """The twin at u."""
        return self.twins(u[None])[0]

    def twins(self, u: Real) -> list[Twin]:
        """The twins at many u (twins, u)."""
        # An effect on the gain of a channel takes the place of its tolerance: two numbers for one gain never settle.
        held = [channels_of_place(c.place) for c in self.candidates if search_of(c.effect).tolerance.replaces_gain]
        bare = self.free.builds(self.free.without_gains(u[:, : self.free.size], held), self.replaced)
        return [self._with_effects(twin, own) for twin, own in zip(bare, u, strict=True)]

    def _with_effects(self, twin: Twin, u: Real) -> Twin:
        for effect in self.effects(u):
            twin = apply_effect(twin, effect, self.data.rig)
        return replace(twin, drift_curve=self.drift_curve) if self.drift_curve else twin

    def residual(self, u: Real) -> Real:
        """Everything measured less everything predicted, in noise units, real and imaginary parts in one row."""
        twin = self.twin(u)
        try:
            answers = forward(twin, self.data)
        except np.linalg.LinAlgError:
            # A beam that has buckled has no motion about its rest.
            answers = [np.full_like(rows.y, np.nan) for rows in all_rows(self.data)]
        return self.residual_of(twin, answers)

    def residual_of(self, twin: Twin, answers: Sequence[Complex]) -> Real:
        """The same of a twin whose answers are known."""
        parts = [
            with_relative_noise(rows, self.floor).in_noise_units(rows.y - y).ravel()
            for rows, y in zip(all_rows(self.data), answers, strict=True)
        ]
        values = np.concatenate(parts)
        clock = _clock(self.data, twin)
        real = np.concatenate([values.real, values.imag, clock])
        return np.where(np.isfinite(real), real, 1e6)


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Where a fit ended.

    Attributes:
        problem: what was fitted.
        u: (u,) the free numbers.
        cost: sum of the squares of residuals and of priors.
        residual: (residuals,) in noise units, 0 where not used.
        normal: (u, u) curvature, priors included.
    """

    problem: Problem
    u: Real
    cost: float
    residual: Real
    normal: Real

    @property
    def gap(self) -> float:
        """Rms of what is left, in noise units; 1 is the floor."""
        used = self.residual[self.residual != 0]
        return float(np.sqrt(np.mean(used**2))) if len(used) else 0.0

    @property
    def effects(self) -> list[Effect]:
        """The effects found."""
        return self.problem.effects(self.u)


def cost_of(fit: Fit) -> float:
    """What the best of several fits has least of."""
    return fit.cost


def cost_with_price(fit: Fit) -> float:
    """Cost of a fit with the price of its effects' numbers (Schwarz, Ann. Stat. 6, 1978, 461)."""
    numbers = sum(len(c.slots) for c in fit.problem.candidates)
    return fit.cost + numbers * float(np.log(max(np.count_nonzero(fit.residual), 1)))


def fit_at(problem: Problem, u: Real, normal: Real | None = None) -> Fit:
    """These numbers as a fit of a problem; its curvature is that of priors alone where none is given."""
    r = problem.residual(u)
    return Fit(problem, u, float(r @ r + problem.priors(u)[0]), r, np.eye(len(u)) if normal is None else normal)


def all_rows(data: Reduced) -> list[Rows]:
    """The rows of the data, in the order `forward` answers."""
    return [*(d.rows for d in data.impacts), *([data.sines.rows] if data.sines is not None else [])]


def row_frequencies_hz(data: Reduced) -> list[Real]:
    """(rows,) frequency of each row in Hz, in the order of `all_rows`; negative where a line is a conjugate's."""
    found = [d.source.lines / (d.source.n * d.source.dt) for d in data.impacts]
    if data.sines is not None:
        found.append((data.sines.source.lines / (data.sines.source.n * data.sines.source.dt)).ravel())
    return found


def with_relative_noise(rows: Rows, floor: float) -> Rows:
    """Rows whose noise is at least a share of the response itself."""
    if not floor:
        return rows
    largest = np.maximum(np.abs(rows.y), 0.3 * np.sqrt(np.mean(np.abs(rows.y) ** 2, axis=0)))
    return replace(rows, sigma=np.hypot(rows.sigma, floor * largest), common=np.zeros_like(rows.common))


def _clock(data: Reduced, twin: Twin) -> Real:
    if data.sines is None:
        return np.zeros(0)
    # Far beyond any doubt either way; a bound keeps it from outweighing all other evidence.
    z = (data.sines.ratio - 1 / (1 + twin.clock)) / max(data.sines.ratio_sigma, GENERATOR)
    return np.array([np.clip(z, -1e4, 1e4)])
