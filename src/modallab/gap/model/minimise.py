"""Levenberg-Marquardt of the twin's free numbers on the reduced data, priors included.

Source: Levenberg, Quart. Appl. Math. 2 (1944), 164; Marquardt, J. SIAM 11 (1963), 431; the damping scaled by the
curvature as in More, Numerical Analysis (Dundee 1977), LNM 630 (1978), 105.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from modallab.gap.model.fit import Fit, Problem, all_rows, softened
from modallab.gap.model.sensitivity import Tangent, smooth_in
from modallab.twin.bench import Twin

Array = NDArray[np.float64]

STEP = 1e-4
"""Step of the numerical derivative, in deviations of the prior or in coordinates of an effect."""

FELT = 0.02
"""Relative error that is forgiven, from which the deviations of an ordinary bench are not felt."""
WORKERS = 2
"""Records in time are stepped outside the interpreter's lock."""
FIRST = 1.0
"""First damping where tolerances are free, in squares of the priors' deviations."""


def minimise(problem: Problem, u: Array, iterations: int = 8, tolerance: float = 1e-4) -> Fit:
    """Levenberg-Marquardt from u, the damping a tenth after a step that helps, tenfold after one that does not.

    Args:
        problem: what to fit.
        u: (u,) where to begin, in prior deviations and in coordinates of the effects.
        iterations: most steps.
        tolerance: relative fall of the cost at which to stop.
    """
    r = problem.residual(u)
    n = problem.free.size
    cost = float(r @ r + problem.priors(u)[0])
    # Where nothing is forgiven a fit is near its end: what is left to go lies along narrow valleys.
    damping = 1e-4 if problem.floor else 1e-8
    if problem.free.deviations:
        damping = FIRST
    normal = np.eye(len(u))
    for _ in range(iterations):
        J = jacobian(problem, u, r)
        normal, gradient = J.T @ J, J.T @ r
        _, slope, weight = problem.priors(u)
        normal[np.arange(n), np.arange(n)] += weight
        gradient[:n] += slope
        u_next, r_next, cost_next, damping = _step(problem, u, (cost, normal, gradient), damping)
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
    first = problem.free.first_deviation
    deviations = range(first, first + len(problem.free.deviations))
    # While more is forgiven than the deviations can do, they stay where their priors want them.
    used = [k for k in range(len(u)) if k not in deviations or problem.floor < FELT]
    twins = {k: problem.twin(moved[k]) for k in used}
    smooth = [k for k, twin in twins.items() if smooth_in(here, twin)]
    # The nuisances are many and each is small: for them the first order of the eigenvalue problem will do.
    smooth.sort(key=lambda k: k < problem.free.size)
    if smooth:
        near = sum(k < problem.free.size for k in smooth)
        J[:, smooth] = _columns(problem, here, [twins[k] for k in smooth], near, len(r)) / STEP
    rest = sorted(set(used) - set(smooth))
    if here.element is None:
        rows = (problem.residual(moved[k]) for k in rest)
    else:
        with ThreadPoolExecutor(WORKERS) as workers:
            rows = list(workers.map(problem.residual, moved[rest]))
    for k, there in zip(rest, rows, strict=True):
        J[:, k] = (there - r) / STEP
    return J


def _columns(problem: Problem, here: Twin, twins: list[Twin], near: int, size: int) -> Array:
    changes = Tangent(here, problem.data).changes(twins, near)
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
    problem: Problem, u: Array, here: tuple[float, Array, Array], damping: float
) -> tuple[Array, Array, float, float]:
    cost, normal, gradient = here
    scale = _scale(problem, normal)
    u_next, r_next, cost_next = u, np.zeros(0), cost
    while damping < 1e7:
        step = -np.linalg.solve(normal + damping * scale, gradient)
        u_next = u + np.clip(step, -4, 4)
        r_next = problem.residual(u_next)
        cost_next = float(r_next @ r_next + problem.priors(u_next)[0])
        if cost_next < cost:
            return u_next, r_next, cost_next, max(damping / 10, 1e-9)
        damping *= 10
    return u, r_next, cost, damping


def _scale(problem: Problem, normal: Array) -> Array:
    """What damps a step: the curvature along each axis, which for the beam are those that the data part.

    Frequencies determine E t^2 / rho to a millionth, amplitudes rho t to a thousandth, and the thickness alone shows in
    the rotary inertia only. Damped along E, t and rho, a fit would creep along that valley and seem to have ended.
    """
    axes = np.eye(len(normal))
    if problem.free.deviations:
        # Many numbers do nearly the same: what no data part must be free to go as far as its priors let it.
        return axes
    if not problem.floor:
        axes[:3, :3] = problem.free.axes
    across = np.linalg.inv(axes)
    curvature = np.maximum(np.einsum("ij,ik,kj->j", axes, normal, axes), 1e-9)
    return across.T @ (curvature[:, None] * across)
