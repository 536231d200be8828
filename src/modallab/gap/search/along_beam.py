"""A smooth law at other places along the beam, each time as strong on the slowest mode.

Sines and the first hits know how much the slowest mode stiffens, k phi(x)^4 of a cubic spring with that mode's shape
phi, and hardly where the spring sits: costs along that valley have a low on either side of other modes' nodes, and a
fit stays in the one where it began.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.model.minimise import WORKERS, jacobian
from modallab.twin.effects import search_of
from modallab.twin.modes import solve_modes

PLACES = 15
"""Places that are tried."""
LOWEST = 0.3
"""Place over L nearer to the clamp than which such a law is not felt."""
STEPS = 4
"""Steps at each with the slopes of the first."""
FIRST = 1e-2
"""Damping of the first step, as a share of each number's curvature."""
NOTHING = 1e-12
"""Share of the largest curvature that counts as none."""


def best_along_beam(fit: Fit) -> Fit:
    """The fit, or that at the place where its law does best; other numbers follow by the slopes of the fit.

    Args:
        fit: to all records, its last effect with a place and a number first; see `SteppedLaw.on_slowest`.
    """
    law = fit.problem.candidates[-1]
    power, names = search_of(law.effect).law.on_slowest, [s.name for s in law.slots]
    if not power:
        return fit
    J = jacobian(fit.problem, fit.u, fit.residual, whole=True)
    first = len(fit.u) - len(law.slots)
    place = first + names.index("x")
    x, strength = law.slots[names.index("x")], law.slots[0]
    at = x.value(float(fit.u[place]))

    def there(other: float) -> Fit:
        u = fit.u.copy()
        u[place] = x.coordinate(other)
        ratio = (_shape_of_slowest_mode(fit, at) / _shape_of_slowest_mode(fit, other)) ** power
        u[first] = strength.coordinate(strength.value(float(u[first])) * ratio)
        return _fit_at_place(fit.problem, u, J, place)

    places = np.linspace(max(x.low, LOWEST), x.high, PLACES)
    with ThreadPoolExecutor(WORKERS) as workers:
        found = list(workers.map(there, places))
    between = _minimum_of_parabola(places, [f.cost for f in found])
    return min([fit, *found, there(between)], key=lambda f: f.cost)


def _minimum_of_parabola(places: Real, costs: list[float]) -> float:
    """Where a parabola through the least of these and its neighbours is least."""
    i = min(max(int(np.argmin(costs)), 1), len(costs) - 2)
    before, here, after = costs[i - 1 : i + 2]
    bend = before - 2 * here + after
    if not bend > 0:
        # Where the law does nothing, or the least lies at an end, there is no parabola with a low.
        return float(places[i])
    step = places[1] - places[0]
    return float(np.clip(places[i] + step * (before - after) / (2 * bend), places[i - 1], places[i + 1]))


def _shape_of_slowest_mode(fit: Fit, x: float) -> float:
    """Size of the slowest mode's shape at a place over L."""
    structure = fit.problem.twin(fit.u).structure
    modes = solve_modes(structure)
    return float(abs(modes.shapes_at(np.array([x * structure.length_m]))[0, np.argmin(abs(modes.poles))]))


def _fit_at_place(problem: Problem, u: Real, J: Real, place: int) -> Fit:
    """A few steps of all numbers but the place, with slopes that are known."""
    moving = np.delete(np.arange(len(u)), place)
    n, here, damping = problem.free.size, fit_at(problem, u), FIRST
    normal = J.T @ J
    normal[np.arange(n), np.arange(n)] += problem.priors(u)[2]
    held = normal[np.ix_(moving, moving)]
    # A law that does nothing has no curvature to hold a step back.
    own = np.maximum(np.diag(held), NOTHING * np.max(np.diag(held)))
    for _ in range(STEPS):
        gradient = J.T @ here.residual
        gradient[:n] += problem.priors(here.u)[1]
        there = here.u.copy()
        there[moving] -= np.linalg.solve(held + damping * np.diag(own), gradient[moving])
        after = fit_at(problem, there)
        here, damping = (after, damping / 10) if after.cost < here.cost else (here, damping * 10)
    return here
