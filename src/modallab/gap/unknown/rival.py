"""Whether what is no effect of the catalogue explains what no single effect does: then no more of them are looked for.

A beam that is pulled, that carries a mass on a spring or that twists is far from any beam of the catalogue, and effects
put together approach it as polynomials approach a curve: the more of them, the less is left, and none of them is there.
"""

from collections.abc import Iterator

from modallab.gap.model.fit import Fit, Problem, cost_of, seen
from modallab.gap.search.explain import SOLVED
from modallab.gap.search.fitting import COARSE, Bench, excess, misfit, ordinary, rested
from modallab.gap.search.pool import channel_share
from modallab.gap.search.round import Level
from modallab.gap.unknown.fitted import Trial, finished, likely, priced
from modallab.gap.unknown.on_beam import along, on_all_rows
from modallab.gap.unknown.on_row import linear
from modallab.gap.unknown.spare_poles import of_spare_poles

LEAVES = 0.1
"""Share of what the best effect leaves that an element may leave to be what the gap behaves like."""
CLOSES = 0.003
"""The same of the whole gap, where it does not reach the floor."""


def rivals(bench: Bench, base: Fit, first: Level) -> tuple[Fit, ...]:
    """What explains the gap where no single effect does, best first; nothing where an effect does, or nothing does.

    Args:
        bench: what is searched.
        base: the twin without effects.
        first: the round of single effects.
    """
    best = min(first.fits, key=cost_of, default=base)
    if best.gap <= SOLVED * bench.flat and ordinary(best):
        return ()
    begin = rested(bench, base)
    looks = likely(bench, begin, list(_trials(bench, begin)))
    if not looks or looks[0].cost >= _at_a_look(bench, begin, best):
        return ()
    fits = sorted(finished(bench, begin, looks), key=priced)
    return tuple(fits) if _explains(bench, base, best, fits[0]) else ()


def _trials(bench: Bench, base: Fit) -> Iterator[Trial]:
    yield from of_spare_poles(bench, base)
    yield from along(bench)
    yield from on_all_rows(bench)
    shares = channel_share(base)
    yield from linear(bench, bench.data.channels[int(shares.argmax())])


def _at_a_look(bench: Bench, begin: Fit, best: Fit) -> float:
    """What the best effect leaves where as much is forgiven as at a look at an element."""
    floor = min(COARSE, max(misfit(begin.problem, begin.u), 0.003))
    held = (float(best.u[0]), float(best.u[1]), float(best.u[2]))
    return seen(Problem(bench.thin, bench.free, best.problem.candidates, floor, held=held), best.u).cost


def _explains(bench: Bench, base: Fit, best: Fit, fit: Fit) -> bool:
    near = fit.gap <= SOLVED * bench.flat and ordinary(fit)
    return (near or excess(fit) <= CLOSES * excess(base)) and excess(fit) <= LEAVES * excess(best)
