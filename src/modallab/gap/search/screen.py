"""A first look at every candidate: what its signature explains once all that was free before has adapted to it.

What a number explains beside others is what it explains once both are projected off them (Frisch and Waugh,
Econometrica 1, 1933, 387; Lovell, J. Am. Stat. Assoc. 58, 1963, 993); priors are rows like data. Squares are cut at a
bound, so that a channel that is far off does not decide (truncated quadratic: Blake and Zisserman, Visual
Reconstruction, 1987; after Huber, Ann. Math. Stat. 35, 1964, 73).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.model.fit import Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.prefit import start, starts
from modallab.gap.search.lows import lows
from modallab.twin.candidate import Candidate, Slot
from modallab.twin.effects import model_of, search_of
from modallab.twin.modes import solve

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

OUTLIER = 25.0
"""Square at which a residual stops counting when places to begin are compared."""
LARGE = 0.05
"""Relative misfit from which an effect is no small change of the fit so far."""
SMALL = 0.01
"""Relative misfit up to which nothing is forgiven: the effect itself may be no larger."""
VALLEYS = 3
"""Places along the beam from which a fit begins."""
SIZES = 2
"""Sizes of a large effect from which a fit begins."""
FEWER = 4
"""Of so many first values of an effect one is tried at the second beam as well."""
CUT = 5.0
"""Times the rms at which a residual stops counting."""
TIMES = (0.03, 0.1, 0.16, 0.3, 1.0, 3.0, 8.0, 16.0, 32.0)
"""Sizes of an effect of one number, in those of its scale, from which an assembly may be relieved."""


@dataclass(frozen=True, eq=False, slots=True)
class Begin:
    """A place to begin, and what is left there; after a small misfit once the rest has adapted to first order."""

    problem: Problem
    u: Array
    cost: float


@dataclass(frozen=True, slots=True)
class _Scale:
    """How a number runs from no effect to the smallest of its first values, and on.

    Attributes:
        kind: small, plain, factor (none at another number than 0), or stiff (none at infinity).
        unit: the number at one.
        most: the largest it is worth to begin at, for stiff the smallest.
        none: the number at which there is no effect.
    """

    kind: str
    unit: float
    most: float
    none: float = 0.0

    @classmethod
    def of(cls, size: Slot) -> "_Scale":
        if size.none:
            return cls("factor", 0.003, 0.6, size.none)
        if size.transform == "plain":
            least = min((v for v in size.starts if v > 0), key=abs)
            return cls("plain", least, max(abs(v) for v in size.starts))
        if size.power < 0:
            return cls("stiff", max(size.starts), min(size.starts))
        return cls("small", min(size.starts), max(size.starts))

    def value(self, times: float) -> float:
        """The number so many times as far from no effect as one."""
        if self.kind == "plain":
            return float(np.clip(times * self.unit, -self.most, self.most))
        if self.kind == "factor":
            return self.none + float(np.clip(times * self.unit, -self.most, self.most))
        if self.kind == "stiff":
            return float(np.clip(self.unit / max(times, 1e-4), self.most, None))
        return float(np.clip(times * self.unit, 0.03 * self.unit, self.most))

    def values(self, times: tuple[float, ...]) -> list[float]:
        """The numbers so many times as far from no effect as one, to both sides where there are two."""
        signed = (*times, *(-t for t in times)) if self.kind in ("plain", "factor") else times
        return sorted({self.value(t) for t in signed})


class Screen:
    """Residuals, in noise units, with everything that was free before projected out."""

    def __init__(self, problem: Problem, u: Array, poles: Complex, relieved: bool = False) -> None:
        """Screen around a fit.

        Args:
            problem: the fit so far on thinned data, its floor the misfit.
            u: its numbers.
            poles: of the ring-down.
            relieved: whether to look for what lets a bent assembly go back to rest, with the floor as it is: an effect
                of a size that shows does so only beyond first order, and what that leaves must be forgiven.
        """
        self.relieved = relieved
        self.large = problem.floor > LARGE and not relieved
        if not self.large and not relieved:
            problem = replace(problem, floor=problem.floor / 10 if problem.floor > SMALL else 0.0)
        self.problem, self.u, self.poles = problem, u, poles
        self.floor = problem.floor
        self.here = problem.residual(u)
        used = self.here[self.here != 0]
        self.cut = max(OUTLIER, CUT**2 * float(np.mean(used**2))) if len(used) else OUTLIER
        J = jacobian(problem, u, self.here)
        self.priors = problem.free.size
        whole = np.concatenate([J, np.eye(self.priors, len(u))])
        self.q = np.linalg.qr(whole + 0.0)[0]

    def begins(self, candidate: Candidate) -> tuple[Begin, ...]:
        """The best places for a candidate to begin, best first."""
        problem = replace(self.problem, candidates=(*self.problem.candidates, candidate))
        if self.large:
            return self._far(problem, candidate)
        tried = [Begin(problem, u, self.left(problem, u)) for u in self._near(problem, candidate)]
        if len(candidate.slots) == 2 and search_of(candidate.effect).absorbed_by != "damping ratios":
            # Along the beam one valley may be as deep as the next: each is worth a look.
            tried = _valleys(tried)
        return tuple(sorted(tried, key=lambda b: b.cost)[: VALLEYS if len(candidate.slots) == 2 else 1])

    def left(self, problem: Problem, u: Array) -> float:
        """Squares that stay at u of a problem with one candidate more, large ones cut."""
        rest = self._project(problem.residual(u), u)
        return float(np.sum(np.minimum(rest**2, self.cut)))

    def _project(self, r: Array, u: Array) -> Array:
        whole = np.concatenate([r, u[: self.priors]])
        return whole - self.q @ (self.q.T @ whole)

    def _near(self, problem: Problem, candidate: Candidate) -> list[Array]:
        """Small changes: the size follows from the signature of a small one, at each place where there are places."""
        slots = candidate.slots
        if search_of(candidate.effect).absorbed_by == "damping ratios":
            # The damping ratios have taken its work over: to first order nothing of it is left to see.
            return [_relieved(problem, np.concatenate([self.u, more])) for more in _grid(slots)]
        if len(slots) == 2 and slots[1].name == "x":
            return [self._sized(problem, slots[0], np.array([slots[1].coordinate(x)])) for x in slots[1].starts]
        if self.relieved and len(slots) == 1:
            return [np.concatenate([self.u, [slots[0].coordinate(v)]]) for v in _Scale.of(slots[0]).values(TIMES)]
        plain = [np.concatenate([self.u, more]) for more in _grid(slots)]
        return [*plain, self._sized(problem, slots[0], np.zeros(0))] if len(slots) == 1 else plain

    def _sized(self, problem: Problem, size: Slot, place: Array) -> Array:
        """The size that explains most, if the answer were in proportion to it."""
        scale = _Scale.of(size)
        u = np.concatenate([self.u, [size.coordinate(scale.value(1.0))], place])
        before = self._project(self.here, self.u)
        signature = self._project(problem.residual(u), u) - before
        times = float(-(signature @ before) / max(float(signature @ signature), 1e-300))
        return np.concatenate([self.u, [size.coordinate(scale.value(times))], place])

    def _far(self, problem: Problem, candidate: Candidate) -> tuple[Begin, ...]:
        """Large changes: the whole grid at the fit so far, and at the beam that the poles of the ring-down show."""
        free, former = problem.free, self.u[self.priors :]
        begins: list[Array] = []
        nears = [self.u]
        if len(self.poles):
            # A large effect drags the fit so far off: the poles of the ring-down know the beam without it.
            nears.append(start(self.problem.candidates, former, free, self.poles).u)
            if model_of(candidate.effect).moves_poles:
                best = 3 if len(candidate.slots) > 1 else 1
                begins = [s.u for s in starts(problem.candidates, free, self.poles, best, former)]
        listed = [Begin(problem, u, capped(problem, u)) for u in begins]
        grid = _grid(candidate.slots)
        for turn, near in enumerate(reversed(nears)):
            tried = [(self._at(problem, candidate, np.concatenate([near, more])), more) for more in grid]
            if len(candidate.slots) == 1 and turn == 0:
                # Where no other number has adapted, a small effect may leave less than the right one.
                listed += sorted(_valleys([b for b, _ in tried]), key=lambda b: b.cost)[1:SIZES]
            tried.sort(key=lambda t: t[0].cost)
            listed.append(tried[0][0])
            # What is far off at the beam of the poles is no better at the one that was bent.
            grid = [more for _, more in tried[: 1 + len(tried) // FEWER]]
        return tuple(sorted(listed, key=lambda b: b.cost))

    def _at(self, problem: Problem, candidate: Candidate, u: Array) -> Begin:
        tried = (Begin(problem, v, capped(problem, v)) for v in self._variants(problem, candidate, u))
        return min(tried, key=lambda b: b.cost)

    def _variants(self, problem: Problem, candidate: Candidate, u: Array) -> list[Array]:
        absorbed_by = search_of(candidate.effect).absorbed_by
        if absorbed_by == "damping ratios":
            return [_relieved(problem, u)]
        if absorbed_by == "Young's modulus" and len(self.poles):
            return [u, start(problem.candidates, u[self.priors :], problem.free, self.poles).u]
        return [u]


def _valleys(tried: list[Begin]) -> list[Begin]:
    """Those of a row that leave no more than their neighbours."""
    return [tried[k] for k in lows([b.cost for b in tried])]


def capped(problem: Problem, u: Array) -> float:
    """Squares at u as it is, large ones cut: far from the fit no first order says how the rest would adapt."""
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
