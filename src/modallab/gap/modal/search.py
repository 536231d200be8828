"""Which changes explain best what the tolerances leave: begun at many places, fitted to the end where it matters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.candidates import candidates
from modallab.gap.modal.fitting import FIRST_STEPS, FittedExplanation, fit
from modallab.gap.modal.free import Free
from modallab.gap.modal.hanging import candidates_nearby
from modallab.gap.modal.marginal import Marginal
from modallab.gap.modal.scales import estimated, usual

THIN = slice(None, None, 2)
"""Lines on which the search begins."""
REFINED = 2
"""Candidates of each kind that are fitted where the search begins."""
NEARBY = 3
"""Points about the place that was found, from which it is looked for again."""
RIVAL = 2 * float(np.log(100.0))
"""Evidence, as -2 ln of it, within which a rival is fitted to its end: it would have a probability of a percent."""


@dataclass(frozen=True, eq=False, slots=True)
class ModalSearch:
    """What a search has begun with.

    Attributes:
        closer: the comparison of a place with others nearby.
        base: the fit without any change, of the comparison that counts.
        near: likely changes of each kind, small ones, with their evidence there.
        large_changes: likely large ones, from smoother lines; their evidence is what they have there more than nothing.
    """

    closer: Free
    base: FittedExplanation
    near: list[FittedExplanation]
    large_changes: list[FittedExplanation]

    @classmethod
    def begun(cls, smooth: Free, closer: Free, last: Free) -> "ModalSearch":
        """From the comparison where modes overlap with where they were to the one that counts."""
        thin = Free(smooth.of.thinned(THIN), smooth.loose)
        afar = fit(thin, steps=FIRST_STEPS)
        base = fit(last, None, fit(closer, None, afar.u, steps=FIRST_STEPS).u, steps=FIRST_STEPS)
        # A large change is seen from afar, a small one on the lines that count: there tolerances follow it linearly.
        far, near = Marginal.about(thin, np.zeros(thin.size)), Marginal.about(last, base.u)
        large = _likely(far, lambda candidate, start: fit(thin, candidate, None, start, FIRST_STEPS))
        none, *each = (estimated(f, usual(thin.of)) for f in (afar, *large))
        more = [replace(f, evidence=f.evidence - none.evidence) for f in each]
        return cls(closer, base, [estimated(f, usual(last.of)) for f in _likely(near, near.fit)], more)

    def kinds(self, nothing: FittedExplanation) -> list[list[FittedExplanation]]:
        """Likely changes by their kind, all with an evidence to hold against that of nothing."""
        found: dict[str, list[FittedExplanation]] = {}
        for one in [*self.near, *(replace(f, evidence=nothing.evidence + f.evidence) for f in self.large_changes)]:
            assert one.candidate is not None
            found.setdefault(one.candidate.effect, []).append(one)
        return list(found.values())

    def afar(self, effect: str) -> float:
        """Evidence of a kind from smoother lines, more than nothing has there."""
        same = (f.evidence for f in self.large_changes if f.candidate and f.candidate.effect == effect)
        return min(same, default=np.inf)

    def ended(self, kind: Sequence[FittedExplanation]) -> FittedExplanation:
        """The best of a kind, fitted to its end at what is usual."""
        return self._from_nearby(min((self._followed(f) for f in kind), key=lambda f: f.evidence))

    def _followed(self, begun: FittedExplanation) -> FittedExplanation:
        # Where a change is large, tolerances that followed it linearly are bent: they begin where they are believed.
        u, v = None, begun.v
        if begun.free is not self.base.free:
            nearer = fit(self.closer, begun.candidate, begun.u, v, FIRST_STEPS)
            u, v = nearer.u, nearer.v
        return fit(self.base.free, begun.candidate, u, v, FIRST_STEPS)

    def _from_nearby(self, best: FittedExplanation) -> FittedExplanation:
        """The best of it and of fits begun at points nearby: along a wave one place may stand for another."""
        if best.candidate is None or not best.candidate.freedoms:
            return best
        starts = candidates_nearby(best.free.of, best.candidate, best.v, NEARBY)
        nearly = [fit(self.closer, candidate, best.u, v) for candidate, v in starts]
        others = [fit(best.free, one.candidate, one.u, one.v) for one in nearly]
        return min([best, *others], key=lambda f: f.evidence)


def _likely(here: Marginal, fitted: Callable[[Candidate, Real], FittedExplanation]) -> list[FittedExplanation]:
    """The candidates of each kind whose starts cost least, fitted from there."""
    every = sorted(((*here.started(c), c) for c in candidates(here.free.of)), key=lambda s: s[0])
    tried: dict[str, list[FittedExplanation]] = {}
    for _, start, candidate in every:
        of_kind = tried.setdefault(candidate.effect, [])
        if len(of_kind) < REFINED:
            of_kind.append(fitted(candidate, start))
    return [f for group in tried.values() for f in group]


def best_first(
    begun: Sequence[FittedExplanation],
    afar: Sequence[float],
    ended: Callable[[FittedExplanation, int], FittedExplanation],
) -> tuple[list[FittedExplanation], FittedExplanation]:
    """The best of them ended, until it stays the best and no rival is near; all of them, and the best.

    Args:
        begun: explanations with an estimate of their evidence, which may be far too bad where a change is large.
        afar: of each its evidence from smoother lines, where none is: what is better there may be the best.
        ended: brings one to its end, given it and its place.
    """
    found, open_ = list(begun), set(range(len(begun)))
    while True:
        first = min(range(len(found)), key=lambda n: found[n].evidence)
        # An estimate may be off by as much as that of the best one was.
        limit = max(found[first].evidence, begun[first].evidence) + RIVAL
        near = [n for n in open_ if found[n].evidence < limit]
        better = [n for n in open_ if afar[n] < afar[first]]
        if not near and not better:
            return found, found[first]
        at = min(near, key=lambda n: found[n].evidence) if near else min(better, key=lambda n: afar[n])
        found[at] = ended(found[at], at)
        open_.remove(at)
