"""Fits annealed side by side, the hopeless let go on the way.

Each level of what is forgiven is a round of successive halving (Jamieson and Talwalkar, AISTATS 2016, 240): while much
is forgiven all are excused, and none goes; later the wrong ones leave many times what the right one does, and following
them along ever narrower valleys would take most of the time.
"""

from concurrent.futures import Executor
from functools import partial
from operator import itemgetter

from modallab.gap.model.fit import Fit, Problem, cost_of, seen
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
        ranked = sorted(((_seen_at(bench, level, f).cost, f, share) for f, share in cool), key=itemgetter(0))
        enough = max(HOPELESS * ranked[0][0], ranked[min(kept, len(ranked)) - 1][0]) if ranked else 0.0
        going = [(f, share) for left, f, share in ranked if left <= enough]
        gone += [f for left, f, _ in ranked if left > enough]
    by_now = sorted((_seen_at(bench, 0.0, f) for f, _ in going), key=cost_of)
    best = sorted(workers.map(partial(frozen, bench), by_now[:most]), key=cost_of)
    rest = [*by_now[len(best) :], *(_seen_at(bench, 0.0, f) for f in gone)]
    return [*best, *sorted(rest, key=cost_of)]


def _cooled(bench: Bench, level: float, going: tuple[Fit, float]) -> tuple[Fit, float]:
    fit, share = going
    return cooled(bench, fit, share * level), share


def _seen_at(bench: Bench, level: float, fit: Fit) -> Fit:
    """A fit as it is, where as much is forgiven as to all others and the beam is held nowhere else."""
    u = bench.free.straightened(fit.u)
    held = (float(u[0]), float(u[1]), float(u[2]))
    return seen(Problem(bench.thin, bench.free, fit.problem.candidates, level, held=held), u, fit.normal)
