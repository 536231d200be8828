"""Which effect that depends on the size of the motion explains what no linear beam does.

Such an effect has to be stepped in time. A first look is taken at the sine blocks that a linear beam explains worst,
both levels of each frequency, with every start on its grid; the best are fitted there, and the best of those on all
data.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from modallab.core.progress import report
from modallab.gap.conditioning.reduce import Reduced, Rows, SineData
from modallab.gap.model.candidates import of_bench, of_motion
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import WORKERS, minimise
from modallab.gap.model.prefit import start
from modallab.gap.search.fitting import NEAR, Bench
from modallab.gap.search.round import Level
from modallab.twin.candidate import Candidate
from modallab.twin.effect_model import Overtones
from modallab.twin.effects import search_of

Array = NDArray[np.float64]

BLOCKS = 6
"""Sine blocks of a first look that a linear beam explains worst."""
FEWEST = 4
"""The same where starts are compared."""
SPREAD = 5
"""Every so many frequencies are looked at as well: about a resonance a start is right or wrong, not nearly right."""
LOOKED = 0.1
"""Relative error that is forgiven in a first look."""
RIVAL = 6.0
"""What leaves so many times more than the best is no rival, and is not fitted on."""
CLOSE = 2.0
"""The same of what is fitted to all records."""
WRONG = 0.5
"""Share of what a linear beam leaves on few records from which an effect explains nothing."""
LONGER = 2
"""Effects that are fitted on few records to the end."""
PLACES = 3
"""Places along the beam at which an effect that has one is begun from."""
TRIES = 20
"""Glances a number while a start is polished."""
OUTLIER = 100.0
"""Square at which a residual stops counting where starts are compared."""


def nonlinear_level(bench: Bench, base: Fit, overtones: Overtones) -> Level:
    """One round of the effects that depend on the size of the motion and make such overtones, beside those of a fit."""
    listed = [c for c in of_motion(bench.data.rig, overtones) if bench.allowed(c.effect)]
    if not listed or bench.data.sines is None:
        return Level(base, (), ())
    few, fewest = (_worst(bench.data, base, count) for count in (BLOCKS, FEWEST))
    begun: list[list[Fit]] = []
    for i, candidate in enumerate(listed):
        report(0.5 * i / len(listed), f"{candidate.effect.replace('_', ' ')}, stepped in time")
        begun.append(_begun(bench, base, (few, fewest), candidate))
    begun.sort(key=lambda fits: fits[0].cost)
    hopeful = [fits for fits in begun if fits[0].cost < RIVAL * begun[0][0].cost][:LONGER]
    report(0.5, "the likeliest of them")
    looks = _best_forms(sorted((_fitted(fits[0]) for fits in hopeful), key=_cost))
    left = tuple((f.problem.candidates, f.cost) for f in looks)
    linear = _seen(replace(looks[0].problem, candidates=base.problem.candidates, held=_beam(base.u)), base)
    if looks[0].cost > WRONG * linear.cost:
        return Level(base, (), left)
    report(0.7, f"{looks[0].problem.candidates[-1].effect.replace('_', ' ')}, on all records")
    fits = [on_all_records(bench, f) for f in looks[:2] if f.cost < CLOSE * looks[0].cost]
    return Level(base, tuple(sorted(fits, key=_cost)), left[len(fits) :])


def _best_forms(fits: list[Fit]) -> list[Fit]:
    """Of each effect the form of its law that leaves least; in that order."""
    best: dict[str, Fit] = {}
    for fit in fits:
        best.setdefault(fit.problem.candidates[-1].effect, fit)
    return list(best.values())


def _cost(fit: Fit) -> float:
    return fit.cost


def _worst(data: Reduced, base: Fit, count: int) -> Reduced:
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
        if len(chosen) >= count:
            break
    spread = np.unique(np.round(d.source.frequency_hz, 3))[SPREAD // 2 :: SPREAD]
    chosen += [k for k, hz in enumerate(d.source.frequency_hz) if round(float(hz), 3) in spread and k not in chosen]
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


def _begun(bench: Bench, base: Fit, some: tuple[Reduced, Reduced], candidate: Candidate) -> list[Fit]:
    """The effect after a few steps on few records from the best of its starts on even fewer, best first."""
    problem = Problem(some[0], bench.free, (*base.problem.candidates, candidate), LOOKED)
    glance, rough = replace(problem, data=some[1]), search_of(candidate.effect).rough
    begins = [
        (dict(zip((s.name for s in candidate.slots), own, strict=True)).get("x"), u)
        for own in product(*(slot.starts for slot in candidate.slots))
        for u in _begins(bench, base, candidate, own)
    ]

    def cost(u: Array) -> float:
        return float(np.sum(np.minimum(glance.residual(u) ** 2, OUTLIER)) + glance.priors(u)[0])

    def first(u: Array) -> Fit:
        if rough:
            u = _polished(glance, cost, u)
        return minimise(replace(problem, held=_beam(u)), u, 2, 3e-2)

    with ThreadPoolExecutor(WORKERS) as workers:
        costs = list(workers.map(cost, (u for _, u in begins)))
        # A place is seldom left again: several are begun from.
        likely: dict[float | None, list[int]] = {}
        for i in np.argsort(costs):
            likely.setdefault(begins[i][0] if begins[i][0] is not None or not rough else int(i), []).append(int(i))
        chosen = [best[0] for best in likely.values()][:PLACES]
        return sorted(workers.map(first, (begins[i][1] for i in chosen)), key=_cost)


def _polished(problem: Problem, cost: Callable[[Array], float], u: Array) -> Array:
    """The beam's stiffness and the effect's own numbers moved to where they leave less nearby (Nelder and Mead).

    Where contacts open and close a residual is rough, and slopes lead nowhere from afar.
    """
    slots = problem.candidates[-1].slots
    at = [0, *range(len(u) - len(slots), len(u))]
    steps = np.array([0.3, *(0.04 if s.name == "x" else 0.3 for s in slots)])

    def moved(v: Array) -> Array:
        there = u.copy()
        there[at] += v * steps
        return there

    simplex = np.vstack([np.zeros(len(at)), np.eye(len(at))])
    found = minimize(
        lambda v: cost(moved(v)),
        simplex[0],
        method="Nelder-Mead",
        options={"maxfev": TRIES * len(at), "initial_simplex": simplex, "fatol": 1.0},
    )
    return moved(found.x)


def _fitted(fit: Fit) -> Fit:
    """The same with ever less forgiven."""
    for floor, steps in ((LOOKED / 3, 2), (LOOKED / 20, 3)):
        # The beam that the poles show stays, as firmly as more is forgiven.
        fit = minimise(replace(fit.problem, floor=floor, held=_beam(fit.u)), fit.u, steps, 3e-2)
    return fit


def _beam(u: Array) -> tuple[float, float, float]:
    return float(u[0]), float(u[1]), float(u[2])


def _seen(problem: Problem, fit: Fit) -> Fit:
    r = problem.residual(fit.u)
    return Fit(problem, fit.u, float(r @ r + problem.priors(fit.u)[0]), r, fit.normal)


def _begins(bench: Bench, base: Fit, candidate: Candidate, values: tuple[float, ...]) -> Iterator[Array]:
    """Where a fit may begin: the beam as believed, and those that the poles of small and of large motion show."""
    own = np.array([s.coordinate(v) for s, v in zip(candidate.slots, values, strict=True)])
    beside = base.u[bench.free.size :]
    yield np.concatenate([np.zeros(bench.free.size), beside, own])
    if not len(bench.poles):
        return
    for alike, like in _linear(bench, candidate, own):
        try:
            poles = start((*base.problem.candidates, alike), np.concatenate([beside, like]), bench.free, bench.poles)
        except np.linalg.LinAlgError:
            # Two losses of stiffness at one place may leave none: no beam to begin from.
            continue
        yield np.concatenate([poles.u[: bench.free.size], beside, own])


def _linear(bench: Bench, candidate: Candidate, own: Array) -> Iterator[tuple[Candidate, Array]]:
    """Linear effects with nearly the same poles."""
    names = [s.name for s in candidate.slots]
    if "EI_loss_open" not in names:
        yield candidate, own
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


def on_all_records(bench: Bench, fit: Fit) -> Fit:
    """A fit to few records brought to its end on all data; of its stages the one that leaves least.

    The law may not be exact.
    """
    exact = Problem(bench.data, bench.free, fit.problem.candidates)
    first = _seen(exact, fit)
    # A hit runs through every state of a law at once: what is a little wrong there must not lead the sines astray.
    sines = replace(exact, data=replace(bench.data, impacts=()))
    rough = search_of(fit.problem.candidates[-1].effect).rough
    for floor in (*((LOOKED, LOOKED / 3) if rough else ()), LOOKED / 5, LOOKED / 50):
        fit = minimise(replace(sines, floor=floor, held=_beam(fit.u)), fit.u, 2, 3e-2)
    if rough:
        # The damping of the high modes shows in the hits alone.
        after = minimise(replace(exact, floor=LOOKED, held=_beam(fit.u)), fit.u, 2, 3e-2)
        near = replace(sines, floor=LOOKED / 50)
        return _seen(exact, after if _seen(near, after).cost < 2 * _seen(near, fit).cost else fit)
    best = min(first, _seen(exact, fit), key=_cost)
    fit = minimise(replace(exact, floor=LOOKED / 5, held=_beam(fit.u)), fit.u, 2, 3e-2)
    best = min(best, _seen(exact, fit), key=_cost)
    best = min(best, minimise(exact, best.u, 2, 1e-2), key=_cost)
    # Where the law is exact, what is left to go lies along a valley: a place and a stiffness do nearly the same.
    return minimise(exact, best.u, 6, 1e-3) if best.gap < NEAR * bench.flat else best
