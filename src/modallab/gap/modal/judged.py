"""Which explanation counts, by one criterion: the evidence of nothing, of each change, and of what has no name.

Two tests of one structure differ though nothing was changed. By how much is inferred with everything else: a ladder of
scales stands on what is usual. What needs more than the usual is a gap. If a change explains it, the evidence of that
change is the larger one; else that of the structure, of one channel, or of everything being otherwise: *unknown*.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.diagnosis import Verdict
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.errors import sizes
from modallab.gap.modal.free import Free
from modallab.gap.modal.linear import Linear
from modallab.gap.modal.search import Fitted, fit
from modallab.modification.synthesis import beside

Real = NDArray[np.float64]

USUAL = (1.0, 0.25, 0.0625)
"""Scales of what two tests of a structure differ by, over what is usual, at most."""
UNUSUAL = (4.0, 16.0, 64.0)
"""Scales of what has no name."""
PRIOR = {"no_gap": 0.5, "known": 0.4, "unknown": 0.1}
"""Probabilities before the comparison."""
TURNS = 2
"""Times that scales are inferred, and numbers fitted at them."""
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
        nothing: probability that nothing was changed.
        unknown: probability that something without a name is the cause.
        where: what that would be: "structure", "everything" or the name of a channel.
        strains: of the tolerances without and with the best explanation, at what is usual.
        notes: why.
    """

    verdict: Verdict
    base: Fitted
    best: Fitted
    ranked: list[tuple[Fitted, float]]
    nothing: float
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
    c = base.free.of
    # What models leave of FRFs is as usual: it is inferred where FRFs were measured, of which models are no sample.
    steps = (1.0,) if c.noise is None else USUAL
    even = {(a, b): c.scaled(a, b) for a in steps for b in steps}
    nothing, *names = (_settled(f, even, USUAL) for f in (base, *tried))
    least = min((nothing, *names), key=lambda f: f.evidence)
    others = _nameless(nothing, even, least.free)
    none, *each, unknown = _posterior(nothing, names, list(others.values()))
    ranked = sorted(zip(names, each, strict=True), key=lambda pair: -pair[1])
    where = min(others, key=lambda name: others[name].evidence)
    first = ranked[0][0] if ranked else base
    strains = strain(base), strain(tried[names.index(first)] if ranked else base)
    return _decided(Judged("known", base, first, ranked, none, unknown, where, strains, []))


def _decided(found: Judged) -> Judged:
    name = found.ranked[0][1] if found.ranked else 0.0
    none = replace(found, verdict="no_gap", best=found.base, strains=(found.strains[0],) * 2)
    if found.nothing >= max(name, found.unknown):
        return none
    if found.unknown >= name:
        return replace(found, verdict="unknown")
    moved, matters = moves(found.best), found.base.free.of.rig.tolerance.response
    if moved < matters:
        return replace(none, notes=[f"It moves {moved:.1%} of the response, where {matters:.0%} matter."])
    return found


def _settled(fitted: Fitted, even: Mapping[tuple[float, float], Compared], structure: Sequence[float]) -> Fitted:
    """It fitted at its most probable scales, which its linearisation tells."""
    for _ in range(TURNS):
        linear = Linear.about(fitted)
        tried: list[tuple[float, Compared, float]] = []
        for own in even.values():
            weighed = linear.weighed(own.weights)
            tried += [(weighed.evidence(wide), own, wide) for wide in structure]
        _, own, wide = min(tried, key=lambda t: t[0])
        fitted = _at(fitted, own, wide)
    return fitted


def _at(fitted: Fitted, there: Compared, wide: float) -> Fitted:
    """It fitted at other scales."""
    free = replace(fitted.free, of=there, wide=wide)
    # The numbers stay what they are, in other deviations.
    before, after = fitted.free.deviations, free.deviations
    u = fitted.u * np.divide(before, after, out=np.ones_like(after), where=after > 0)
    return fit(free, fitted.candidate, u, fitted.v)


def _nameless(base: Fitted, even: Mapping[tuple[float, float], Compared], usual: Free) -> dict[str, Fitted]:
    """Fits without a change where the structure, everything, or a channel differs by more than is usual."""
    c, missed = base.free.of, np.sqrt(np.mean(base.missed**2, axis=(0, 2)))
    lines, shapes = next(key for key, own in even.items() if own is usual.of)
    found = {"structure": _settled(base, even, UNUSUAL)}
    found["everything"] = min(
        (_at(base, c.scaled(a, x), x) for x in UNUSUAL for a in (lines, x)), key=lambda f: f.evidence
    )
    for o in np.argsort(-missed)[:SUSPECTS]:
        there = np.arange(missed.size)[:, None] == o
        ladder = [c.scaled(np.where(there, a, lines), np.where(there, x, shapes)) for x in UNUSUAL for a in (lines, x)]
        fits = (_at(base, own, usual.wide) for own in ladder)
        found[c.model.outputs[int(o)]] = min(fits, key=lambda f: f.evidence)
    return found


def _posterior(nothing: Fitted, names: Sequence[Fitted], others: Sequence[Fitted]) -> list[float]:
    """Of nothing, of each kind of change, and of what has no name."""
    fits = [nothing, *names, *others]
    named, nameless = PRIOR["known"] / max(len(names), 1), PRIOR["unknown"] / len(others)
    prior = np.array([PRIOR["no_gap"], *(named for _ in names), *(nameless for _ in others)])
    evidence = np.array([f.evidence for f in fits])
    mass = prior * np.exp(-(evidence - evidence.min()) / 2)
    each = mass / mass.sum()
    return [*each[: len(names) + 1].tolist(), float(each[len(names) + 1 :].sum())]


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
