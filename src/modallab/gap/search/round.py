"""One round of a search: every candidate is screened, the likely are fitted, the best to the end.

Many candidates get a short look, fewer a longer one, the best all of it: successive halving (Jamieson and Talwalkar,
AISTATS 2016, 240).
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.progress import counted, part, report
from modallab.gap.model.candidates import of_bench, of_channel, of_pairs, testable
from modallab.gap.model.fit import Fit, Problem, all_rows, softened
from modallab.gap.model.forward import forward
from modallab.gap.model.prefit import start, starts
from modallab.gap.search.fitting import (
    COARSE,
    STRAIGHT,
    Bench,
    annealed,
    at_poles,
    at_rest,
    completed,
    finish,
    misfit,
    on_all,
    ordinary,
    short,
)
from modallab.gap.search.screen import Begin, Screen
from modallab.twin.candidate import Candidate
from modallab.twin.effects import model_of

Array = NDArray[np.float64]

LIKELY = 14
"""Candidates that get more than a glance; where the misfit is small the screen says which, and others get none."""
BEGINS = 2
"""Places to begin from which a candidate is fitted."""
HOPELESS = 5.0
"""What leaves so many times more than the best after the longer look is no rival, and is not fitted to the end."""
PROMISING = 0.3
"""Share of the gap below which what an explanation leaves is worth another attempt."""
LONGER = 6
"""Candidates of a round that get a second look."""
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


def pool(bench: Bench, fit: Fit) -> list[Candidate]:
    """The candidates worth a look after a fit: all of the bench, and those of the channels that stand out."""
    rig = bench.data.rig
    shares = [channel_share(fit)]
    if len(bench.poles):
        # A channel far off drags the fit with it; the beam that the poles show reveals it all the same.
        u = start(fit.problem.candidates, fit.u[bench.free.size :], bench.free, bench.poles).u
        shares.append(channel_share(replace(fit, u=u)))
    order = list(dict.fromkeys(int(i) for s in shares for i in np.argsort(s)[::-1][:2]))
    suspects = [bench.data.channels[i] for i in order]
    pairs = of_pairs(rig, tuple(sorted({bench.data.channels[i] for s in shares for i in np.argsort(s)[::-1][:3]})))
    found = of_bench(rig) + [c for s in suspects for c in of_channel(rig, s)] + pairs
    present = {(c.effect, c.place) for c in fit.problem.candidates}
    return [
        c
        for c in found
        if bench.allowed(c.effect)
        and (c.effect, c.place) not in present
        and not (model_of(c.effect).once and any(p.effect == c.effect for p in fit.problem.candidates))
        and testable(c, bench.data)
    ]


def channel_share(fit: Fit) -> Array:
    """(channels,) share of the relative misfit that stands in each channel, big responses no more than small ones."""
    twin, floor = fit.problem.twin(fit.u), misfit(fit.problem, fit.u)
    total = np.zeros(len(fit.problem.data.channels))
    for rows, y in zip(all_rows(fit.problem.data), forward(twin, fit.problem.data), strict=True):
        r = softened(rows, floor / 3).whiten(rows.y - y)
        total += np.sum(np.minimum(np.abs(r) ** 2, 400.0), axis=1)
    return total / max(float(np.sum(total)), 1e-300)


def ended(bench: Bench, fit: Fit, floor: float, before: float = np.inf) -> Fit:
    """A short fit brought to its end; where its beam has strayed, also from the beam that the poles show.

    What leaves most of the gap `before` is not worth its last digits.

    Far outside its tolerances a beam hardly answers to its numbers any more, and a fit there never finds its way back.
    """
    there = annealed(bench, fit, floor)
    u = at_rest(bench.free, fit.u) if bench.free.deviations else fit.u
    if not _sound(bench, there) and not np.array_equal(u, fit.u):
        # The fit before had bent beam, gains and deviations to a gap that was not theirs.
        there = min(there, annealed(bench, replace(fit, u=u), COARSE / 6), key=lambda f: f.cost)
    if bench.free.deviations and not _sound(bench, there):
        there = min((there, *_from_frequencies(bench, there), *_from_rest(bench, there)), key=_cost)
    strayed = bool(np.any(np.abs(there.u[:3]) >= STRAIGHT))
    if there.gap > bench.flat and strayed and len(bench.poles):
        begin = at_poles(bench, there.problem.candidates, there.u[bench.free.size :])
        there = min(there, annealed(bench, begin, COARSE / 6), key=lambda f: f.cost)
    there = completed(bench, there)
    if bench.flat < there.gap < PROMISING * before:
        there = min(there, finish(bench, fit, floor), key=_cost)
    return there


def _sound(bench: Bench, fit: Fit) -> bool:
    """Whether a fit leaves nothing to explain, by an assembly that may be."""
    return fit.gap <= bench.flat and (ordinary(fit) or not bench.free.deviations)


def _from_frequencies(bench: Bench, fit: Fit) -> list[Fit]:
    """A fit once more, its last effect as large as the frequencies of the ring-down want it; none if they do not.

    What sits at the root or at every sensor an assembly does as well by many deviations, of the sensors' masses or of
    the fields: from there nothing says that one number would do.
    """
    candidates = fit.problem.candidates
    if not len(bench.poles) or len(candidates[-1].slots) != 1 or not model_of(candidates[-1].effect).moves_poles:
        return []
    former = fit.u[bench.free.size : -1]
    (begin,) = starts(candidates, bench.free, bench.poles, 1, former)
    return [annealed(bench, short(bench, candidates, begin.u, COARSE), COARSE / 6)]


def _from_rest(bench: Bench, fit: Fit) -> list[Fit]:
    """A fit once more, its last effect begun where it does most for an assembly at rest.

    Many small numbers of an assembly that was bent do the work of one effect, and leave so little of it to see that
    neither its size nor its place would move.
    """
    *former, last = fit.problem.candidates
    rest = at_rest(bench.free, fit.u)[: len(fit.u) - len(last.slots)]
    screen = Screen(Problem(bench.thin, bench.free, tuple(former), COARSE), rest, bench.poles)
    found: list[Fit] = []
    for begin in screen.begins(last)[:BEGINS]:
        found.append(annealed(bench, short(bench, fit.problem.candidates, begin.u, COARSE), COARSE / 6))
        if _sound(bench, found[-1]):
            break
    return found


def round_of(bench: Bench, base: Fit, finished: int = 2) -> Level:
    """One round: all are screened, the likely fitted in short, the better for longer, the best to the end."""
    floor = misfit(base.problem, base.u)
    screen = Screen(Problem(bench.thin, bench.free, base.problem.candidates, floor), base.u, bench.poles)

    def glance(begins: tuple[Begin, ...]) -> Fit:
        fits = (short(bench, b.problem.candidates, b.u, screen.floor, 1) for b in begins[: BEGINS + 1])
        return min(fits, key=_cost)

    def look(f: Fit) -> Fit:
        return short(bench, f.problem.candidates, f.u, screen.floor)

    def longer(f: Fit) -> Fit:
        return short(bench, f.problem.candidates, f.u, screen.floor / 6)

    def to_the_end(f: Fit) -> Fit:
        return ended(bench, f, screen.floor / 12, base.gap)

    listed = pool(bench, base)
    beside = "".join(f" beside {c.effect.replace('_', ' ')}" for c in base.problem.candidates[-1:])
    with ThreadPoolExecutor(WORKERS) as workers:
        with part(0.0, 0.2):
            screened = counted(workers.map(screen.begins, listed), len(listed), f"explanations{beside} screened")
            begins = sorted(screened, key=lambda b: b[0].cost)
        hopeful = begins if screen.large else begins[:LIKELY]
        with part(0.2, 0.5):
            glanced = counted(workers.map(glance, hopeful), len(hopeful), f"explanations{beside}, at a glance")
            glances = sorted(glanced, key=_cost)
        with part(0.5, 0.8):
            looked = counted(workers.map(look, glances[:LIKELY]), len(glances[:LIKELY]), f"the likeliest{beside}")
            looks = sorted(looked, key=_cost)
        better = sorted(workers.map(longer, looks[:LONGER]), key=_cost)
        report(0.8, f"the best{beside}: {', '.join(_names(f) for f in better[:finished])}")
        hopeful = [f for f in better[:finished] if f.cost < HOPELESS * better[0].cost]
        best = [*workers.map(to_the_end, hopeful), *(on_all(bench, f) for f in better[len(hopeful) : finished])]
    rest = (*better, *looks[LONGER:], *glances[LIKELY:])
    return Level(base, tuple(sorted(_own_right(best), key=_cost)), tuple((f.problem.candidates, f.cost) for f in rest))


def _own_right(fits: list[Fit]) -> list[Fit]:
    """Those whose numbers earn their price: where fewer at the same place do as well, more are no other explanation."""
    return [f for f in fits if not any(_contains(f, g) for g in fits)]


def _contains(fit: Fit, other: Fit) -> bool:
    """Whether the last effect of a fit has more numbers than another's at its place, and takes away no more for it."""
    one, two = fit.problem.candidates[-1], other.problem.candidates[-1]
    more = len(one.slots) - len(two.slots)
    if more <= 0 or not one.place or one.place != two.place:
        return False
    # The price of a number: Schwarz, Ann. Stat. 6, 1978, 461.
    return other.cost < fit.cost + more * float(np.log(max(np.count_nonzero(fit.residual), 1)))


def _names(fit: Fit) -> str:
    return " and ".join(c.effect.replace("_", " ") for c in fit.problem.candidates)


def _cost(fit: Fit) -> float:
    return fit.cost
