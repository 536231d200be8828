"""Gauss-Newton of the twin's free numbers on the reduced data, in noise units, priors included."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.candidates import Candidate
from modallab.gap.forward import forward
from modallab.gap.nuisances import Nuisances
from modallab.gap.reduce import Reduced, Rows
from modallab.gap.sensitivity import Tangent, smooth_in
from modallab.schema.effects import Effect
from modallab.twin.bench import Twin
from modallab.twin.effects import apply

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

FAITH = 300.0
"""Further weight of the priors of the beam per unit of the relative error that is forgiven."""
GENERATOR = 2e-5
"""Relative deviation of a generator's own frequency: quartz, some tens of parts in a million."""
STEP = 1e-4
"""Step of the numerical derivative, in deviations of the prior or in coordinates of an effect."""


@dataclass(frozen=True, eq=False, slots=True)
class Problem:
    """Data and what is free.

    Attributes:
        data: the reduced campaign.
        free: the nuisances.
        candidates: effects whose numbers are free.
        floor: relative error of the model that is forgiven, for the first steps of a fit.
        course: course of a drift, where it is known; see `Twin`.
    """

    data: Reduced
    free: Nuisances
    candidates: tuple[Candidate, ...] = ()
    floor: float = 0.0
    course: tuple[tuple[float, float], ...] = ()

    @property
    def trust(self) -> Array:
        """(nuisances,) weight of each prior: while the model is wrong the beam must not be bent to it."""
        weights = np.ones(self.free.size)
        weights[:3] += FAITH * self.floor
        return weights

    @property
    def size(self) -> int:
        """Free numbers in all."""
        return self.free.size + sum(len(c.slots) for c in self.candidates)

    def effects(self, u: Array) -> list[Effect]:
        """The effects at u."""
        found, at = [], self.free.size
        for candidate in self.candidates:
            found.append(candidate.at(u[at : at + len(candidate.slots)]))
            at += len(candidate.slots)
        return found

    def twin(self, u: Array) -> Twin:
        """The twin at u."""
        # An effect on the gain of a channel takes the place of its tolerance: two numbers for one gain never settle.
        held = [c.place[0][1] for c in self.candidates if c.effect == "gain_error"]
        twin = self.free.build(self.free.without_gains(u[: self.free.size], held))
        for effect in self.effects(u):
            twin = apply(twin, effect, self.data.rig)
        return replace(twin, course=self.course) if self.course else twin

    def residual(self, u: Array) -> Array:
        """Everything measured less everything predicted, in noise units, real and imaginary parts in one row."""
        twin = self.twin(u)
        parts = [
            softened(rows, self.floor).whiten(rows.y - y).ravel()
            for rows, y in zip(all_rows(self.data), forward(twin, self.data), strict=True)
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
        u: the free numbers.
        cost: squares of residuals and of priors.
        residual: in noise units.
        normal: (u, u) curvature, priors included.
    """

    problem: Problem
    u: Array
    cost: float
    residual: Array
    normal: Array

    @property
    def gap(self) -> float:
        """Rms of what is left, in noise units; 1 is the floor."""
        used = self.residual[self.residual != 0]
        return float(np.sqrt(np.mean(used**2))) if len(used) else 0.0

    @property
    def effects(self) -> list[Effect]:
        """The effects found."""
        return self.problem.effects(self.u)


def all_rows(data: Reduced) -> list[Rows]:
    """The rows of the data, in the order `forward` answers."""
    return [*(d.rows for d in data.impacts), *([data.sines.rows] if data.sines is not None else [])]


def all_hz(data: Reduced) -> list[Array]:
    """(rows,) frequency of each row in Hz, in the order of `all_rows`; negative where a line is a conjugate's."""
    found = [d.source.lines / (d.source.n * d.source.dt) for d in data.impacts]
    if data.sines is not None:
        found.append((data.sines.source.lines / (data.sines.source.n * data.sines.source.dt)).ravel())
    return found


def softened(rows: Rows, floor: float) -> Rows:
    """Rows whose noise is at least a share of the response itself."""
    if not floor:
        return rows
    largest = np.maximum(np.abs(rows.y), 0.3 * np.sqrt(np.mean(np.abs(rows.y) ** 2, axis=0)))
    return replace(rows, sigma=np.hypot(rows.sigma, floor * largest), common=np.zeros_like(rows.common))


def _clock(data: Reduced, twin: Twin) -> Array:
    if data.sines is None:
        return np.zeros(0)
    # Far beyond any doubt either way; a bound keeps it from outweighing all other evidence.
    z = (data.sines.ratio - 1 / (1 + twin.clock)) / max(data.sines.ratio_sigma, GENERATOR)
    return np.array([np.clip(z, -1e4, 1e4)])


def minimise(problem: Problem, u: Array, iterations: int = 8, tolerance: float = 1e-4) -> Fit:
    """Levenberg-Marquardt from u.

    Args:
        problem: what to fit.
        u: where to begin.
        iterations: most steps.
        tolerance: relative fall of the cost at which to stop.
    """
    r = problem.residual(u)
    n = problem.free.size
    trust = problem.trust**2
    cost = float(r @ r + trust @ u[:n] ** 2)
    damping = 1e-4
    normal = np.eye(len(u))
    for _ in range(iterations):
        J = jacobian(problem, u, r)
        normal, gradient = J.T @ J, J.T @ r
        normal[np.arange(n), np.arange(n)] += trust
        gradient[:n] += trust * u[:n]
        u_next, r_next, cost_next, damping = _step(problem, u, cost, normal, gradient, damping)
        fall = cost - cost_next
        if fall > 0:
            u, r, cost = u_next, r_next, cost_next
        if fall < tolerance * cost + 1e-2:
            break
    return Fit(problem, u, cost, r, normal)


def jacobian(problem: Problem, u: Array, r: Array) -> Array:
    """(residuals, u): through poles and residues where the beam, its places or gains move, else by differences."""
    J = np.zeros((len(r), len(u)))
    here = problem.twin(u)
    moved = u + STEP * np.eye(len(u))
    twins = [problem.twin(v) for v in moved]
    smooth = [k for k, twin in enumerate(twins) if smooth_in(here, twin)]
    if smooth:
        J[:, smooth] = _columns(problem, here, [twins[k] for k in smooth], len(r)) / STEP
    for k in set(range(len(u))) - set(smooth):
        J[:, k] = (problem.residual(moved[k]) - r) / STEP
    return J


def _columns(problem: Problem, here: Twin, twins: list[Twin], size: int) -> Array:
    changes = Tangent(here, problem.data).changes(twins)
    weights = [softened(rows, problem.floor) for rows in all_rows(problem.data)]
    values = np.concatenate(
        [w.whiten(-y).reshape(len(twins), -1) for w, y in zip(weights, changes, strict=True)], axis=1
    )
    # What the clock says of the sines does not depend on the beam.
    columns = np.zeros((size, len(twins)))
    n = values.shape[1]
    columns[:n], columns[n : 2 * n] = values.real.T, values.imag.T
    return np.where(np.isfinite(columns), columns, 0.0)


def _step(
    problem: Problem, u: Array, cost: float, normal: Array, gradient: Array, damping: float
) -> tuple[Array, Array, float, float]:
    n, trust = problem.free.size, problem.trust**2
    scale = np.maximum(np.diag(normal), 1e-9)
    u_next, r_next, cost_next = u, np.zeros(0), cost
    while damping < 1e7:
        step = -np.linalg.solve(normal + damping * np.diag(scale), gradient)
        u_next = u + np.clip(step, -4, 4)
        r_next = problem.residual(u_next)
        cost_next = float(r_next @ r_next + trust @ u_next[:n] ** 2)
        if cost_next < cost:
            return u_next, r_next, cost_next, max(damping / 10, 1e-9)
        damping *= 10
    return u, r_next, cost, damping


def extend(fit: Fit, candidates: tuple[Candidate, ...], values: Array) -> tuple[Problem, Array]:
    """The fit's problem with other candidates, and where to begin."""
    problem = replace(fit.problem, candidates=candidates)
    return problem, np.concatenate([fit.u[: fit.problem.free.size], values])
