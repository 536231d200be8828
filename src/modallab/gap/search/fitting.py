"""What a search works on, and its fits: short ones to compare, long ones to believe.

Fits begin with a large model error forgiven and end with none, so that they pass the shallow minima of the full problem
(graduated non-convexity: Blake and Zisserman, Visual Reconstruction, 1987).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.overtones import Harmonic
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.identified import PointModes
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import FELT, is_near_noise_floor, minimise
from modallab.gap.model.nuisances import Nuisances
from modallab.gap.model.prefit import start_fit
from modallab.gap.model.tolerances import MOST
from modallab.gap.model.twin_of_fit import with_drift_curve
from modallab.twin.candidate import CandidateEffect

COARSEST_ERROR = 0.3
"""Largest relative model error that is forgiven while a fit finds its way."""
FLOOR_MARGIN = 1.1
"""Rms residual below which nothing is left to explain."""
UNLIKELY = 4.0
"""Deviations of a sum of squares beyond which its numbers are no ordinary bench's."""
SOLVED = 1.3
"""Times the floor up to which a fit leaves no more than noise."""
NEAR = 3.0
"""Times the floor up to which a fit is worth its last digits."""
SHORT, LONG = 8, 30
"""Slopes that are evaluated at most: far from the floor, and along a narrow valley near it."""
END = 5e-3
"""Fall of what is above the noise, between two slopes, at which a fit has ended: probabilities differ by less."""
STRAIGHT = 3.0
"""Deviations of its priors up to which a beam is one to begin from."""


@dataclass(frozen=True, eq=False, slots=True)
class Bench:
    """What a search works on.

    Attributes:
        data: all of what may be fitted.
        thin: the same with fewer lines, for a first look.
        free: the nuisances.
        poles: of the ring-down.
        allowed: whether an effect of this name may be used.
        flat: rms residual below which nothing has to be explained.
        overtones: of the sines that may be fitted.
        known: explanations that an earlier diagnosis had left standing, and where their fits begin.
        points: modes of the hits at each drive point, identified without a model.
        row: the channel that is off alone: only effects on it are tried; None for all effects.
    """

    data: Reduced
    thin: Reduced
    free: Nuisances
    poles: Complex
    allowed: Callable[[str], bool]
    flat: float = FLOOR_MARGIN
    overtones: tuple[Harmonic, ...] = ()
    known: tuple[tuple[Problem, Real], ...] = ()
    points: tuple[PointModes, ...] = ()
    row: int | None = None


def complete_fit(bench: Bench, fit: Fit, floor: float) -> Fit:
    """A short fit brought to its end on all data, with ever less forgiven.

    Thinned data are mostly those about resonances: where the model is a little wrong there, they lead a fit astray.
    """
    return converged_fit(bench, annealed_fit(replace(bench, thin=bench.data), fit, floor))


def annealed_fit(bench: Bench, fit: Fit, floor: float) -> Fit:
    """A short fit with ever less forgiven, and nothing in the end, on thinned data."""
    floor = min(floor, forgivable_error(fit.problem, fit.u))
    # Many numbers that do nearly the same settle while the valley is wide.
    later = (floor / 36, floor / 216) if bench.free.deviations else ()
    for level in (floor, floor / 6, *later):
        problem = Problem(bench.thin, bench.free, fit.problem.candidates, level, held=_beam_coordinates(fit.u))
        fit = minimise(problem, fit.u, 3, 3e-2)
    problem = Problem(bench.thin, bench.free, fit.problem.candidates)
    return minimise(problem, bench.free.within_priors(fit.u), 8, 1e-3)


def converged_fit(bench: Bench, fit: Fit) -> Fit:
    """A fit brought to its end on all data, if that is near the floor: nothing else can explain the gap."""
    found = minimise(Problem(bench.data, bench.free, fit.problem.candidates), fit.u, SHORT, END)
    if is_near_noise_floor(found):
        found = minimise(found.problem, found.u, LONG, END)
    return with_drift_curve(found)


def within_tolerances(fit: Fit) -> bool:
    """Whether the beam and the assembly of a fit lie within their tolerances all in all, as a sum of squares does.

    The damping ratios do not count: nobody knows them before the test.
    """
    own = _tolerance_deviations(fit.problem.free, fit.u)
    return float(own @ own) < len(own) + UNLIKELY * np.sqrt(2 * len(own))


def each_within_tolerance(fit: Fit) -> bool:
    """Whether each number of the beam and of the assembly lies within what its tolerance may be, if not all together.

    As in `within_tolerances`, the damping ratios do not count.
    """
    return bool(np.all(np.abs(_tolerance_deviations(fit.problem.free, fit.u)) <= MOST))


def _tolerance_deviations(free: Nuisances, u: Real) -> Real:
    return np.concatenate([u[:3], u[3 + free.modes : free.size]])


