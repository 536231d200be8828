"""Which explanation counts, by one criterion: the evidence of nothing, of each change, and of what has no name.

Two tests of one structure differ though nothing was changed. By how much is inferred with everything else: a ladder of
scales stands on what is usual. What needs more than the usual is a gap. If a change explains it, the evidence of that
change is the larger one; else that of the structure, of one channel, or of everything being otherwise: *unknown*.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.diagnosis import Verdict
from modallab.gap.modal.errors import sizes
from modallab.gap.modal.search import Fitted, fit
from modallab.modification.synthesis import beside

Real = NDArray[np.float64]

USUAL = (1.0, 0.25, 0.0625)
"""Scales of what two tests of a structure differ by, over what is usual, at most."""
UNUSUAL = (4.0, 16.0, 64.0)
"""Scales of what has no name."""
PRIOR = {"no_gap": 0.5, "known": 0.4, "unknown": 0.1}
"""Probabilities before the comparison."""
SUSPECTS = 2
"""Channels of which it is asked whether they do something else."""


@dataclass(frozen=True, eq=False, slots=True)
class Judged:
    """The verdict.

    Attributes:
        verdict: whether there is a gap, and whether it is explained.
        base: the fit without any change, at what is usual.
        best: the explanation that counts, or leaves least where none does; the base where there is no gap.
        ranked: the best fit of each kind of change with its probability, the most probable first.
        unknown: probability that something without a name is the cause.
        where: what that would be: "structure", "everything" or the name of a channel.
        strains: of the tolerances without and with the best explanation, at what is usual.
        notes: why.
    """

    verdict: Verdict
    base: Fitted
    best: Fitted
    ranked: list[tuple[Fitted, float]]
    unknown: float
    where: str
    strains: tuple[float, float]
    notes: list[str]


def strain(fitted: Fitted) -> float:
    """Root of misfit and priors over the count of tolerances; about 1 where tolerances explain what is seen."""
    return float(np.sqrt(fitted.cost / fitted.u.size))


def judged(base: Fitted, tried: list[Fitted]) -> Judged:
    """What the explanations amount to.

    Args:
        base: fitted without a change, at what is usual.
        tried: fitted so, the best of each kind.
    """
    usual = [_on_ladder(f) for f in (base, *tried)]
    least = int(np.argmin([f.evidence for ladder in usual for f in ladder])) % len(USUAL)
    others = _nameless(usual[0][least], USUAL[least])
    nothing, *names, unknown = _posterior(usual, others)
    order = np.argsort(-np.array(names), kind="stable")
    ranked = [(_best(usual[1 + n]), names[n]) for n in order]
    where = min(others, key=lambda name: min(f.evidence for f in others[name]))
    first = usual[1 + int(order[0])] if ranked else usual[0]
    found = Judged("known", base, _best(first), ranked, unknown, where, (strain(base), strain(first[0])), [])
    return _decided(found, nothing)


def _decided(found: Judged, nothing: float) -> Judged:
    name = found.ranked[0][1] if found.ranked else 0.0
    none = replace(found, verdict="no_gap", best=found.base, strains=(found.strains[0],) * 2)
    if nothing >= max(name, found.unknown):
        return none
    if found.unknown >= name:
        return replace(found, verdict="unknown")
    moved, matters = moves(found.best), found.base.free.of.rig.tolerance.response
    if moved < matters:
        return replace(none, notes=[f"It moves {moved:.1%} of the response, where {matters:.0%} matter."])
    return found


def _on_ladder(fitted: Fitted) -> list[Fitted]:
    """It at every scale of what is usual."""
    found = [fitted]
    for scale in USUAL[1:]:
        found.append(_again(found[-1], scale, scale))
    return found


def _again(fitted: Fitted, scale: Real | float, wide: float) -> Fitted:
    free = fitted.free
    there = replace(free, of=free.of.scaled(scale), wide=wide)
    # The numbers stay what they are, in other deviations.
    before, after = free.deviations, there.deviations
    u = fitted.u * np.divide(before, after, out=np.ones_like(after), where=after > 0)
    return fit(there, fitted.candidate, u, fitted.v)


def _nameless(base: Fitted, usual: float) -> dict[str, list[Fitted]]:
    """Fits without a change where the structure, everything, or a channel differs by more than is usual."""
    found = {"structure": [_again(base, usual, wide) for wide in UNUSUAL]}
    found["everything"] = [_again(base, scale, scale) for scale in UNUSUAL]
    missed = np.sqrt(np.mean(base.missed**2, axis=(0, 2)))
    for o in np.argsort(-missed)[:SUSPECTS]:
        only = np.where(np.arange(missed.size) == o, 1.0, 0.0)[:, None]
        ladder = [_again(base, np.where(only, scale, usual), usual) for scale in UNUSUAL]
        found[base.free.of.model.outputs[int(o)]] = ladder
    return found


def _posterior(usual: Sequence[Sequence[Fitted]], others: dict[str, list[Fitted]]) -> list[float]:
    """Of nothing, of each kind of change, and of what has no name."""
    kinds = max(len(usual) - 1, 1)
    ways = sum(len(ladder) for ladder in others.values())
    groups = [[(f, PRIOR["no_gap"] / len(USUAL)) for f in usual[0]]]
    groups += [[(f, PRIOR["known"] / kinds / len(USUAL)) for f in ladder] for ladder in usual[1:]]
    groups.append([(f, PRIOR["unknown"] / ways) for ladder in others.values() for f in ladder])
    least = min(f.evidence for group in groups for f, _ in group)
    mass = np.array([sum(p * np.exp(-(f.evidence - least) / 2) for f, p in group) for group in groups])
    return (mass / mass.sum()).tolist()


def _best(ladder: Sequence[Fitted]) -> Fitted:
    return min(ladder, key=lambda f: f.evidence)


def moves(fitted: Fitted) -> float:
    """Share of the response at its resonances that the change moves, at the output where it moves most."""
    free, c = fitted.free, fitted.free.of
    s = np.asarray(2j * np.pi * np.concatenate([c.model.frequency_hz, c.bench.frequency_hz]))
    outside = beside(c.model, s, c.out_psi, c.into_psi)
    change = fitted.change
    # What was measured line by line is not known between the lines.
    hung = None if change.hung is None else replace(change.hung, extra=None)
    state = free.state(fitted.u, replace(change, hung=hung)).receptance(s, outside)
    without = free.state(fitted.u).receptance(s, outside)
    return float(np.sqrt(np.max(np.mean((np.abs(state - without) / sizes(without)) ** 2, axis=(0, 2)))))
