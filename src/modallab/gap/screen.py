"""A first look at every candidate: what its signature explains once all that was free before has adapted to it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.candidates import Candidate, Slot
from modallab.gap.fit import Problem, jacobian
from modallab.gap.prefit import start, starts
from modallab.twin.structure import solve

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

OUTLIER = 25.0
"""Square at which a residual stops counting when places to begin are compared."""
LARGE = 0.05
"""Relative misfit from which an effect is no small change of the fit so far."""


@dataclass(frozen=True, eq=False, slots=True)
class Begin:
    """A place to begin, and what is left there; after a small misfit once the rest has adapted to first order."""

    problem: Problem
    u: Array
    cost: float


class Screen:
    """Residuals with everything that was free before projected out."""

    def __init__(self, problem: Problem, u: Array, poles: Complex) -> None:
        """Screen around a fit.

        Args:
            problem: the fit so far on thinned data, its floor the misfit.
            u: its numbers.
            poles: of the ring-down.
        """
        self.problem, self.u, self.poles = problem, u, poles
        self.large = problem.floor > LARGE
        self.here = problem.residual(u)
        J = jacobian(problem, u, self.here)
        self.priors = problem.free.size
        whole = np.concatenate([J, np.eye(self.priors, len(u))])
        self.q = np.linalg.qr(whole + 0.0)[0]

    def begins(self, candidate: Candidate) -> tuple[Begin, ...]:
        """The best places for a candidate to begin, best first."""
        problem = replace(self.problem, candidates=(*self.problem.candidates, candidate))
        if self.large:
            return self._far(problem, candidate)
        tried = (Begin(problem, u, self.left(problem, u)) for u in self._near(problem, candidate))
        return (min(tried, key=lambda b: b.cost),)

    def left(self, problem: Problem, u: Array) -> float:
        """Squares that stay at u of a problem with one candidate more, large ones cut."""
        rest = self._project(problem.residual(u), u)
        return float(np.sum(np.minimum(rest**2, OUTLIER)))

    def _project(self, r: Array, u: Array) -> Array:
        whole = np.concatenate([r, u[: self.priors]])
        return whole - self.q @ (self.q.T @ whole)

    def _near(self, problem: Problem, candidate: Candidate) -> list[Array]:
        """Small changes: where there is a place, the size follows from the signature there."""
        slots = candidate.slots
        if candidate.effect == "local_damper":
            # The damping ratios have taken its work over: to first order nothing of it is left to see.
            return [_relieved(problem, np.concatenate([self.u, more])) for more in _grid(slots)]
        if len(slots) == 2 and slots[1].name == "x":
            return [self._sized(problem, slots, x) for x in slots[1].starts]
        return [np.concatenate([self.u, more]) for more in _grid(slots)]

    def _sized(self, problem: Problem, slots: tuple[Slot, ...], x: float) -> Array:
        size, place = slots
        small = min(size.starts)
        more = np.array([size.coordinate(small), place.coordinate(x)])
        u = np.concatenate([self.u, more])
        before = self._project(self.here, self.u)
        signature = self._project(problem.residual(u), u) - before
        times = float(-(signature @ before) / max(float(signature @ signature), 1e-300))
        value = float(np.clip(small * times, 0.03 * small, max(size.starts)))
        return np.concatenate([self.u, [size.coordinate(value), more[1]]])

    def _far(self, problem: Problem, candidate: Candidate) -> tuple[Begin, ...]:
        """Large changes: the whole grid at the fit so far, and at the beam that the poles of the ring-down tell of."""
        free, former = problem.free, self.u[self.priors :]
        begins: list[Array] = []
        nears = [self.u]
        if len(self.poles):
            # A large effect drags the fit so far off: the poles of the ring-down know the beam without it.
            nears.append(start(self.problem.candidates, former, free, self.poles).u)
            if candidate.effect in _MOVES_POLES:
                best = 3 if len(candidate.slots) > 1 else 1
                begins = [s.u for s in starts(problem.candidates, free, self.poles, best, former)]
        grid = _grid(candidate.slots)
        listed = [Begin(problem, u, _plain(problem, u)) for u in begins]
        for near in nears:
            tried = [v for more in grid for v in self._variants(problem, candidate, np.concatenate([near, more]))]
            listed.append(min((Begin(problem, u, _plain(problem, u)) for u in tried), key=lambda b: b.cost))
        return tuple(sorted(listed, key=lambda b: b.cost))

    def _variants(self, problem: Problem, candidate: Candidate, u: Array) -> list[Array]:
        if candidate.effect == "local_damper":
            return [_relieved(problem, u)]
        if candidate.effect == "thermal_drift" and len(self.poles):
            return [u, start(problem.candidates, u[self.priors :], problem.free, self.poles).u]
        return [u]


def _plain(problem: Problem, u: Array) -> float:
    """Squares at u as it is: far from the fit no first order says how the rest would adapt."""
    return float(np.sum(np.minimum(problem.residual(u) ** 2, OUTLIER)))


def _grid(slots: tuple[Slot, ...]) -> list[Array]:
    """Coordinates of all combinations of the slots' first values."""
    grids = np.meshgrid(*([s.coordinate(v) for v in s.starts] for s in slots), indexing="ij")
    return list(np.stack([g.ravel() for g in grids], axis=-1)) if slots else [np.zeros(0)]


def _relieved(problem: Problem, u: Array) -> Array:
    """The same with each damping ratio less what the damper now does: the fit so far had put it there."""
    free = problem.free
    structure = problem.twin(u).structure
    x, c = structure.dampers[-1]
    modes = solve(replace(structure, dampers=()))
    omega = np.abs(modes.poles[: free.modes])
    phi_squared = np.abs(modes.at(x)[0, : free.modes] ** 2 * 2 * omega)
    share = c * phi_squared / (2 * omega)
    zeta = np.maximum(structure.zeta[: free.modes] - share, 0.15 * structure.zeta[: free.modes])
    damping = free.rig.damping_ratio
    relieved = u.copy()
    relieved[3 : 3 + free.modes] = np.log(zeta / damping.guess) / np.log(damping.factor)
    return relieved


_MOVES_POLES = frozenset(
    {"clamp_rotation", "clamp_translation", "sensor_mass", "added_mass", "stiffness_loss", "ground_spring"}
    | {"local_damper", "thermal_drift", "clock_error"}
)
