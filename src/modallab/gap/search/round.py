"""One round of a search: every candidate is screened, the likely are fitted, the best to the end.

Many candidates get a short look, fewer a longer one, the best all of it: successive halving (Jamieson and Talwalkar,
AISTATS 2016, 240).
"""

from collections.abc import Iterable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from modallab.core.progress import counted, part, report
from modallab.gap.model.fit import Fit, Problem, cost_of, seen
from modallab.gap.search.ending import ended, is_sound
from modallab.gap.search.fitting import Bench, excess, misfit, on_all, short
from modallab.gap.search.halving import HOPELESS, annealed_together
from modallab.gap.search.pool import pool
from modallab.gap.search.screen import SIZES, Begin, Screen
from modallab.gap.search.worth import ABOVE
from modallab.twin.effects import model_of, search_of

LIKELY = 14
"""Candidates that get more than a glance; where the misfit is small the screen says which, and others get none."""
BEGINS = 2
"""Places to begin from which a candidate is fitted."""
MAY_PASS = 1.5
"""Times the least of a candidate that another size of it may leave at a glance and still be looked at."""
LONGER = 6
"""Candidates of a round that get a second look."""
EXCUSED = 1.2
"""Rms residual below which a fit is one that the forgiven model error excuses."""
WITHOUT = 8
"""Candidates of a round that get a second look with nothing forgiven, where all are excused."""
ALIKE = 1.1
"""Times what a fit leaves that another may leave whose effect it is but for tolerances: both stop a little short."""
LITTLE = 0.5
"""Share of the gap that the finished must leave for others to be followed, and below which these must leave."""
FOLLOWED = 4
"""Of these so many are followed where nothing is forgiven any more."""
WORKERS = 2


@dataclass(frozen=True, eq=False, slots=True)
class Level:
    """One round of the search.

    Attributes:
        base: the fit it began from.
        fits: the fits that were finished, best first.
    """

    base: Fit
    fits: tuple[Fit, ...]


def round_of(bench: Bench, base: Fit, finished: int = 2, before: float | None = None) -> Level:
    """One round: all are screened, the likely fitted in short, the better for longer, the best to the end.

    Args:
        bench: what to search.
        base: the fit to begin from.
        finished: so many are fitted to the end.
        before: the gap that the round should shrink, where that is not what `base` leaves.
    """
    before = base.gap if before is None else before
    floor = misfit(base.problem, base.u)
    screen = Screen(Problem(bench.thin, bench.free, base.problem.candidates, floor), base.u, bench.poles)

    def glance(begins: tuple[Begin, ...]) -> list[Fit]:
        fits = (short(bench, b.problem.candidates, b.u, screen.floor, 1) for b in begins[: BEGINS + SIZES])
        return _by_size(sorted(fits, key=cost_of))

    def look(f: Fit) -> Fit:
        return short(bench, f.problem.candidates, f.u, screen.floor)

    def longer(f: Fit) -> Fit:
        return short(bench, f.problem.candidates, f.u, screen.floor / 6)

    def to_the_end(f: Fit) -> Fit:
        return ended(bench, f, screen.floor / 12, before)

    listed = pool(bench, base)
    beside = "".join(f" beside {c.effect.replace('_', ' ')}" for c in base.problem.candidates[-1:])
    with ThreadPoolExecutor(WORKERS) as workers:
        with part(0.0, 0.2):
            screened = counted(workers.map(screen.begins, listed), len(listed), f"explanations{beside} screened")
            begins = sorted(screened, key=lambda b: b[0].cost)
        hopeful = begins if screen.large else begins[:LIKELY]
        with part(0.2, 0.5):
            glanced = counted(workers.map(glance, hopeful), len(hopeful), f"explanations{beside}, at a glance")
            likely = _likely(list(glanced))
        with part(0.5, 0.8):
            looked = counted(workers.map(look, likely), len(likely), f"the likeliest{beside}")
            looks = best_of_each(looked)
        better = sorted(workers.map(longer, looks[:LONGER]), key=cost_of)
        if _excused(better[: finished + 1]):
            better = annealed_together(bench, looks[:WITHOUT], screen.floor / 12, workers, finished)
        report(0.8, f"the best{beside}: {', '.join(_names(f) for f in better[:finished])}")
        hopeful = [f for f in better[:finished] if f.cost < HOPELESS * better[0].cost]
        best = list(workers.map(to_the_end, hopeful))
        # Where what led is no explanation either, what crept may be the better one.
        last = partial(on_all, bench) if any(is_sound(bench, f) for f in best) else to_the_end
        best += workers.map(last, better[len(hopeful) : finished])
        if not any(is_sound(bench, f) for f in best):
            best += workers.map(to_the_end, _may_have_crept(bench, looks, better[:finished]))
            if all(excess(f) > LITTLE * (before**2 - 1) for f in best):
                others = [f for f in looks if not any(_same(f, g) for g in better[:finished])]
                best += workers.map(to_the_end, taking_half(bench, base, others, screen.floor / 12, workers, finished))
    return Level(base, tuple(sorted(_own_right(best), key=cost_of)))


