"""Which effect that depends on the size of the motion explains what no linear beam does.

Such an effect has to be stepped in time. A first look is taken at the sine blocks that a linear beam explains worst,
both levels of each frequency, with every start on its grid; the best are fitted there, and the best of those on all
data.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from modallab.core.progress import report
from modallab.gap.conditioning.reduce import Reduced, Rows, SineData
from modallab.gap.model.candidates import of_bench, of_motion
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import WORKERS, minimise
from modallab.gap.model.prefit import start
from modallab.gap.search.fitting import Bench
from modallab.gap.search.round import Level
from modallab.twin.candidate import Candidate

Array = NDArray[np.float64]

BLOCKS = 12
"""Sine blocks of a first look."""
LOOKED = 0.1
"""Relative error that is forgiven in it."""
RIVAL = 6.0
"""What leaves so many times more than the best in a look is no rival, and is not fitted on all data."""
OUTLIER = 100.0
"""Square at which a residual stops counting where starts are compared."""


def nonlinear_level(bench: Bench, base: Fit) -> Level:
    """One round of the effects that depend on the size of the motion, on a beam without any other effect."""
    few = _worst(bench.data, base)
    listed = [c for c in of_motion(bench.data.rig) if bench.allowed(c.effect)]
    looks: list[Fit] = []
    for i, candidate in enumerate(listed):
        report(i / len(listed), f"{candidate.effect.replace('_', ' ')}, stepped in time")
        looks.append(_look(bench, few, base, candidate))
    looks.sort(key=lambda f: f.cost)
    fits = [_on_all(bench, f) for f in looks[:2] if f.cost < RIVAL * looks[0].cost]
    rest = tuple((f.problem.candidates, f.cost) for f in looks[len(fits) :])
    return Level(base, tuple(sorted(fits, key=lambda f: f.cost)), rest)


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


def _look(bench: Bench, few: Reduced, base: Fit, candidate: Candidate) -> Fit:
    """The effect from the best of its starts, fitted on few records."""
    begins = [u for own in product(*(slot.starts for slot in candidate.slots)) for u in _begins(bench, candidate, own)]
    problem = Problem(few, bench.free, (candidate,), LOOKED)

    def cost(u: Array) -> float:
        return float(np.sum(np.minimum(problem.residual(u) ** 2, OUTLIER)) + problem.priors(u)[0])

    with ThreadPoolExecutor(WORKERS) as workers:
        costs = list(workers.map(cost, begins))
    return min((_fitted(problem, begins[i]) for i in np.argsort(costs)[:2]), key=lambda f: f.cost)


def _fitted(problem: Problem, u: Array) -> Fit:
    for floor in (LOOKED, LOOKED / 5):
        # The beam that the poles show stays, as firmly as more is forgiven.
        u = minimise(replace(problem, floor=floor, held=_beam(u)), u, 4, 3e-2).u
    return minimise(replace(problem, floor=LOOKED / 20), u, 3, 3e-2)


def _beam(u: Array) -> tuple[float, float, float]:
    return float(u[0]), float(u[1]), float(u[2])


def _seen(problem: Problem, fit: Fit) -> Fit:
    r = problem.residual(fit.u)
    return Fit(problem, fit.u, float(r @ r + problem.priors(fit.u)[0]), r, fit.normal)


def _begins(bench: Bench, candidate: Candidate, values: tuple[float, ...]) -> Iterator[Array]:
    """Where a fit may begin: the beam as believed, and those that the poles of small and of large motion show."""
    own = np.array([s.coordinate(v) for s, v in zip(candidate.slots, values, strict=True)])
    yield np.concatenate([np.zeros(bench.free.size), own])
    if not len(bench.poles):
        return
    for alike, like in _linear(bench, candidate, own):
        beam = start((alike,), like, bench.free, bench.poles).u[: bench.free.size]
        yield np.concatenate([beam, own])


def _linear(bench: Bench, candidate: Candidate, own: Array) -> Iterator[tuple[Candidate, Array]]:
    """Linear effects with nearly the same poles."""
    yield candidate, own
    names = [s.name for s in candidate.slots]
    for soft, stiff in (("k_slip", "k_stick"), ("k_within", "k_contact")):
        if soft in names:
            held = own.copy()
            held[names.index(soft)] = own[names.index(stiff)]
            yield candidate, held
    if "EI_loss_open" in names:
        share = candidate.at(own).parameters["EI_loss_open"]
        # Half of the time it bends as a crack that stays open.
        half = share / (2 - share)
        for like in of_bench(bench.data.rig):
            if like.effect == "stiffness_loss":
                yield like, np.array([like.slots[0].coordinate(half), own[names.index("x")]])


def _on_all(bench: Bench, fit: Fit) -> Fit:
    """The fit brought to its end on all data; of its stages the one that leaves least, should the law not be exact."""
    exact = Problem(bench.data, bench.free, fit.problem.candidates)
    stages = [_seen(exact, fit)]
    for floor in (LOOKED / 10, LOOKED / 50, LOOKED / 250):
        fit = minimise(replace(exact, floor=floor, held=_beam(fit.u)), fit.u, 2, 3e-2)
        stages.append(_seen(exact, fit))
    best = min(stages, key=lambda f: f.cost)
    return min(best, minimise(exact, best.u, 5, 1e-2), key=lambda f: f.cost)
