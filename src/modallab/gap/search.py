"""Which effects explain the data: each is fitted with the nuisances, several one after another."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.candidates import Candidate, chained, of_channel, structural, swaps
from modallab.gap.course import with_course
from modallab.gap.fit import Fit, Problem, all_rows, softened
from modallab.gap.forward import forward
from modallab.gap.minimise import minimise
from modallab.gap.nuisances import Nuisances
from modallab.gap.prefit import start, starts
from modallab.gap.reduce import Reduced
from modallab.gap.screen import OUTLIER, Begin, Screen

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

COARSE = 0.3
"""Largest relative model error that is forgiven while a fit finds its way."""
FLAT = 1.1
"""Rms residual below which nothing is left to explain."""
WATCHED = 1.02
"""Rms residual above which an effect that takes nearly all of it away still counts."""
WORTH = 0.9
"""A further effect must leave less than this share of what was left, or the search ends."""
HOLDS = 0.15
"""An effect stays if without it more than this share of the gap would come back."""
NEARLY = 0.01
"""Share of the first excess that counts as nearly explained."""
SECOND = 0.3
"""The same from the second round on."""
SOLVED = 1.3
"""Times the floor at which a search is done."""
SOLVED_SHARE = 0.003
"""Share of the first excess at which it is done as well."""
LAST_DIGIT = 2.5e-4
"""Where thousands of noise units are explained, what is left of this share is the last digit of either model."""
MOST = 3
"""Effects in one diagnosis."""
LIKELY = 14
"""Candidates that are fitted at all where the misfit is small, those that the screen puts first."""
BEGINS = 2
"""Places to begin from which a candidate is fitted."""
HOPELESS = 5.0
"""What leaves so many times more than the best after the longer look is no rival, and is not fitted to the end."""
LONGER = 6
"""Candidates of a round that get a second look."""
STRAIGHT = 3.0
"""Deviations of its priors up to which a beam is one to begin from."""
WORKERS = 2


@dataclass(frozen=True, eq=False, slots=True)
class Level:
    """One round of the search.

    Attributes:
        base: the fit it began from.
        fits: the fits that were finished, best first.
        screened: (candidates, cost) of the others after a short look.
    """

    base: Fit
    fits: tuple[Fit, ...]
    screened: tuple[tuple[tuple[Candidate, ...], float], ...]


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
        watched: rms residual below which nothing is looked for.
    """

    data: Reduced
    thin: Reduced
    free: Nuisances
    poles: Complex
    allowed: Callable[[str], bool]
    flat: float = FLAT
    watched: float = WATCHED


def baseline(bench: Bench) -> Fit:
    """The twin without effects, as well as it can be made to fit."""
    fit = min((_short(bench, (), u, COARSE) for u in _first(bench)), key=lambda f: f.cost)
    return finish(bench, fit, COARSE / 6)


def _first(bench: Bench) -> list[Array]:
    """Where the baseline begins: at the poles, or without any at the best of many values of Young's modulus."""
    if len(bench.poles):
        return [s.u for s in starts((), bench.free, bench.poles, 1)]
    problem = Problem(bench.thin, bench.free, (), COARSE)
    tried: list[tuple[float, Array]] = []
    for shift in np.linspace(-3.2, 3.2, 33):
        u = np.zeros(bench.free.size)
        u[0] = shift
        tried.append((float(np.sum(np.minimum(problem.residual(u) ** 2, OUTLIER))), u))
    return [u for _, u in sorted(tried, key=lambda t: t[0])[:2]]


def finish(bench: Bench, fit: Fit, floor: float) -> Fit:
    """A short fit brought to its end on all data."""
    candidates = fit.problem.candidates
    floor = min(floor, misfit(fit.problem, fit.u))
    for level in (floor, floor / 6):
        problem = Problem(bench.data, bench.free, candidates, level, held=_beam(fit.u))
        fit = minimise(problem, fit.u, 3, 3e-2)
    u = bench.free.straightened(fit.u)
    return with_course(minimise(Problem(bench.data, bench.free, candidates), u, 15, 2e-4))