def _likely(glances: list[list[Fit]]) -> list[Fit]:
    """The fits of the likeliest candidates, the likeliest first.

    Likely is what leaves least at a glance, and what left least when it was screened, in the order of which they are
    given: one step may not lead as far as a large effect is away.
    """
    order = sorted(range(len(glances)), key=lambda i: glances[i][0].cost)
    chosen = [*order[:LIKELY], *(i for i in order[LIKELY:] if i < LIKELY)]
    return [f for i in chosen for f in glances[i]]


def taking_half(bench: Bench, base: Fit, looks: list[Fit], floor: float, workers: Executor, finished: int) -> list[Fit]:
    """The best of these once nothing is forgiven, as far as they take half of what `base` leaves on the same data.

    What is large in shares of the response may be little in noise units, and the other way round.
    """
    annealed = annealed_together(bench, looks, floor, workers, finished, FOLLOWED)
    most = LITTLE * excess(seen(Problem(bench.thin, bench.free, base.problem.candidates), base.u))
    return [f for f in annealed[:finished] if excess(f) < most]


def _may_have_crept(bench: Bench, looks: list[Fit], tried: list[Fit]) -> list[Fit]:
    """Those not tried whose one number moves all frequencies, as without an assembly only the beam's numbers do."""
    if bench.free.deviations:
        return []
    own = {(f.problem.candidates[-1].effect, f.problem.candidates[-1].place) for f in tried}
    last = [(f, f.problem.candidates[-1]) for f in looks]
    alike = [(f, c) for f, c in last if len(c.slots) == 1 and model_of(c.effect).moves_poles]
    return [f for f, c in alike if (c.effect, c.place) not in own]


def _same(fit: Fit, other: Fit) -> bool:
    """Whether the last effect of two fits is the same at the same place."""
    one, two = fit.problem.candidates[-1], other.problem.candidates[-1]
    return (one.effect, one.place) == (two.effect, two.place)


def _excused(fits: list[Fit]) -> bool:
    """Whether what is forgiven excuses all of these, so that what they leave says nothing of which is right."""
    return len(fits) > 1 and fits[-1].gap < EXCUSED


def _by_size(fits: list[Fit]) -> list[Fit]:
    """The best of a candidate's fits, and the best of another size where it may become better in a few steps more."""
    best = fits[0]
    others = [f for f in fits[1:] if f.cost < MAY_PASS * best.cost and _another_size(f, best)]
    return [best, *others[: SIZES - 1]]


def _another_size(fit: Fit, other: Fit) -> bool:
    """Whether the only number of a fit's last effect is far from the other fit's."""
    slots = fit.problem.candidates[-1].slots
    if len(slots) != 1:
        return False
    one, two = (slots[0].value(f.u[-1]) for f in (fit, other))
    return not 0.5 * abs(two) < one * np.sign(two) < 2 * abs(two)


def best_of_each(fits: Iterable[Fit]) -> list[Fit]:
    """The best of each candidate's fits, in the order of what they leave."""
    found: dict[tuple[str, object], Fit] = {}
    for fit in sorted(fits, key=cost_of):
        last = fit.problem.candidates[-1]
        found.setdefault((last.effect, last.place), fit)
    return list(found.values())


def _own_right(fits: list[Fit]) -> list[Fit]:
    """Those whose numbers earn their price: where fewer at the same place do as well, more are no other explanation."""
    return [f for f in fits if not any(_contains(f, g) for g in fits)]


def _contains(fit: Fit, other: Fit) -> bool:
    """Whether the last effect of a fit has more numbers than another's at its place, and takes away no more for it."""
    one, two = fit.problem.candidates[-1], other.problem.candidates[-1]
    more = len(one.slots) - len(two.slots)
    if more <= 0 or not one.place or one.place != two.place:
        return False
    if search_of(one.effect).deviations_from(fit.effects[-1], two.effect, fit.problem.data.rig) <= ABOVE:
        return other.cost < ALIKE * fit.cost
    # The price of a number: Schwarz, Ann. Stat. 6, 1978, 461.
    return other.cost < fit.cost + more * float(np.log(max(np.count_nonzero(fit.residual), 1)))


def _names(fit: Fit) -> str:
    return " and ".join(c.effect.replace("_", " ") for c in fit.problem.candidates)
