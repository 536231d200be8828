"""The likeliest starts of an effect in which contacts open and close: slopes lead nowhere from afar.

How far each sine is off on each accelerometer counts as a share of its own size, and as a logarithm: a block beside a
resonance, which is right or wrong but never nearly right, then says no more than any other, the numbers have one
valley, and one wrong channel does not decide.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Problem
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import WORKERS
from modallab.gap.search.overtone_lines import LINES
from modallab.twin.candidate import FreeNumber

FREQUENCIES = 12
"""Sines that are looked at."""
POLISHED = 2
"""Starts that are polished."""
TRIES = 16
"""Looks a number while one is polished."""
EXACT = 0.003
"""Share of a sine's size that any law leaves: less is no better."""
EXACT_OVERTONE = 0.03
"""The same of an overtone's size."""
COUNTS = 1.0
"""Independent numbers that a sine on one accelerometer counts for: its lines, and other channels, are wrong with it."""
LEAST = 0.1
"""Share of the accelerometers' mean below which the size of a sine on one of them does not count: it sits at a node."""
APART = 1.5
"""Spacings of the starts within which two are the same."""


def best_start(problem: Problem, begins: list[Real]) -> Real:
    """The best of the best starts, polished without slopes (Nelder and Mead, Comput. J. 7, 1965, 308).

    Args:
        problem: of the effect, on a few sines, with nothing forgiven: its tolerances alone hold the beam.
        begins: coordinates to begin from.
    """

    def polished(u: Real) -> Real:
        return _local_minimum(problem, u)

    chosen = distinct_starts(problem, begins)
    with ThreadPoolExecutor(WORKERS) as workers:
        return min(workers.map(polished, chosen), key=partial(robust_cost, problem))


def distinct_starts(problem: Problem, begins: list[Real]) -> list[Real]:
    """The best of the starts that are not the same, best first."""
    with ThreadPoolExecutor(WORKERS) as workers:
        scores = list(workers.map(partial(robust_cost, problem), begins))
    chosen: list[Real] = []
    for i in np.argsort(scores):
        if not any(_nearly_equal(problem, begins[i], u) for u in chosen):
            chosen.append(begins[i])
    return chosen[:POLISHED]


def robust_cost(problem: Problem, u: Real) -> float:
    """How far the sines are off, each as a share of its own size, and the numbers from their priors."""
    off = relative_residual(problem, u)
    return COUNTS / 2 * float(np.sum(np.log1p((off / smallest_error(problem.data)) ** 2))) + problem.priors(u)[0]


def smallest_error(data: Reduced) -> Real:
    """(channels, groups) share of its own size that any law, or the noise, leaves of each sine and overtone."""
    assert data.sines is not None
    noise = np.where(np.isfinite(data.sines.rows.sigma), data.sines.rows.sigma, 0.0)
    own = np.sqrt(np.mean(noise.reshape(len(noise), -1, LINES) ** 2, axis=2)) / sine_sizes(data)
    return np.where(is_overtone(data), np.hypot(EXACT_OVERTONE, own), EXACT)


def is_overtone(data: Reduced) -> NDArray[np.bool_]:
    """(groups,) which of the groups of lines stand about an overtone."""
    assert data.sines is not None
    groups = data.sines.source.lines.shape[1] // LINES
    return np.tile(np.arange(groups) > 0, len(data.sines.source.lines))


def relative_residual(problem: Problem, u: Real) -> Real:
    """(channels, groups) what is left of each sine, and overtone, on each accelerometer over its size; 0 if unused."""
    assert problem.data.sines is not None
    left = problem.data.sines.rows.y - forward(problem.twin(u), problem.data)[-1]
    return _by_block(problem.data, left) / sine_sizes(problem.data)


def sine_sizes(data: Reduced) -> Real:
    """(channels, groups) length of each sine's numbers on each accelerometer, no less than a share of what all have."""
    assert data.sines is not None
    own = _by_block(data, data.sines.rows.y)
    return np.maximum(own, np.maximum(LEAST * np.sqrt(np.mean(own**2, axis=0)), 1e-300))


def _by_block(data: Reduced, values: Complex) -> Real:
    assert data.sines is not None
    used = np.isfinite(data.sines.rows.sigma)
    squares = np.where(used, np.abs(values) ** 2, 0.0).reshape(len(values), -1, LINES)
    return np.sqrt(np.sum(squares, axis=2))


def _nearly_equal(problem: Problem, u: Real, other: Real) -> bool:
    slots = problem.candidates[-1].slots
    steps = np.array([APART * 2 * _half_spacing(s) for s in slots])
    first = len(u) - len(slots)
    return bool(np.all(np.abs(u - other)[first:] <= steps)) and abs(u[0] - other[0]) < 1.0


def _local_minimum(problem: Problem, u: Real) -> Real:
    """The beam's stiffness and the effect's own numbers moved to where they leave less nearby."""
    slots = problem.candidates[-1].slots
    moving = [i for i, s in enumerate(slots) if len(s.starts) > 1 or s.name == "x"]
    at = [0, *(len(u) - len(slots) + i for i in moving)]
    steps = np.array([_half_spacing(slots[i]) for i in moving])
    steps = np.array([np.min(steps), *steps])

    def moved(v: Real) -> Real:
        there = u.copy()
        there[at] += v * steps
        return there

    simplex = np.vstack([np.zeros(len(at)), np.eye(len(at))])
    found = minimize(
        lambda v: robust_cost(problem, moved(v)),
        simplex[0],
        method="Nelder-Mead",
        options={"maxfev": TRIES * len(at), "initial_simplex": simplex, "fatol": 0.1},
    )
    return moved(found.x)


def _half_spacing(slot: FreeNumber) -> float:
    """Half of what lies between two starts; of a first simplex."""
    at = [slot.coordinate(v) for v in slot.starts]
    return min([0.015 if slot.name == "x" else 0.3, *(np.diff(at) / 2)])