def on_all(bench: Bench, fit: Fit) -> Fit:
    """A short fit as it is, on all data."""
    return _seen(Problem(bench.data, bench.free, fit.problem.candidates), fit)


def misfit(problem: Problem, u: Array) -> float:
    """Relative model error at which these numbers would be excused: where a look for more must begin."""
    for floor in (COARSE, 0.1, 0.03, 0.01, 0.003):
        r = replace(problem, floor=floor).residual(u)
        used = r[r != 0]
        if len(used) and np.sqrt(np.mean(np.minimum(used**2, 100.0))) > 0.5:
            return floor
    return 0.001


def _short(bench: Bench, candidates: tuple[Candidate, ...], u: Array, floor: float) -> Fit:
    # Numbers that are nearly right must not be let go again: forgiven is no more than they need.
    problem = Problem(bench.thin, bench.free, candidates)
    near = min(floor, misfit(problem, u))
    fit = minimise(replace(problem, floor=near, held=_beam(u)), u, 3, 5e-2)
    # To be compared, all must be forgiven as much and held nowhere in particular.
    return _seen(replace(problem, floor=floor, held=_beam(fit.u)), fit)


def _beam(u: Array) -> tuple[float, float, float]:
    """Where a beam is held: where it is, unless a wrong model has bent it there."""
    return (float(u[0]), float(u[1]), float(u[2])) if np.all(np.abs(u[:3]) < STRAIGHT) else (0.0, 0.0, 0.0)


def _seen(problem: Problem, fit: Fit) -> Fit:
    r = problem.residual(fit.u)
    return Fit(problem, fit.u, float(r @ r + problem.priors(fit.u)[0]), r, fit.normal)


def pool(bench: Bench, fit: Fit) -> list[Candidate]:
    """The candidates worth a look after a fit: all of the bench, and those of the channels that stand out."""
    rig = bench.data.rig
    shares = [channel_share(fit)]
    if len(bench.poles):
        # A channel far off drags the fit with it; the beam the poles tell of shows it all the same.
        u = start(fit.problem.candidates, fit.u[bench.free.size :], bench.free, bench.poles).u
        shares.append(channel_share(replace(fit, u=u)))
    order = list(dict.fromkeys(int(i) for s in shares for i in np.argsort(s)[::-1][:2]))
    suspects = [bench.data.channels[i] for i in order]
    pairs = swaps(tuple(sorted({bench.data.channels[i] for s in shares for i in np.argsort(s)[::-1][:3]})))
    found = structural(rig) + chained(rig) + [c for s in suspects for c in of_channel(rig, s)] + pairs
    present = {(c.effect, c.place) for c in fit.problem.candidates}
    return [
        c
        for c in found
        if bench.allowed(c.effect)
        and (c.effect, c.place) not in present
        and not (c.effect in _ONCE and any(p.effect == c.effect for p in fit.problem.candidates))
        and _testable(c, bench.data)
    ]


_ONCE = frozenset(
    {"clamp_rotation", "clamp_translation", "sensor_mass", "thermal_drift", "shaker_mass", "stinger_moment"}
    | {"added_mass", "stiffness_loss", "ground_spring", "local_damper", "swap"}
)


def _testable(candidate: Candidate, data: Reduced) -> bool:
    if candidate.effect == "hit_position":
        return bool(data.impacts)
    if candidate.effect in {"shaker_mass", "stinger_moment", "clock_error"}:
        return data.sines is not None
    return True


def channel_share(fit: Fit) -> Array:
    """(channels,) share of the relative misfit that stands in each channel, big responses no more than small ones."""
    twin, floor = fit.problem.twin(fit.u), misfit(fit.problem, fit.u)
    total = np.zeros(len(fit.problem.data.channels))
    for rows, y in zip(all_rows(fit.problem.data), forward(twin, fit.problem.data), strict=True):
        r = softened(rows, floor / 3).whiten(rows.y - y)
        total += np.sum(np.minimum(np.abs(r) ** 2, 400.0), axis=1)
    return total / max(float(np.sum(total)), 1e-300)


