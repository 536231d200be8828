"""Levenberg-Marquardt of the twin's free numbers on the reduced data, priors included.

The slopes serve several steps, while these help (the chord method: Kelley, Iterative Methods for Linear and Nonlinear
Equations, SIAM 1995, ch. 5).

Source: Levenberg, Quart. Appl. Math. 2 (1944), 164; Marquardt, J. SIAM 11 (1963), 431; the damping scaled by the
curvature as in More, Numerical Analysis (Dundee 1977), LNM 630 (1978), 105. Near the floor a step bends along the
valley (geodesic acceleration: Transtrum and Sethna, arXiv:1201.5885, 2012): frequencies known to a millionth leave a
valley between numbers known to a percent whose curvature ends straight steps after a hundredth of its length.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.model.fit import Fit, Problem, all_rows, with_relative_noise
from modallab.gap.model.sensitivity import Tangent, differ_smoothly
from modallab.twin.bench import Twin

STEP = 1e-4
"""Step of the numerical derivative, in deviations of the prior or in coordinates of an effect."""

FELT = 0.02
"""Relative error that is forgiven, from which the deviations of an ordinary bench are not felt."""
WORKERS = 2
"""Records in time are stepped outside the interpreter's lock."""
SAME_SLOPES = 6
"""Steps that one evaluation of the slopes serves, at most: a step costs a tenth of the slopes."""
LEAST = 0.1
"""Fall of the cost at which to stop where noise alone is left: likelihoods that differ by a twentieth are alike."""
SLOW = 0.03
"""Share of the fall since the slopes were evaluated below which a step says that they are worn out."""
CURVED = 1e-4
"""Share of a number's curvature that damps it as well."""
STIFFEST = 1e7
"""Damping at which no step helps."""
FIRST = 1.0
"""First damping where tolerances are free, in squares of the priors' deviations."""
ALONG = 0.3
"""Share of a step at which its curvature is looked at, to either side."""
NARROW = 10.0
"""Mean square, in noise units, from which a step has further to go than the valley is wide."""
MOST_CURVED = 1.5
"""A step that would bend by more than so many times its length goes straight: second order says nothing of it."""


def minimise(problem: Problem, u: Real, iterations: int = 8, tolerance: float = 1e-4, whole: bool = False) -> Fit:
    """Levenberg-Marquardt from u, the damping a tenth after a step that helps, tenfold after one that does not.

    Args:
        problem: what to fit.
        u: (u,) where to begin, in prior deviations and in coordinates of the effects.
        iterations: how often the slopes are evaluated at most.
        tolerance: fall of the cost between two evaluations of the slopes at which to stop, as a share of what is above
            the noise's own squares.
        whole: see `jacobian`.
    """
    # Where nothing is forgiven a fit is near its end: what is left to go lies along narrow valleys.
    damping = FIRST if problem.free.deviations else 1e-4 if problem.floor else 1e-8
    here, dampings, normal = _at(problem, u), (damping, damping), np.eye(len(u))
    for _ in range(iterations):
        before = here.cost
        here, dampings, normal = _descended(problem, here, dampings, whole)
        if before - here.cost < tolerance * max(before - np.count_nonzero(here.r), 0.0) + LEAST:
            break
    return Fit(problem, here.u, here.cost, here.r, normal)


@dataclass(frozen=True, eq=False, slots=True)
class _Here:
    """Numbers, residual and cost."""

    u: Real
    r: Real
    cost: float


def _at(problem: Problem, u: Real) -> _Here:
    r = problem.residual(u)
    return _Here(u, r, float(r @ r + problem.priors(u)[0]))


def _descended(
    problem: Problem, begin: _Here, dampings: tuple[float, ...], whole: bool
) -> tuple[_Here, tuple[float, ...], Real]:
    """Where the slopes at a place lead to, the damping of the next steps, and the curvature there.

    Steps held back more along what the data determine, and steps held back alike along all numbers, each creep where
    the others do not; the slopes cost more than both.
    """
    J, n = jacobian(problem, begin.u, begin.r, whole), problem.free.size
    normal = J.T @ J
    normal[np.arange(n), np.arange(n)] += problem.priors(begin.u)[2]
    scales = (_scale(problem, normal), np.eye(len(normal)))[: len(dampings) if problem.free.deviations else 1]
    ways = [_along(problem, begin, (J, normal, s), d) for s, d in zip(scales, dampings, strict=False)]
    best = min(ways, key=lambda way: way[0].cost)[0]
    return best, tuple(d for _, d in ways), normal


def _along(problem: Problem, begin: _Here, slopes: tuple[Real, Real, Real], damping: float) -> tuple[_Here, float]:
    """Where steps with these slopes lead to, and the damping of the next."""
    J, n, here = slopes[0], problem.free.size, begin
    for again in range(SAME_SLOPES):
        gradient = J.T @ here.r
        gradient[:n] += problem.priors(here.u)[1]
        there, damping = _step(problem, here, slopes, gradient, damping, once=again > 0)
        if there is None:
            break
        fall, here = here.cost - there.cost, there
        if fall < SLOW * (begin.cost - here.cost):
            break
    return here, damping


