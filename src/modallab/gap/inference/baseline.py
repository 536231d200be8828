"""The twin without effects, as well as it can be made to fit."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.progress import report_progress
from modallab.gap.inference.posterior import Posterior, maximise_posterior
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.inference.view import RowModel, sparse
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.search.fitting import Bench, converged_fit

Array = NDArray[np.float64]

MODULI = np.linspace(-3.2, 3.2, 33)
"""Values of Young's modulus, in deviations, that are tried where no pole of the ring-down says where the beam is."""
STEPS = 12
"""Evaluations of the slopes, at most."""


def baseline(bench: Bench) -> Fit:
    """The twin without effects, fitted to modal rows and then to the records."""
    found = without_effects(bench)[1]
    return converged_fit(bench, fit_at(found.problem, found.u))


def without_effects(bench: Bench) -> tuple[RowModel, Posterior]:
    """The modal rows of a bench, and the twin without effects fitted to them."""
    report_progress(0.0, "the bench without any effect")
    problem = Problem(bench.data, bench.free)
    view = RowModel.of(bench.points, bench.thin, DEFAULT)
    return view, maximise_posterior(view, problem, _starting_point(bench, problem), STEPS)


def _starting_point(bench: Bench, problem: Problem) -> Array:
    """Where to begin: the modal rows have no local minimum; lines of the sines have one every half width."""
    zero = np.zeros(bench.free.size)
    if bench.points:
        hits = replace(bench.thin, sines=None)
        return maximise_posterior(RowModel.of(bench.points, hits, DEFAULT), problem, zero, STEPS).u
    view = RowModel.of((), sparse(bench.thin), DEFAULT)
    tried = np.tile(zero, (len(MODULI), 1))
    tried[:, 0] = MODULI
    residuals = [view.residual(twin) for twin in problem.twins(tried)]
    costs = [view.objective.cost(r, view.objective.levels(r)) for r in residuals]
    return tried[int(np.argmin(costs))]
