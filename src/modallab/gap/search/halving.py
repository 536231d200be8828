"""Fits annealed side by side, the hopeless let go on the way.

Each level of what is forgiven is a round of successive halving (Jamieson and Talwalkar, AISTATS 2016, 240): while much
is forgiven all are excused, and none goes; later the wrong ones leave many times what the right one does, and following
them along ever narrower valleys would take most of the time.
"""

from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from operator import itemgetter

from modallab.gap.model.fit import Fit, Problem, seen
from modallab.gap.search.fitting import Bench, cooled, forgiven, frozen, misfit

HOPELESS = 5.0
"""What leaves so many times more than the best is no rival of one that explains the gap."""


def annealed_together(
    bench: Bench, fits: list[Fit], floor: float, workers: Executor, kept: int, most: int | None = None
) -> list[Fit]:
    """Short fits with ever less forgiven on thinned data, best first; what was let go comes last, as it was then.

    Args:
        bench: what to search.
        fits: short fits of different candidates.
        floor: relative model error that is forgiven at first.
        workers: what computes them.
        kept: so many are never let go as hopeless.
        most: so many are followed at most once nothing is forgiven any more, the longest part of the way.
    """
    # None begins with more forgiven than it needs.
    going = [(f, min(1.0, misfit(f.problem, f.u) / floor) if floor else 1.0) for f in fits]
    gone: list[Fit] = []
    for level in forgiven(bench, floor):
        cool = workers.map(partial(_cooled, bench, level), going)
        ranked = sorted(((_left(bench, f, level), f, share) for f, share in cool), key=itemgetter(0))
        enough = max(HOPELESS * ranked[0][0], ranked[min(kept, len(ranked)) - 1][0]) if ranked else 0.0
        going = [(f, share) for left, f, share in ranked if left <= enough]
        gone += [f for left, f, _ in ranked if left > enough]
    by_now = sorted((_with_nothing_forgiven(bench, f) for f, _ in going), key=_cost)
    best = sorted(workers.map(partial(frozen, bench), by_now[:most]), key=_cost)
    rest = [*by_now[len(best) :], *(_with_nothing_forgiven(bench, f) for f in gone)]
    return [*best, *sorted(rest, key=_cost)]


def _cooled(bench: Bench, level: float, going: tuple[Fit, float]) -> tuple[Fit, float]:
    fit, share = going
    return cooled(bench, fit, share * level), share


def _left(bench: Bench, fit: Fit, level: float) -> float:
    """What a fit leaves where as much is forgiven as to all others, the beam held nowhere."""
    u = bench.free.straightened(fit.u)
    return seen(replace(fit.problem, floor=level, held=(float(u[0]), float(u[1]), float(u[2]))), u).cost


def _with_nothing_forgiven(bench: Bench, fit: Fit) -> Fit:
    return seen(Problem(bench.thin, bench.free, fit.problem.candidates), bench.free.straightened(fit.u), fit.normal)


def _cost(fit: Fit) -> float:
    return fit.cost