def round_of(bench: Bench, base: Fit, finished: int = 2) -> Level:
    """One round: all are screened, the likely fitted in short, the better for longer, the best to the end."""
    floor = misfit(base.problem, base.u)
    problem = Problem(bench.thin, bench.free, base.problem.candidates, floor)
    screen = Screen(problem, base.u, bench.poles)

    def look(begins: tuple[Begin, ...]) -> Fit:
        fits = (_short(bench, b.problem.candidates, b.u, screen.floor) for b in begins[: BEGINS + 1])
        return min(fits, key=lambda f: f.cost)

    def longer(f: Fit) -> Fit:
        return _short(bench, f.problem.candidates, f.u, screen.floor / 6)

    def to_the_end(f: Fit) -> Fit:
        return finish(bench, f, screen.floor / 12)

    with ThreadPoolExecutor(WORKERS) as workers:
        begins = sorted(workers.map(screen.begins, pool(bench, base)), key=lambda b: b[0].cost)
        likely = begins if screen.large else begins[:LIKELY]
        looks = sorted(workers.map(look, likely), key=lambda f: f.cost)
        better = sorted(workers.map(longer, looks[:LONGER]), key=lambda f: f.cost)
        hopeful = [f for f in better[:finished] if f.cost < HOPELESS * better[0].cost]
        best = [*workers.map(to_the_end, hopeful), *(on_all(bench, f) for f in better[len(hopeful) : finished])]
    fits = tuple(sorted(best, key=lambda f: f.cost))
    rest = (*better, *looks[LONGER:])
    return Level(base, fits, tuple((f.problem.candidates, f.cost) for f in rest))


def explain(bench: Bench) -> list[Level]:
    """Round after round until nothing is left, or no further effect helps; if that fails, once more from the blows."""
    levels = rounds(bench, baseline(bench), MOST)
    if _solved(bench, levels) or bench.data.sines is None or not bench.data.impacts:
        return levels
    started = from_blows(bench)
    if started is None:
        return levels
    later = rounds(bench, started, MOST - len(started.problem.candidates))
    again = [Level(levels[0].base, (started,), ()), *later] if started.problem.candidates else later
    return again if _best(again).cost < 0.5 * _best(levels).cost else levels


def rounds(bench: Bench, base: Fit, most: int) -> list[Level]:
    """At most so many rounds from a fit."""
    levels: list[Level] = []
    first = base.gap
    while base.gap > (bench.flat + LAST_DIGIT * first if levels else bench.watched) and len(levels) < most:
        level = round_of(bench, base)
        levels.append(level)
        # Once nearly all is explained, a further effect must be worth its name to go on from.
        worth = WORTH if excess(base) > NEARLY * excess(levels[0].base) else HOLDS
        if len(levels) > 1:
            # Two effects hide each other; once both are there, the rest must fall.
            worth = min(worth, SECOND)
        if not level.fits or excess(level.fits[0]) > worth * excess(base):
            break
        base = level.fits[0]
    return levels or [Level(base, (), ())]


def from_blows(bench: Bench) -> Fit | None:
    """What explains the blows alone, on all data: no shaker hangs on the beam there. None if nothing explains them."""
    only = replace(bench, data=replace(bench.data, sines=None), thin=replace(bench.thin, sines=None))
    levels = rounds(only, baseline(only), 1)
    if not _solved(only, levels):
        return None
    best = _best(levels)
    return on_all(bench, best)


def _best(levels: list[Level]) -> Fit:
    return min((f for level in levels for f in (level.base, *level.fits)), key=lambda f: f.cost)


def _solved(bench: Bench, levels: list[Level]) -> bool:
    """Whether next to nothing is left."""
    best = _best(levels)
    return best.gap <= bench.flat * SOLVED or excess(best) < SOLVED_SHARE * excess(levels[0].base)


def excess(fit: Fit) -> float:
    """What is left above the floor, in squares of noise units."""
    return max(fit.gap**2 - 1, 1e-9)
