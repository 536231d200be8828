"""Which effects a campaign cannot distinguish, before any data: cosines between their signatures.

Signatures are differences of the residuals in noise units, the nuisances projected out (orthogonal projection: Bjorck,
Numerical Methods for Least Squares Problems, 1996), their priors one row each. Two that point the same way cannot be
separated by any fit: collinearity as in Brun, Reichert and Kunsch, Water Resour. Res. 37 (2001), 1015.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.design.planned import records_of_plans
from modallab.gap.model.candidates import beam_candidates, channel_candidates, has_needed_tests
from modallab.gap.model.fit import Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.nuisances import nuisances
from modallab.gap.model.tolerances import with_tolerances
from modallab.twin.candidate import CandidateEffect, FreeNumber
from modallab.twin.effects import effect_models

ALIKE = 0.95
"""Cosine from which two effects count as not to be distinguished."""
PLACES = (0.37, 0.63, 0.92, 1.0)
"""Where on the beam an effect with a place is tried."""
SMALL = 0.003
"""How far a factor is off the one that stands for no effect where the effect is small."""
SEEN = 5.0
"""Noise units that an effect of a plain size must leave to be seen at all."""


@dataclass(frozen=True, eq=False, slots=True)
class Distinguishability:
    """Cosines between the signatures of effects, nuisances projected out.

    Attributes:
        effects: names; those with a place stand for the place where they are most alike.
        cosine: (effects, effects) largest |cosine| over the places tried.
        strength: (effects,) noise units a small such effect leaves after the nuisances, over before.
        left: (effects,) noise units that one of a plain size leaves, in the mean over the places tried.
    """

    effects: tuple[str, ...]
    cosine: Real
    strength: Real
    left: Real

    @property
    def smallest_visible(self) -> Real:
        """(effects,) share of a plain size down to which an effect can be seen; above 1 a plain one is hidden."""
        return SEEN / np.maximum(self.left, 1e-9)

    def hidden_effects(self) -> list[str]:
        """Effects of a plain size that pass for a beam and a chain within their tolerances."""
        return [name for name, left in zip(self.effects, self.left, strict=True) if left < SEEN]

    def indistinguishable_pairs(self) -> list[tuple[str, str, float]]:
        """Pairs that cannot be distinguished, worst first."""
        n = len(self.effects)
        pairs = [
            (self.effects[i], self.effects[j], float(self.cosine[i, j]))
            for i in range(n)
            for j in range(i + 1, n)
            if self.cosine[i, j] >= ALIKE
        ]
        return sorted(pairs, key=lambda p: -p[2])


def distinguishability_of_plan(rig: Rig, plans: Sequence[Plan]) -> Distinguishability:
    """The distinguishability of a plan on a rig, its tolerances free; a lab's usual ones where it states none."""
    hits = [(rig.x_of(p), plan.hits) for plan in plans if isinstance(plan, ImpactPlan) for p in plan.points]
    return distinguishability_of_data(records_of_plans(with_tolerances(rig), plans), hits)