def leaves_noise_only(bench: Bench, fit: Fit) -> bool:
    """Whether a fit leaves no more than noise, on a bench that is put together as benches are."""
    return fit.gap <= SOLVED * bench.flat and within_tolerances(fit)


def search_origin(bench: Bench, fit: Fit) -> Fit:
    """Where a search begins from a fit: at the fit, or at rest if its assembly deviates beyond its tolerances.

    Such an assembly replaces the effect: to first order nothing of the effect is left to see. Where it deviates little,
    the priors show to first order which deviations an effect would make unnecessary.
    """
    if not bench.free.deviations or within_tolerances(fit) or fit.gap <= NEAR * bench.flat:
        return fit
    return fitted_from_rest(bench, fit)


def fitted_from_rest(bench: Bench, fit: Fit) -> Fit:
    """The fit with the assembly at rest, and the beam as it is best then."""
    problem = Problem(bench.data, bench.free, fit.problem.candidates, FELT)
    return fit_at_on_all_data(bench, minimise(problem, nuisances_at_rest(bench.free, fit.u), 6, 1e-2))


def nuisances_at_rest(free: Nuisances, u: Real) -> Real:
    """The same numbers with the assembly as the rig file has it and the beam within its tolerances."""
    u = u.copy()
    u[3 + free.modes : free.size] = 0.0
    u[:3] = np.clip(u[:3], -1.0, 1.0)
    return u


def fit_from_poles(bench: Bench, candidates: tuple[CandidateEffect, ...], own: Real) -> Fit:
    """A fit brought to its end from these coordinates of the effects and the beam that the poles show."""
    return complete_fit(bench, short_fit_from_poles(bench, candidates, own), COARSEST_ERROR / 6)


def short_fit_from_poles(bench: Bench, candidates: tuple[CandidateEffect, ...], own: Real) -> Fit:
    """A short fit from there."""
    return short_fit(bench, candidates, start_fit(candidates, own, bench.free, bench.poles).u, COARSEST_ERROR)


def fit_at_on_all_data(bench: Bench, fit: Fit) -> Fit:
    """A short fit as it is, on all data."""
    return fit_at(Problem(bench.data, bench.free, fit.problem.candidates), fit.u, fit.normal)


def forgivable_error(problem: Problem, u: Real) -> float:
    """Relative model error at which these numbers would be excused: where a look for more must begin."""
    twin = problem.twin(u)
    answers = forward(twin, problem.data)
    for floor in (COARSEST_ERROR, 0.1, 0.03, 0.01, 0.003):
        r = replace(problem, floor=floor).residual_of(twin, answers)
        used = r[r != 0]
        if len(used) and np.sqrt(np.mean(np.minimum(used**2, 100.0))) > 0.5:
            return floor
    return 0.001


def short_fit(bench: Bench, candidates: tuple[CandidateEffect, ...], u: Real, floor: float, steps: int = 3) -> Fit:
    """A few steps on thinned data, while a relative error of `floor` is forgiven; its cost is to be compared."""
    # Numbers that are nearly right must not be let go again: forgiven is no more than they need.
    problem = Problem(bench.thin, bench.free, candidates)
    near = min(floor, forgivable_error(problem, u))
    fit = minimise(replace(problem, floor=near, held=_beam_coordinates(u)), u, steps, 5e-2)
    # To be compared, all must be forgiven as much and held nowhere in particular.
    return fit_at(replace(problem, floor=floor, held=_beam_coordinates(fit.u)), fit.u, fit.normal)


def _beam_coordinates(u: Real) -> tuple[float, float, float]:
    """Where a beam is held: where it is, unless a wrong model has strained it there."""
    return (float(u[0]), float(u[1]), float(u[2])) if np.all(np.abs(u[:3]) < STRAIGHT) else (0.0, 0.0, 0.0)


def refitted_without(fit: Fit, which: int) -> Fit:
    """The fit without one of its effects, all other numbers fitted again."""
    return minimise(*without_effect(fit.problem, fit.u, which), 4, 1e-2)


def without_effect(problem: Problem, u: Real, which: int) -> tuple[Problem, Real]:
    """A problem without one of its effects, and all other numbers as they are."""
    candidates = problem.candidates
    at = problem.free.size + sum(len(c.slots) for c in candidates[:which])
    rest = np.delete(u, np.s_[at : at + len(candidates[which].slots)])
    return replace(problem, candidates=candidates[:which] + candidates[which + 1 :]), rest


def excess_over_floor(fit: Fit) -> float:
    """What is left above the floor, in squares of noise units, with the excess of the assembly over its tolerances."""
    strained = 0.0
    if fit.problem.free.deviations:
        own = _tolerance_deviations(fit.problem.free, fit.u)
        strained = max(float(own @ own) - len(own), 0.0) / max(float(np.count_nonzero(fit.residual)), 1.0)
    return max(fit.gap**2 - 1 + strained, 1e-9)
