"""The explanations that a diagnosis has left standing, each with its own numbers, on the records it was made from."""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.block import Campaign
from modallab.core.diagnosis import CandidateSet, Diagnosis
from modallab.core.effects import kind_of
from modallab.core.errors import DataError, PlanError
from modallab.core.hold_out import SPREAD
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.conditioning.records import split_held_out
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.conditioning.rows import Reduced, Weights
from modallab.gap.model.fit import Fit
from modallab.gap.model.minimise import minimise
from modallab.gap.model.nuisances import Nuisances, nuisances
from modallab.gap.model.restored import start_from_diagnosis
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.report.initial_gap import TOP_HZ, weights_of
from modallab.gap.search.best_place import at_best_place

POSSIBLE = 0.01
"""Probability from which an explanation counts as left standing."""
MOST = 4
"""Explanations that are planned for at most."""
STEPS = 6
"""Evaluations of the slopes, at most, until an explanation is at the end of its valley."""


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """An explanation that is left standing.

    Attributes:
        effects: names of its effects.
        probability: that the diagnosis gives it; those of all explanations add up to 1.
        fit: it, on the records that are there.
    """

    effects: tuple[str, ...]
    probability: float
    fit: Fit


@dataclass(frozen=True, eq=False, slots=True)
class RecordsSoFar:
    """What is there to plan with.

    Attributes:
        data: the records that a fit would see.
        weights: the noise of the rows.
        prepared: the campaign.
    """

    data: Reduced
    weights: Weights
    prepared: PreparedCampaign


def prepared_with_later_records(campaign: Campaign) -> RecordsSoFar:
    """The records of a campaign as a diagnosis of these and later records would fit them.

    Raises:
        DataError: the campaign holds no record that says what drove it.
    """
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    weights = weights_of(prepared)
    fitted, _ = split_held_out(prepared.blocks, SPREAD)
    return RecordsSoFar(reduce_blocks(prepared.campaign, fitted, weights), weights, prepared)


def remaining_explanations(diagnosis: Diagnosis) -> list[CandidateSet]:
    """Explanations between which an experiment could decide, the likeliest first; a single one if there is none.

    One that contains a likelier one is no rival of it: what it has beyond is not needed, and nothing rules it out.
    Where one stands alone, the one behind it counts too.
    """
    kept = drop_redundant_explanations(diagnosis.candidates)
    return [c for k, c in enumerate(kept) if k < 2 or c.probability >= POSSIBLE][:MOST]


def drop_redundant_explanations(candidates: Sequence[CandidateSet]) -> list[CandidateSet]:
    """Explanations, the likeliest first, without those that contain a likelier one: what they add is not needed."""
    kept: list[CandidateSet] = []
    for c in sorted(candidates, key=lambda c: -c.probability):
        if not any(set(k.effects) < set(c.effects) for k in kept):
            kept.append(c)
    return kept


def undecided_explanations(diagnosis: Diagnosis) -> list[CandidateSet]:
    """The explanations left standing, where an experiment can be planned for them.

    Raises:
        PlanError: fewer than two are left standing, or one of them depends on the size of the motion.
        DataError: the diagnosis does not hold their numbers.
    """
    sets = remaining_explanations(diagnosis)
    if len(sets) < 2:
        raise PlanError(
            "the diagnosis does not leave two explanations to decide between",
            where=diagnosis.rig,
            remedy=diagnosis.next_experiment or "no decision is needed; add the effect found to the simulation",
        )
    for c in sets:
        _require_planned(diagnosis, c)
    return sets


def fit_explanations(
    sets: Sequence[CandidateSet], there: RecordsSoFar, points: Collection[tuple[float, int]]
) -> list[Explanation]:
    """Explanations, fitted to what is there.

    Args:
        sets: the explanations, as `undecided_explanations`.
        there: the records.
        points: place in m and number of further hits that are planned: where each lands is free as well.

    Raises:
        DataError: one has an effect that no fit looks for on this rig.
    """
    free = nuisances_with_hits(there, points)
    total = sum(c.probability for c in sets) or 1.0
    names = Counter(frozenset(c.effects) for c in sets)
    fits = [
        minimise(*start_from_diagnosis(c, there.data, free, names[frozenset(c.effects)] > 1), STEPS, 1e-4) for c in sets
    ]
    best = min(fits, key=lambda f: f.cost)
    fits = [at_best_place(better_of_two_fits(f, best)) for f in fits]
    return [
        Explanation(tuple(sorted(e.effect for e in c.fitted)), c.probability / total, fit)
        for c, fit in zip(sets, fits, strict=True)
    ]


def better_of_two_fits(fit: Fit, other: Fit) -> Fit:
    """A fit, or the one that begins where another's nuisances are, if that is the better one.

    Many numbers that do nearly the same settle slowly: what two explanations differ by must not be where each fit has
    come to.
    """
    size = fit.problem.free.size
    moved = np.concatenate([other.u[:size], fit.u[size:]])
    return min(fit, minimise(fit.problem, moved, STEPS, 1e-4), key=lambda f: f.cost)


def _require_planned(diagnosis: Diagnosis, c: CandidateSet) -> None:
    if c.twin is None or not c.fitted:
        raise DataError(
            f"the diagnosis does not hold the numbers of {' and '.join(c.effects)}",
            where=diagnosis.rig,
            remedy="diagnose the campaign again with this version",
        )
    if not all(kind_of(e.effect).linear for e in c.fitted):
        raise PlanError(
            f"{' and '.join(c.effects)} depends on the amplitude: such experiments are not planned yet",
            where=diagnosis.rig,
            remedy=diagnosis.next_experiment or "repeat the sines at a third level",
        )


def nuisances_with_hits(there: RecordsSoFar, points: Collection[tuple[float, int]]) -> Nuisances:
    """The free numbers of a fit to the records that are there and to hits at further points."""
    rig = there.prepared.campaign.rig
    counts = Counter(b.drive_point for b in there.prepared.blocks if b.test == "impact" and b.drive_point is not None)
    done = {rig.x_of(point): count for point, count in sorted(counts.items())}
    more = [(x, count) for x, count in points if x not in done]
    return nuisances(rig, TOP_HZ, [*done.items(), *more])
