"""Which effect that depends on the size of the motion explains what no linear beam does.

Such an effect has to be stepped in time. A first look is taken at the sine blocks that a linear beam explains worst,
both levels of each frequency, with every start on its grid; the best are fitted there, and the best of those on all
data.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from modallab.gap.conditioning.reduce import Reduced, Rows, SineData
from modallab.gap.model.candidates import of_motion
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import minimise
from modallab.gap.model.prefit import start
from modallab.gap.search.fitting import Bench, excess
from modallab.gap.search.round import Level
from modallab.twin.candidate import Candidate

Array = NDArray[np.float64]

BLOCKS = 12
"""Sine blocks of a first look."""
LOOKED = 0.1
"""Relative error that is forgiven in it."""
LONGER = 2
"""Effects that are fitted on all data."""
OUTLIER = 100.0
"""Square at which a residual stops counting where starts are compared."""
BESIDE = 0.5
"""Share of the gap that a linear effect must take away to be kept beside one that is not."""


def nonlinear_levels(bench: Bench, levels: Sequence[Level]) -> list[Level]:
    """One round of the effects that depend on the size of the motion, alone and beside the best linear one."""
    base = levels[0].base
    few = _worst(bench.data, base)
    former = _beside(levels)
    looks = [_look(bench, few, own, c) for own in former for c in of_motion(bench.data.rig) if bench.allowed(c.effect)]
    best = sorted((f for f in looks if f is not None), key=lambda f: f.cost)
    fits = sorted((_on_all(bench, f) for f in best[:LONGER]), key=lambda f: f.cost)
    return [Level(base, tuple(fits), tuple((f.problem.candidates, f.cost) for f in best[LONGER:]))]


def _beside(levels: Sequence[Level]) -> list[Fit]:
    """The fits that an effect is looked for beside: none but the beam, and the best linear effect if it is worth it."""
    base = levels[0].base
    best = next(iter(levels[0].fits), None)
    return [base, best] if best is not None and excess(best) < BESIDE * excess(base) else [base]


def _worst(data: Reduced, base: Fit) -> Reduced:
    """The sine blocks that a linear beam explains worst, relative to their size; the hits where there are none."""
    if data.sines is None:
        return data
    d = data.sines
    y = forward(base.problem.twin(base.u), data)[-1]
    off = np.abs(np.where(np.isfinite(d.rows.sigma), d.rows.y - y, 0)) / d.rows.sigma
    by_block = np.sqrt(np.mean(off.reshape(len(off), *d.source.lines.shape) ** 2, axis=(0, 2)))
    chosen: list[int] = []
    for j in np.argsort(by_block)[::-1]:
        pair = [k for k, hz in enumerate(d.source.frequency_hz) if abs(hz - d.source.frequency_hz[j]) < 1e-3]
        chosen += [k for k in pair if k not in chosen]
        if len(chosen) >= BLOCKS:
            break
    return replace(data, impacts=(), sines=_blocks(d, sorted(chosen)))


def _blocks(d: SineData, at: list[int]) -> SineData:
    s = d.source
    lines = s.lines.shape[1]
    rows = np.concatenate([np.arange(j * lines, (j + 1) * lines) for j in at])
    rise = replace(
        s.rise,
        history_s=s.rise.history_s[at],
        ramp_s=s.rise.ramp_s[at],
        cosine=s.rise.cosine[at],
        counted=s.rise.counted[at],
    )
    source = replace(s, lines=s.lines[at], frequency_hz=s.frequency_hz[at], force=s.force[at], rise=rise)
    kept = Rows(d.rows.y[:, rows], d.rows.sigma[:, rows], d.rows.common[rows], d.rows.direction[:, rows])
    return replace(d, pieces=tuple(d.pieces[j] for j in at), source=source, rows=kept)


def _look(bench: Bench, few: Reduced, former: Fit, candidate: Candidate) -> Fit | None:
    """The effect from the best of its starts, fitted on few records."""
    candidates = (*former.problem.candidates, candidate)
    problem = Problem(few, bench.free, candidates, LOOKED)
    own = former.u[bench.free.size :]
    best: tuple[float, Array] | None = None
    for values in product(*(slot.starts for slot in candidate.slots)):
        more = np.array([s.coordinate(v) for s, v in zip(candidate.slots, values, strict=True)])
        begins = [np.concatenate([former.u, more])]
        if len(bench.poles):
            begins.append(start(candidates, np.concatenate([own, more]), bench.free, bench.poles).u)
        for u in begins:
            cost = float(np.sum(np.minimum(problem.residual(u) ** 2, OUTLIER)))
            if best is None or cost < best[0]:
                best = cost, u
    if best is None:
        return None
    fit = minimise(problem, best[1], 5, 1e-2)
    return minimise(replace(problem, floor=LOOKED / 5), fit.u, 5, 1e-2)


def _on_all(bench: Bench, fit: Fit) -> Fit:
    u = fit.u
    for floor in (LOOKED / 5, LOOKED / 50):
        u = minimise(Problem(bench.data, bench.free, fit.problem.candidates, floor), u, 3, 3e-2).u
    return minimise(Problem(bench.data, bench.free, fit.problem.candidates), u, 6, 1e-3)