def distinguishability_of_data(
    data: Reduced, hits: Collection[tuple[float, int]] = (), names: Collection[str] | None = None
) -> Distinguishability:
    """The distinguishability of reduced data, around the nominal bench.

    Args:
        data: of the nominal bench.
        hits: place in m and number of the hits at each drive point.
        names: effects that are looked at; None for all.
    """
    rig = data.rig
    free = nuisances(rig, 450.0, hits)
    base = Problem(data, free)
    zero = np.zeros(free.size)
    r0 = base.residual(zero)
    J = jacobian(base, zero, r0)
    # Priors are data too: a row of the identity each.
    q, _ = np.linalg.qr(np.vstack([J, np.eye(free.size)]))
    found: dict[str, list[Real]] = {}
    strength: dict[str, list[float]] = {}
    left: dict[str, list[float]] = {}
    for candidate, values in _signatures_of_effects(rig, data):
        if names is not None and candidate.effect not in names:
            continue
        u = np.concatenate([zero, values])
        r = Problem(data, free, (candidate,)).residual(u) - r0
        padded = np.concatenate([r, np.zeros(free.size)])
        rest = padded - q @ (q.T @ padded)
        whole = float(np.linalg.norm(r))
        if whole > 0:
            found.setdefault(candidate.effect, []).append(rest / max(float(np.linalg.norm(rest)), 1e-300))
            strength.setdefault(candidate.effect, []).append(float(np.linalg.norm(rest)) / whole)
            left.setdefault(candidate.effect, []).append(float(np.linalg.norm(rest)) * _plain_over_small(candidate))
    listed = tuple(found)
    cosine = np.eye(len(listed))
    for i, a in enumerate(listed):
        for j, b in enumerate(listed[:i]):
            cosine[i, j] = cosine[j, i] = min(1.0, float(np.max(np.abs(np.array(found[a]) @ np.array(found[b]).T))))
    strengths, lefts = (np.array([f(of[name]) for name in listed]) for f, of in ((max, strength), (np.mean, left)))
    return Distinguishability(listed, cosine, strengths, lefts)


def _signatures_of_effects(rig: Rig, data: Reduced) -> list[tuple[CandidateEffect, Real]]:
    """Every effect in a small size, at a few places."""
    middle = data.channels[len(data.channels) // 2]
    found: list[tuple[CandidateEffect, Real]] = []
    for c in beam_candidates(rig) + channel_candidates(rig, middle):
        # What has no size, as a turned sensor, has no signature of a small one.
        if not c.slots or not has_needed_tests(c, data):
            continue
        places = PLACES if any(s.name == "x" for s in c.slots) else (None,)
        for x in places:
            values = [s.coordinate(x if s.name == "x" and x is not None else _small_value(s)) for s in c.slots]
            found.append((c, np.array(values)))
    return found


def _small_value(slot: FreeNumber) -> float:
    if slot.power < 0:
        return 10 * max(slot.starts)
    if slot.none:
        return slot.none + SMALL
    return min((v for v in slot.starts if v > 0), key=abs) / (30 if slot.power else 1)


def _plain_over_small(candidate: CandidateEffect) -> float:
    """How many times larger than the small effect's a plain one's signature is: one in the middle of those looked for.

    Signatures grow with a mass, with the compliance of a spring that something stands on, and so on.
    """
    slot = next(s for s in candidate.slots if s.name != "x")
    positive = [v for v in slot.starts if v > 0]
    plain, small = positive[len(positive) // 2], _small_value(slot)
    if slot.none:
        return abs(float(np.log(min(v for v in positive if v > slot.none) / slot.none) / np.log(small / slot.none)))
    return (small / plain) ** -slot.power if slot.power < 0 else (plain / small) ** slot.power


def advice_on_plan(found: Distinguishability, plans: Sequence[Plan]) -> list[str]:
    """What to add to the plan."""
    kinds = {p.kind for p in plans}
    advices: list[str] = []
    if "sine" not in kinds:
        advices.append("Add a sine test: without it the shaker's attachment, the clock and the level cannot be tested.")
    if "impact" not in kinds:
        advices.append("Add an impact test: its free decays give the poles without the shaker.")
    points = {p for plan in plans if isinstance(plan, ImpactPlan) for p in plan.points}
    if "impact" in kinds and len(points) < 3:
        advices.append(
            "Strike at three points or more: residues at several points separate masses from springs and the root."
        )
    if any(isinstance(p, SinePlan) and len(p.levels_v) < 2 for p in plans):
        advices.append("Add a second level: only two levels show an amplitude-dependent effect.")
    pairs = {frozenset(pair[:2]) for pair in found.indistinguishable_pairs()}
    rivals = [(name, rival) for name, model in effect_models().items() for rival in model.rivals if rival.plan]
    advices += [r.plan for name, r in rivals if any(name in p and (not r.effect or r.effect in p) for p in pairs)]
    return advices
