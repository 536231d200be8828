"""A wrong clock of the recorder, which the generator's own lines show whatever the beam does."""

import numpy as np

from modallab.gap.model.candidates import beam_candidates
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.search.fitting import Bench, converged_fit, fit_from_poles
from modallab.twin.effects import search_of

EVIDENT = 2.5e-4
"""Relative distance of the generator's lines from where they were set that no quartz explains."""


def clock_error_visible(bench: Bench) -> bool:
    """Whether the generator's lines stand where no quartz puts them, beside a clock that the rig's revisions know."""
    sines = bench.data.sines
    known = bench.free.build(np.zeros(bench.free.size)).clock
    return sines is not None and abs(sines.ratio * (1 + known) - 1) >= EVIDENT


def fit_with_clock(bench: Bench, base: Fit) -> Fit | None:
    """The twin with the clock that the generator's lines show; None if they stand where they should.

    From the beam that the poles show, and from the fit without effects: its assembly follows a clock that is a little
    off, all but the lines.
    """
    clocks = (
        c for c in beam_candidates(bench.data.rig) if search_of(c.effect).tolerance.is_clock and bench.allowed(c.effect)
    )
    candidate = next(clocks, None)
    if candidate is None or bench.data.sines is None or not clock_error_visible(bench):
        return None
    own = np.array([candidate.slots[0].coordinate(1 / bench.data.sines.ratio - 1)])
    strained = fit_at(Problem(bench.data, bench.free, (candidate,)), np.append(base.u, own))
    return min(fit_from_poles(bench, (candidate,), own), converged_fit(bench, strained), key=lambda f: f.cost)
