"""Learned elements fitted to the records, the beam's own numbers free beside them, as any effect is."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.effect import NO_PLACE, Place
from modallab.gap.model.fit import Fit, cost_of, cost_with_price
from modallab.gap.model.prefit import start_fit, start_fits
from modallab.gap.search.fitting import COARSEST_ERROR, Bench, complete_fit, forgivable_error, short_fit
from modallab.twin.candidate import CandidateEffect
from modallab.twin.learned import learned_element_models

BEST = 2
"""Elements that are fitted to the end."""
BEGINS = 2
"""Places to begin from by the poles of the ring-down."""


@dataclass(frozen=True, slots=True)
class ElementTrial:
    """An element with places to begin from.

    Attributes:
        candidate: its numbers free.
        begins: values of its numbers, SI, in the order of its slots; empty for the element's own first values.
    """

    candidate: CandidateEffect
    begins: tuple[tuple[float, ...], ...] = ()


def element(
    bench: Bench, name: str, numbers: Sequence[str], place: Place = NO_PLACE, room: float = 1.0
) -> CandidateEffect:
    """A learned element with some of its numbers free; the others are none.

    Args:
        bench: what is searched.
        name: of the element.
        numbers: that are free.
        place: where it is; none where its place along the beam is free.
        room: share of its range that a number may go below 0, where several together could leave the beam unstable.
    """
    model = learned_element_models()[name]
    beam = bench.data.rig.beam
    assert model.search is not None
    assert beam is not None
    slots = {s.name: s for s in model.search.slots(beam)}
    chosen = (slots[n] for n in numbers)
    return CandidateEffect(name, tuple(replace(s, low=s.low * room) if s.low < 0 else s for s in chosen), place)


def short_fit_of(bench: Bench, base: Fit, trial: ElementTrial) -> Fit:
    """A few steps from the best place to begin."""
    c, size = trial.candidate, bench.free.size
    own = [np.array([s.coordinate(v) for s, v in zip(c.slots, values, strict=True)]) for values in trial.begins]
    begins = [np.concatenate([base.u[:size], o]) for o in own]
    if len(bench.poles):
        begins += [start_fit((c,), o, bench.free, bench.poles).u for o in own]
        begins += [] if own else [s.u for s in start_fits((c,), bench.free, bench.poles, BEGINS)]
    if not own:
        begins += [np.concatenate([base.u[:size], [s.coordinate(s.starts[0]) for s in c.slots]])]
    floor = forgiven_error(base)
    return min((short_fit(bench, (c,), u, floor) for u in begins), key=cost_of)


def forgiven_error(base: Fit) -> float:
    """Relative model error that is forgiven while elements are looked at from a fit without any."""
    return min(COARSEST_ERROR, max(forgivable_error(base.problem, base.u), 0.003))


def short_fits(bench: Bench, base: Fit, trials: Sequence[ElementTrial]) -> list[Fit]:
    """A short look at each of some elements, best first."""
    return sorted((short_fit_of(bench, base, t) for t in trials), key=cost_of)


def converged_fits(bench: Bench, base: Fit, looks: Sequence[Fit], best: int = BEST) -> list[Fit]:
    """The best of these looks brought to their end on all data."""
    floor = max(forgivable_error(base.problem, base.u) / 6, 0.001)
    return [complete_fit(bench, f, floor) for f in looks[:best]]


def best_fits(bench: Bench, base: Fit, trials: Sequence[ElementTrial], best: int = BEST) -> list[Fit]:
    """The best of some elements brought to their end on all data, best first."""
    return sorted(converged_fits(bench, base, short_fits(bench, base, trials), best), key=cost_with_price)
