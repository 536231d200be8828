"""Which explanation counts: a gap is what strains the tolerances, and an effect is what relieves them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.diagnosis import Verdict
from modallab.core.rig import FORCE_SHARE
from modallab.gap.modal.candidates import EVERY
from modallab.gap.modal.free import Free
from modallab.gap.modal.search import Fitted

Real = NDArray[np.float64]

FLAT = 1.5
"""Strain up to which there is no gap, unless one change relieves it beyond doubt."""
SURE = 14.0
"""Decrease of misfit and priors, in squares of what the explanation leaves, from which chance is no reason. On sound
structures the best of some hundred changes takes 4 squares off in the median and 10 at most (25 plates and tubes)."""
CLOSED = 0.5
"""Share of the strain's square beyond 1 that an explanation has to take away. A large mass or spring leaves a part:
modes outside the band answer to it in more ways than by one compliance at its place."""
EXCEEDING = 3.0
"""Deviations of its own tolerance beyond which a change is one."""


@dataclass(frozen=True, eq=False, slots=True)
class Judged:
    """The verdict.

    Attributes:
        verdict: whether there is a gap, and whether it is explained.
        base: the fit without any change.
        best: the explanation that counts, or leaves least where none does; the base where there is no gap.
        ranked: explanations with their probabilities, the most probable first.
        notes: why.
    """

    verdict: Verdict
    base: Fitted
    best: Fitted
    ranked: list[tuple[Fitted, float]]
    notes: list[str]


def strain(free: Free, fitted: Fitted) -> float:
    """Root of misfit and priors over the count of tolerances; about 1 where tolerances explain what is seen."""
    return float(np.sqrt(fitted.cost / free.size))


def judged(free: Free, base: Fitted, tried: list[Fitted]) -> Judged:
    """What the explanations amount to."""
    ranked = probabilities(free, tried)
    before = strain(free, base)
    best = min(tried, key=lambda f: f.counted, default=base)
    gain = (base.cost - best.counted) / max(1.0, best.cost / free.size)
    if gain < SURE:
        verdict: Verdict = "no_gap" if before < FLAT else "unknown"
        return Judged(verdict, base, base, ranked, [])
    moved, small = moves(free, best), within_tolerance(free, best)
    closes = (base.cost - best.cost) / max(base.cost - free.size, base.cost - best.cost)
    least = free.of.rig.tolerance.response
    if closes < CLOSED:
        why = f"The best explanation takes {closes:.0%} of the gap away."
        return Judged("unknown", base, best, ranked, [why])
    if small or moved < least:
        why = f"It moves {moved:.1%} of the response, where {least:.0%} matter." if moved < least else small
        return Judged("no_gap", base, base, ranked, [why])
    return Judged("known", base, best, ranked, [])


def probabilities(free: Free, tried: list[Fitted]) -> list[tuple[Fitted, float]]:
    """Explanations with their probabilities; what the best of them leaves is the scale of an error."""
    if not tried:
        return []
    costs = np.array([f.counted + 2 * (f.v.size - _beside(f)) for f in tried])
    weights = np.exp(-(costs - costs.min()) / (2 * max(1.0, costs.min() / free.size)))
    listed = zip(tried, (weights / weights.sum()).tolist(), strict=True)
    return sorted(((f, min(p, 0.995)) for f, p in listed), key=lambda pair: -pair[1])


def _beside(fitted: Fitted) -> int:
    return 0 if fitted.candidate is None else fitted.candidate.beside


def moves(free: Free, fitted: Fitted) -> float:
    """Share of the response that the change moves, at the output where it moves most.

    Each line counts by its own size, as in `Free.share`: of receptances the first mode would be all that counts.
    """
    c = free.of
    state = free.state(fitted.u, fitted.change).receptance(c.s, c.outside)
    without = free.state(fitted.u).receptance(c.s, c.outside)
    return float(np.sqrt(np.max(np.mean((np.abs(state - without) / c.sizes) ** 2, axis=(0, 2)))))


def within_tolerance(free: Free, fitted: Fitted) -> str:
    """Why a change is no gap though it explains one: it is within its own tolerance; "" where it is not."""
    t, candidate, v = free.of.rig.tolerance, fitted.candidate, fitted.v
    if candidate is None or candidate.freedoms or candidate.effect in EVERY:
        return ""
    name = candidate.effect.replace("_", " ")
    if candidate.effect == "position_error":
        off, allowed, unit = float(np.linalg.norm(v[:2])), t.position_m, "m"
    else:
        share_ = FORCE_SHARE if candidate.channel is None else 1.0
        off, allowed, unit = abs(float(v[0]) - 1), share_ * t.sensitivity, ""
    if off > EXCEEDING * allowed:
        return ""
    return f"Within tolerance: {name} of {off:.3g} {unit} where {allowed:.3g} is one deviation."
