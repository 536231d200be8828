"""Whether an element without a name explains what no single effect does: then no further effects are looked for.

A beam that is pulled, that carries a mass on a spring or that twists is far from any beam of the catalogue, and effects
put together approach it as polynomials approach a curve: the more of them, the less is left, and none of them is there.
A channel that loses samples reads as one whose gain is too small, with noise on it.
"""

from collections.abc import Sequence

from modallab.gap.conditioning.prepare import Prepared
from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit, Problem, cost_of, seen
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.report.measure import squares
from modallab.gap.search.explain import SOLVED
from modallab.gap.search.fitting import COARSE, Bench, excess, misfit, ordinary, rested
from modallab.gap.search.pool import channel_share
from modallab.gap.search.round import Level
from modallab.gap.unknown.description import Description, of_fit, worth
from modallab.gap.unknown.fitted import finished, fitted, likely
from modallab.gap.unknown.on_beam import along, on_all_rows
from modallab.gap.unknown.on_row import by_sample, linear, without
from modallab.gap.unknown.spare_poles import of_spare_poles

LEAVES = 0.1
"""Share of what the best effect leaves that an element may leave to be what the gap behaves like."""
CLOSES = 0.003
"""The same of the whole gap, where it does not reach the floor."""
STANDS_OUT = 0.4
"""Share of the misfit from which a channel is looked at by itself."""


def rivals(
    bench: Bench, prepared: Prepared, first: Level, unseen: Reduced, held: Sequence[str]
) -> tuple[Description, ...]:
    """What explains the gap where no single effect does, best first; nothing where an effect does, or nothing does.

    Args:
        bench: what is searched.
        prepared: the campaign.
        first: the round of single effects.
        unseen: records that no fit has seen.
        held: their names.
    """
    base = first.base
    best = min(first.fits, key=cost_of, default=base)
    sound = _near(bench, best)
    own = {e.place.get("channel") for e in best.effects}
    losing = [row for row in prepared.repeated if row in own or not sound]
    if sound and not losing:
        return ()
    begin = rested(bench, base)
    for row in losing or _standing_out(begin):
        alone = without(bench, prepared, [b for b in prepared.blocks if b.name not in set(held)], row)
        # Where all other channels agree with a sound bench, it is this one.
        if not _near(bench, alone):
            continue
        found = sorted(by_sample(bench, prepared, alone, held, row), key=worth)
        if losing and _closes(base, found[0]):
            return tuple(found)
        found += (of_fit(base, fit, unseen, (row,)) for fit in fitted(bench, begin, list(linear(bench, row)), 1))
        found.sort(key=worth)
        if _explains(bench, base, best, found[0].fit):
            return tuple(found)
    return () if sound else _on_beam(bench, begin, base, best, unseen)


def _standing_out(base: Fit) -> list[int]:
    shares = channel_share(base)
    return [base.problem.data.channels[int(shares.argmax())]] if shares.max() > STANDS_OUT else []


def _on_beam(bench: Bench, begin: Fit, base: Fit, best: Fit, unseen: Reduced) -> tuple[Description, ...]:
    """Elements in the structure or on all channels."""
    trials = [*of_spare_poles(bench, begin), *along(bench), *on_all_rows(bench)]
    looks = likely(bench, begin, trials)
    if not looks or looks[0].cost >= _at_a_look(bench, begin, best):
        return ()
    found = sorted((of_fit(base, fit, unseen) for fit in finished(bench, begin, looks)), key=worth)
    return tuple(found) if _explains(bench, base, best, found[0].fit) else ()


def _at_a_look(bench: Bench, begin: Fit, best: Fit) -> float:
    """What the best effect leaves where as much is forgiven as at a look at an element."""
    floor = min(COARSE, max(misfit(begin.problem, begin.u), 0.003))
    held = (float(best.u[0]), float(best.u[1]), float(best.u[2]))
    return seen(Problem(bench.thin, bench.free, best.problem.candidates, floor, held=held), best.u).cost


def _near(bench: Bench, fit: Fit) -> bool:
    return fit.gap <= SOLVED * bench.flat and ordinary(fit)


def _closes(base: Fit, one: Description) -> bool:
    """Whether a description closes the gap of records it has not seen, weighed as it weighs them.

    Of a channel that loses samples the record itself says that no effect does it, however little one leaves where the
    losses count as noise.
    """
    before = squares(twin_of(base, one.raw), one.raw).gap
    return excess(one.fit) <= CLOSES * (before**2 - 1)


def _explains(bench: Bench, base: Fit, best: Fit, fit: Fit) -> bool:
    return (_near(bench, fit) or excess(fit) <= CLOSES * excess(base)) and excess(fit) <= LEAVES * excess(best)
