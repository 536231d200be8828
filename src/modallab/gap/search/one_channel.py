"""Two effects on one channel, where all other channels agree with a sound bench.

Round by round neither is found: beside a wrong sign no resonance of a mount shows, and beside that no sign. But the
other channels say what the beam does: two effects and their numbers are all there is to try, and each try is one
prediction. A sign has no number, and so goes before a gain of -1.00.
"""

from collections.abc import Iterator
from itertools import combinations, product
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from modallab.gap.model.candidates import of_channel, testable
from modallab.gap.model.fit import Fit, Problem, cost_of, priced
from modallab.gap.search.fitting import COARSE, Bench, finish, short
from modallab.gap.search.screen import capped
from modallab.twin.candidate import Candidate

Array = NDArray[np.float64]

LOOKED_AT = 4
"""Pairs that are fitted in short: those whose best start leaves least."""
FINISHED = 2
"""Pairs that are fitted to the end."""


def on_one_channel(bench: Bench, alone: Fit, row: int) -> tuple[Fit, ...]:
    """Pairs of effects on a channel that were fitted to the end, best first.

    Args:
        bench: what to search.
        alone: the twin as the other channels have it.
        row: the channel.
    """
    own = [c for c in of_channel(bench.data.rig, row) if bench.allowed(c.effect) and testable(c, bench.data)]
    pairs = [pair for pair in combinations(own, 2) if pair[0].effect != pair[1].effect]
    begins = sorted((_begin(bench, alone, pair) for pair in pairs), key=itemgetter(0))[:LOOKED_AT]
    looks = sorted((short(bench, pair, u, COARSE) for _, u, pair in begins), key=cost_of)
    return tuple(sorted((finish(bench, f, COARSE / 6) for f in looks[:FINISHED]), key=priced))


def _begin(bench: Bench, alone: Fit, pair: tuple[Candidate, Candidate]) -> tuple[float, Array, tuple[Candidate, ...]]:
    """What the best start of a pair leaves, where it is, and the pair."""
    problem = Problem(bench.thin, bench.free, pair, COARSE / 6)
    tried = [(capped(problem, u), u) for u in _starts(bench, alone, pair)]
    left, u = min(tried, key=itemgetter(0))
    return left, u, pair


def _starts(bench: Bench, alone: Fit, pair: tuple[Candidate, Candidate]) -> Iterator[Array]:
    slots = [slot for candidate in pair for slot in candidate.slots]
    for values in product(*(slot.starts for slot in slots)):
        yield np.array([*alone.u[: bench.free.size], *(s.coordinate(v) for s, v in zip(slots, values, strict=True))])
