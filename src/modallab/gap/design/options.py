"""What could be done next on a rig, as plans that it can run itself."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from modallab.core.block import Campaign
from modallab.core.plan import PAPER_LINES, ForceControl, HitAcceptance, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.gap.conditioning.records import records_in_volts, usable_records
from modallab.gap.conditioning.reduce import force_amplitude
from modallab.gap.design.planned import N_PER_V
from modallab.signals.signals import to_signals

LOUDER = 2.5
"""A third level over the highest so far."""
FIRST_N = 1.0
"""Force of a first sine test."""
MOST_OF_LIMIT = 0.6
"""Share of the force and of the acceleration that the rig allows, up to which a level is planned."""
V_PER_N = 0.25
"""Drive that a force is begun with."""
ABOUT = (0.97, 0.985, 1.0, 1.015, 1.03)
"""Frequencies about a mode, as shares of its own."""
BAND = 0.2
"""Share of the rate up to which sines are planned."""
HIT_S, SINE_S = 20.0, 25.0
"""What a hit and a sine take at the bench, with the wait for rest."""
BURSTS = 1.3
"""Bursts that a frequency takes where the force is held."""
HITS = 5
STILL = 3e-4
"""What may still move before a hit, as part of what it makes: more would be taken for what is to be distinguished."""
SHAPE = 3
"""Accelerometers from which shapes are seen."""


@dataclass(frozen=True, slots=True)
class PossibleExperiment:
    """Something that could be done.

    Attributes:
        name: short.
        says: what to do.
        plans: to be run.
    """

    name: str
    says: str
    plans: tuple[Plan, ...]

    @property
    def duration_s(self) -> float:
        """What it takes at the bench, about."""
        return sum(_bench_seconds(plan) for plan in self.plans)


def plans_of(campaign: Campaign) -> list[Plan]:
    """The tests of a campaign as plans; the drive of the sines by the force that was measured.

    Raises:
        DataError: the campaign holds no record that says what drove it.
    """
    volts = records_in_volts(campaign)
    blocks = usable_records(volts)
    hits = [b for b in blocks if b.test == "impact"]
    plans: list[Plan] = []
    counts = Counter(b.drive_point for b in hits if b.drive_point is not None)
    for count in sorted(set(counts.values())):
        points = tuple(sorted(p for p, c in counts.items() if c == count))
        plans.append(
            ImpactPlan(points=points, hits=count, rate_hz=hits[0].rate_hz, block_s=hits[0].n_samples / hits[0].rate_hz)
        )
    sines = [b for b in blocks if b.test == "sine"]
    if sines:
        levels: dict[str, list[float]] = {}
        for b in sines:
            amplitude = abs(force_amplitude(to_signals(b, campaign.rig), b.frequency_hz or 1.0))
            levels.setdefault(b.level or "level", []).append(amplitude / N_PER_V)
        plans.append(
            SinePlan(
                frequencies_hz=tuple(sorted({b.frequency_hz for b in sines if b.frequency_hz})),
                levels_v={name: float(np.median(values)) for name, values in levels.items()},
                rate_hz=sines[0].rate_hz,
                block_s=sines[0].n_samples / sines[0].rate_hz,
            )
        )
    return plans


def possible_experiments(rig: Rig, done: Sequence[Plan], poles_hz: Sequence[float]) -> list[PossibleExperiment]:
    """What could be done, of one kind each.

    Args:
        rig: the bench.
        done: what was done, as `plans_of`.
        poles_hz: frequencies of the ring-down.
    """
    return [*_possible_hits(rig, done), *(_possible_sines(rig, done, poles_hz) if rig.shaker_point is not None else [])]


def _possible_hits(rig: Rig, done: Sequence[Plan]) -> list[PossibleExperiment]:
    before = [plan for plan in done if isinstance(plan, ImpactPlan)]
    struck = sorted({p for plan in before for p in plan.points})
    # At one point all hits are one set of lines: they must be as long as those before.
    like = before[0] if before else ImpactPlan(points=(1,))
    # Where a hit landed is read off shapes, which few sensors do not show: their weak answers would be taken for it.
    acceptance = HitAcceptance(check_point=len(rig.responses) >= SHAPE, max_residual_ratio=STILL)
    like = like.model_copy(update={"acceptance": acceptance})
    found = [
        PossibleExperiment(
            f"hits at {p.id}", f"Strike {HITS} times at point {p.id}.", (hits_at_other_points(like, (p.id,)),)
        )
        # Of points that tell alike, that is struck which moves most: near the root a hit is felt least.
        for p in sorted(rig.points, key=lambda p: -p.x_m)
        if p.id not in struck and p.x_m > 0
    ]
    if struck:
        again = hits_at_other_points(like, tuple(struck))
        found.append(
            PossibleExperiment(
                "hits again", "Repeat the hits at the same points: noise falls, and a drift shows.", (again,)
            )
        )
    return found


def hits_at_other_points(like: ImpactPlan, points: tuple[int, ...]) -> ImpactPlan:
    """A plan of hits at other points, recorded as those of a plan before."""
    return like.model_copy(update={"points": points, "hits": HITS})


def _possible_sines(rig: Rig, done: Sequence[Plan], poles_hz: Sequence[float]) -> list[PossibleExperiment]:
    before = next((plan for plan in done if isinstance(plan, SinePlan)), None)
    if before is None:
        first = sines_at_force(rig, SinePlan(), SinePlan().frequencies_hz, "low", FIRST_N)
        return [PossibleExperiment("sines", "Run a sine test.", (first,))]
    top = max(before.levels_v.values()) * N_PER_V
    louder = sines_at_force(rig, before, before.frequencies_hz, "louder", LOUDER * top)
    found = [PossibleExperiment("third level", "Repeat the sines at a higher level.", (louder,))]
    inside = [f for f in poles_hz if f < BAND * before.rate_hz]
    if inside:
        close = tuple(round(f * share, 3) for f in inside for share in ABOUT)
        about = sines_at_force(rig, before, close, "about", top)
        found.append(PossibleExperiment("sines about modes", "Drive five frequencies around each mode.", (about,)))
    return found


def sines_at_force(rig: Rig, like: SinePlan, frequencies_hz: tuple[float, ...], level: str, newtons: float) -> SinePlan:
    """Sines of a force, recorded as those of a plan before: records do not say how many volts drove them."""
    if rig.limits is not None:
        newtons = min(newtons, MOST_OF_LIMIT * rig.limits.force_n)
    most = inf if rig.limits is None else rig.limits.drive_v
    return SinePlan(
        frequencies_hz=frequencies_hz,
        # Each burst is corrected by what the one before gave: too little to begin with harms nothing.
        levels_v={level: min(newtons * V_PER_N, most)},
        rate_hz=like.rate_hz,
        block_s=like.block_s,
        force=ForceControl(levels_n={level: newtons}),
    )


def limit_force(plan: SinePlan, newtons: float) -> SinePlan:
    """The same at this force at most, where it holds one."""
    if plan.force is None or max(plan.force.levels_n.values()) <= newtons:
        return plan
    share = newtons / max(plan.force.levels_n.values())
    levels = {name: n * share for name, n in plan.force.levels_n.items()}
    volts = {name: v * share for name, v in plan.levels_v.items()}
    return plan.model_copy(update={"levels_v": volts, "force": plan.force.model_copy(update={"levels_n": levels})})


def sines_on_all_lines(rig: Rig, done: Sequence[Plan]) -> SinePlan:
    """Sines on all lines of the usual band that were not driven yet: to choose from."""
    before = next((plan for plan in done if isinstance(plan, SinePlan)), None)
    like = before or SinePlan()
    driven = () if before is None else before.frequencies_hz
    lines = [k / like.block_s for k in range(min(PAPER_LINES), max(PAPER_LINES) + 1)]
    free = tuple(round(f, 3) for f in lines if all(abs(f - d) * like.block_s > 0.5 for d in driven))
    newtons = FIRST_N if before is None else max(before.levels_v.values()) * N_PER_V
    return sines_at_force(rig, like, free, "chosen", newtons)


def _bench_seconds(plan: Plan) -> float:
    if isinstance(plan, ImpactPlan):
        return HIT_S * plan.hits * len(plan.points)
    if not isinstance(plan, SinePlan):
        return 0.0
    bursts = 1.0 if plan.force is None else BURSTS
    return SINE_S * bursts * len(plan.frequencies_hz) * len(plan.levels_v)
