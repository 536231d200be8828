"""Which explanation counts, by one criterion: the evidence of nothing, of each change, and of what has no name.

Two tests of one structure differ though nothing was changed. By how much is inferred with everything else: a ladder of
scales stands on what is usual. What needs more than the usual is a gap. If a change explains it, the evidence of that
change is the larger one; else that of the structure, of one channel, or of everything being otherwise: *unknown*.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.diagnosis import Verdict
from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.candidates import force_channel, hits_at, mixed_channel
from modallab.gap.modal.errors import sizes
from modallab.gap.modal.fitting import FittedExplanation, fit
from modallab.gap.modal.free import Free
from modallab.gap.modal.marginal import Marginal
from modallab.gap.modal.scales import SUSPECTS, USUAL, Rung, departed, nameless, settled, unusual_rungs, usual
from modallab.gap.modal.search import ModalSearch, best_first
from modallab.modification.frfs import frfs_without_shapes

PRIOR = {"no_gap": 0.5, "known": 0.4, "unknown": 0.1}
"""Probabilities before the comparison."""


@dataclass(frozen=True, eq=False, slots=True)
class ModalVerdict:
    """The verdict.

    Attributes:
        verdict: whether there is a gap, and whether it is explained.
        base: the fit without any change, at what is usual.
        best: the explanation that counts; the base where none does.
        ranked: the best fit of each kind of change with its probability, the most probable first.
        nothing: probability that nothing was changed.
        unknown: probability that something without a name is the cause.
        where: what that would be: "structure", "everything", a channel, or the hits at a point, in words.
        strains: of the tolerances without and with the best explanation, at what is usual.
        notes: why.
    """

    verdict: Verdict
    base: FittedExplanation
    best: FittedExplanation
    ranked: list[tuple[FittedExplanation, float]]
    nothing: float
    unknown: float
    where: str
    strains: tuple[float, float]
    notes: list[str]


def _evidence(fitted: FittedExplanation) -> float:
    return fitted.evidence


def strain(fitted: FittedExplanation) -> float:
    """Root of misfit and priors over the count of tolerances; about 1 where tolerances explain what is seen."""
    return float(np.sqrt(fitted.cost / fitted.u.size))


def judged(search: ModalSearch) -> ModalVerdict:
    """What the explanations amount to: where it is not nothing, the best is fitted until it stays the best."""
    base, as_usual = search.base, usual(search.base.free.of)
    nothing = departed(base, USUAL)
    kinds = search.kinds(nothing)
    # One from smoother lines stands for its kind until it is fitted on those that count.
    names = [replace(min(kind, key=lambda f: f.evidence), free=base.free) for kind in kinds]
    others = _of_channels(base, as_usual, nothing.free) | nameless(nothing)
    found = _weighed(base, nothing, names, others)
    if found.verdict == "no_gap":
        return _without_small(found)
    ended = {0: base}

    def to_its_end(begun: FittedExplanation, n: int) -> FittedExplanation:
        if not n:
            return begun
        ended[n] = search.ended(kinds[n - 1])
        return departed(ended[n], USUAL)

    afar = [0.0, *(search.afar(one.candidate.effect) for one in names if one.candidate)]
    (_, *names), least = best_first([nothing, *names], afar, to_its_end)
    # What has no name may be there beside a change.
    others |= {where: min(one, others[where], key=_evidence) for where, one in nameless(least).items()}
    strains = strain(base), strain(ended[[nothing, *names].index(least)])
    return _without_small(replace(_weighed(base, nothing, names, others), strains=strains))


def _of_channels(base: FittedExplanation, as_usual: list[Rung], nothing: Free) -> dict[str, FittedExplanation]:
    """What a channel, that of the force, or the hits at a point do otherwise, whatever it is."""
    c, wide, missed = nothing.of, nothing.wide, np.mean(base.missed**2, axis=0)
    rows, columns = np.eye(len(missed), dtype=bool), np.eye(missed.shape[1], dtype=bool)
    found: dict[str, FittedExplanation] = {}
    for o in np.argsort(-missed.mean(axis=1))[:SUSPECTS].tolist():
        found[c.model.outputs[o]] = settled(base, unusual_rungs(c, rows[:, [o]], wide))
        found[f"{c.model.outputs[o]} reads what another channel should"] = _mixed(base, o, as_usual)
    if c.bench.operating_shapes is None:
        found[c.rig.force_channel.name] = settled(_begun(base, force_channel(c)), as_usual)
        # Hits at one point may be of another size alone, or on another day.
        for i in np.argsort(-missed.mean(axis=0))[:SUSPECTS].tolist() if len(columns) > 1 else ():
            each = [*as_usual, *unusual_rungs(c, columns[[i]], wide)]
            found[f"hits at {c.model.input_points[i]}"] = settled(_begun(base, hits_at(i)), each)
    return found


def _mixed(base: FittedExplanation, output: int, as_usual: list[Rung]) -> FittedExplanation:
    """A channel that reads shares of others: of all, or of the one that explains most."""
    here = Marginal.about(base.free, base.u)
    every, *single = (here.fit(one, one.starts[0]) for one in mixed_channel(base.free.of, output))
    best = min(single, key=lambda f: f.evidence, default=every)
    return min((settled(f, as_usual) for f in (every, best)), key=lambda f: f.evidence)


def _begun(base: FittedExplanation, candidate: Candidate) -> FittedExplanation:
    return fit(base.free, candidate, base.u, candidate.starts[0])


def _weighed(
    base: FittedExplanation,
    nothing: FittedExplanation,
    names: Sequence[FittedExplanation],
    others: Mapping[str, FittedExplanation],
) -> ModalVerdict:
    """All explanations with their probabilities; the verdict is the most probable one."""
    none, *each, unknown = _posterior(nothing, names, list(others.values()))
    ranked = sorted(zip(names, each, strict=True), key=lambda pair: -pair[1])
    best, probable = ranked[0]
    of_verdict: dict[Verdict, float] = {"no_gap": none, "unknown": unknown, "known": probable}
    verdict = max(of_verdict, key=lambda v: of_verdict[v])
    where = min(others, key=lambda name: others[name].evidence)
    return ModalVerdict(verdict, base, best, ranked, none, unknown, where, (strain(base),) * 2, [])


def _without_small(found: ModalVerdict) -> ModalVerdict:
    """A change that moves less than matters is none; where none is named, the base is what counts."""
    if found.verdict == "known":
        moved, matters = moves(found.best), found.base.free.of.rig.tolerance.response
        if moved >= matters:
            return found
        said = [f"It moves {moved:.1%} of the response, where {matters:.0%} matter."]
        found = replace(found, verdict="no_gap", notes=said)
    return replace(found, best=found.base, strains=(found.strains[0],) * 2)


def _posterior(
    nothing: FittedExplanation, names: Sequence[FittedExplanation], others: Sequence[FittedExplanation]
) -> list[float]:
    """Of nothing, of each kind of change, and of what has no name."""
    fits = [nothing, *names, *others]
    named, nameless = PRIOR["known"] / max(len(names), 1), PRIOR["unknown"] / len(others)
    prior = np.array([PRIOR["no_gap"], *(named for _ in names), *(nameless for _ in others)])
    evidence = np.array([f.evidence for f in fits])
    mass = prior * np.exp(-(evidence - evidence.min()) / 2)
    each = mass / mass.sum()
    return [*each[: len(names) + 1].tolist(), float(each[len(names) + 1 :].sum())]


def moves(fitted: FittedExplanation) -> float:
    """Share of the response at its resonances that the change moves, at the output where it moves most."""
    free, c = fitted.free, fitted.free.of
    hz = np.concatenate([c.model.frequency_hz, c.bench.frequency_hz])
    s = np.asarray(2j * np.pi * hz[hz >= c.model.band_hz[0]])
    there = free.at(s, lambda s: frfs_without_shapes(c.model, s, c.response_factors, c.force_factors))
    moved, without = there.predicted(fitted.u, fitted.change.between_lines), there.predicted(fitted.u)
    return float(np.sqrt(np.max(np.mean((np.abs(moved - without) / sizes(without)) ** 2, axis=(0, 2)))))