def jacobian(problem: Problem, u: Real, r: Real, whole: bool = False) -> Real:
    """(residuals, u): through poles and residues where the beam, its places or gains move, else by differences.

    Args:
        problem: what is fitted.
        u: (u,) where.
        r: (residuals,) there.
        whole: whether what an element that is stepped in time makes of an ordinary bench's deviations is counted: each
            costs a step through all records.
    """
    # A row each, as they come: the products that follow run along them.
    J = np.zeros((len(u), len(r)))
    here = problem.twin(u)
    moved = u + STEP * np.eye(len(u))
    first = problem.free.first_deviation
    deviations = range(first, first + len(problem.free.deviations))
    # While more is forgiven than the deviations can do, they stay where their priors want them.
    used = [k for k in range(len(u)) if k not in deviations or problem.floor < FELT]
    twins = dict(zip(used, problem.twins(moved[used]), strict=True))
    if here.element is not None and not whole:
        # They are many and small: what the element makes of them is left to further steps.
        here = replace(here, element=None)
        twins |= {k: replace(twin, element=None) for k, twin in twins.items() if k in deviations}
    smooth = [k for k, twin in twins.items() if differ_smoothly(here, twin)]
    # The nuisances are many and each is small: for them the first order of the eigenvalue problem will do.
    smooth.sort(key=lambda k: k < problem.free.size)
    if smooth:
        near = sum(k < problem.free.size for k in smooth)
        J[smooth] = _slopes(problem, here, [twins[k] for k in smooth], near, len(r))
        smooth = [k for k in smooth if not np.isnan(J[k, 0])]
    rest = sorted(set(used) - set(smooth))
    for k, there in zip(rest, _residuals(problem, moved[rest]), strict=True):
        J[k] = (there - r) / STEP
    return J.T


def _residuals(problem: Problem, moved: Real) -> list[Real]:
    if not len(moved) or problem.twin(moved[0]).element is None:
        return [problem.residual(u) for u in moved]
    with ThreadPoolExecutor(WORKERS) as workers:
        return list(workers.map(problem.residual, moved))


def _slopes(problem: Problem, here: Twin, twins: list[Twin], near: int, size: int) -> Real:
    """(twins, residuals); NaN for a twin to which no slope leads."""
    changes = Tangent(here, problem.data).changes(twins, near)
    weights = [with_relative_noise(rows, problem.floor) for rows in all_rows(problem.data)]
    # What the clock says of the sines does not depend on the beam.
    rows, at = np.zeros((len(twins), size)), 0
    half = sum(w.y.size for w in weights)
    for w, y in zip(weights, changes, strict=True):
        values, own = w.in_noise_units(y).reshape(len(twins), -1), slice(at, at + w.y.size)
        rows[:, own], rows[:, half + at : half + own.stop] = values.real, values.imag
        at = own.stop
    rows *= -1.0 / STEP
    lost = np.isnan(rows[:, 0])
    rows[~np.isfinite(rows)] = 0.0
    rows[lost] = np.nan
    return rows


def _step(
    problem: Problem, here: _Here, slopes: tuple[Real, Real, Real], gradient: Real, damping: float, once: bool
) -> tuple[_Here | None, float]:
    """Where the first step that helps leads to, of one or of ever shorter ones, None if none does; the next damping."""
    (J, normal, scale), first = slopes, damping
    while damping < STIFFEST:
        held_back = normal + damping * scale
        step: Real = np.clip(-np.linalg.solve(held_back, gradient), -4.0, 4.0).astype(np.float64)
        if not once and not problem.floor and _near_floor(here.cost, here.r):
            step = _curved_step(problem, here, J, held_back, step)
        there = _at(problem, here.u + np.clip(step, -4, 4))
        if there.cost < here.cost:
            return there, max(damping / 10, 1e-9)
        if once:
            break
        damping *= 10
    return None, first


def is_near_noise_floor(fit: Fit) -> bool:
    """Whether a fit is so near the floor that the valley is narrower than it is curved."""
    return _near_floor(fit.cost, fit.residual)


def _near_floor(cost: float, r: Real) -> bool:
    return cost < NARROW * np.count_nonzero(r)


def _curved_step(problem: Problem, here: _Here, J: Real, held_back: Real, step: Real) -> Real:
    """A step that follows the curvature of the residual along it, if that is small enough to be believed."""
    sides = problem.residual(here.u + ALONG * step) + problem.residual(here.u - ALONG * step)
    bend = -np.linalg.solve(held_back, J.T @ ((sides - 2 * here.r) / ALONG**2))
    length = np.sqrt(np.maximum(np.diag(held_back), 1e-12))
    small = np.linalg.norm(length * bend) < MOST_CURVED * np.linalg.norm(length * step)
    return step + bend / 2 if small else step


def _scale(problem: Problem, normal: Real) -> Real:
    """What damps a step: the curvature along each axis, which for the beam are those that the data part.

    Frequencies determine E t^2 / rho to a millionth, amplitudes rho t to a thousandth, and the thickness alone shows in
    the rotary inertia only. Damped along E, t and rho, a fit would creep along that valley and seem to have ended.
    """
    axes = np.eye(len(normal))
    if problem.free.deviations:
        # Many numbers do nearly the same: what no data part must be free to go as far as its priors let it. What the
        # data determine is held back as well, where steps that would be right on a straight way help no more.
        axes[np.diag_indices(len(normal))] += CURVED * np.diag(normal)
        return axes
    if not problem.floor:
        axes[:3, :3] = problem.free.axes
    across = np.linalg.inv(axes)
    curvature = np.maximum(np.einsum("ij,ik,kj->j", axes, normal, axes), 1e-9)
    return across.T @ (curvature[:, None] * across)
