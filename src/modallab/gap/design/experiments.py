"""Which experiment separates the explanations that a campaign has left standing, before it is made.

Each experiment is planned beside what has been recorded; what counts is the smallest distance, in noise units, of one
effect of a plain size from all that the nuisances and the other effect can imitate. It is the root of what Fisher's
information gives for the one effect with everything else free (Pukelsheim, Optimal Design of Experiments, 2006, ch. 3).
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import PlanError
from modallab.core.frozen import Frozen
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.progress import counted
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import as_volts, usable
from modallab.gap.conditioning.reduce import force_amplitude
from modallab.gap.design.distinguishability import Distinguishability, of_data
from modallab.gap.design.planned import N_PER_V, planned
from modallab.gap.model.tolerances import with_tolerances
from modallab.signals.signals import to_signals

POSSIBLE = 0.01
"""Probability from which an explanation counts as left standing."""
LOUDER = 2.5
"""A third level over the highest so far."""
ABOUT = (0.97, 0.985, 1.0, 1.015, 1.03)
"""Frequencies about a mode, as shares of its own."""
HIT_S, SINE_S = 20.0, 25.0
"""What a hit and a sine take at the bench, with the wait for rest."""
HITS = 5
APART = 1.0
"""Noise units below which no experiment decides between two explanations.

An effect of a plain size that is no further from all that others can imitate is not seen.
"""


class Experiment(Frozen):
    """An experiment that could be made next.

    Attributes:
        name: short.
        says: what to do.
        plans: to be run.
        seconds: what it takes at the bench, about.
        before: smallest distance of two explanations as the campaign is, in noise units.
        after: the same with the experiment.
    """

    name: str
    says: str
    plans: tuple[Plan, ...]
    seconds: float
    before: float
    after: float


def next_experiments(campaign: Campaign, diagnosis: Diagnosis) -> list[Experiment]:
    """Experiments that would separate what a diagnosis has left standing, the best first.

    Raises:
        PlanError: fewer than two explanations are left standing that a fit can look for.
        DataError: the campaign holds no record that says what drove it.
    """
    rig = with_tolerances(campaign.rig)
    rivals = _rivals(diagnosis)
    done = plans_of(campaign)
    before = _distance(_seen(rig, done, rivals), rivals)
    options = _options(rig, done, diagnosis.gap.poles_hz)
    found = [
        Experiment(
            name=name,
            says=says,
            plans=plans,
            seconds=sum(_seconds(plan) for plan in plans),
            before=before,
            after=_distance(_seen(rig, _joined(done, plans), rivals), rivals),
        )
        for name, says, plans in counted(options, len(options), "experiments")
    ]
    # Of two that separate alike, the shorter one.
    return sorted(found, key=lambda e: (-round(float(np.log2(max(e.after, 1e-9))), 1), e.seconds))


def _rivals(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Pairs of effects by which explanations that are left standing differ from the most probable."""
    sets = [frozenset(c.effects) for c in sorted(diagnosis.candidates, key=lambda c: -c.probability)]
    likely = {frozenset(c.effects) for c in diagnosis.candidates if c.probability >= POSSIBLE}
    # Where one stands alone, it is still compared with the one behind it.
    kept = [s for k, s in enumerate(sets) if s in likely or k < 2]
    pairs = {
        (one, other) if one < other else (other, one)
        for rival in kept[1:]
        for one in kept[0] - rival
        for other in rival - kept[0]
    }
    if not pairs:
        raise PlanError(
            "the diagnosis leaves no two explanations between which an experiment could decide",
            where=diagnosis.rig,
            remedy=diagnosis.next_experiment or "nothing is to be decided; put what was found into the simulation",
        )
    return sorted(pairs)


def plans_of(campaign: Campaign) -> list[Plan]:
    """The tests of a campaign as plans; the drive of the sines by the force that was measured."""
    volts = as_volts(campaign)
    blocks = usable(volts)
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


def _options(rig: Rig, done: Sequence[Plan], poles_hz: Sequence[float]) -> list[tuple[str, str, tuple[Plan, ...]]]:
    struck = {p for plan in done if isinstance(plan, ImpactPlan) for p in plan.points}
    options: list[tuple[str, str, tuple[Plan, ...]]] = [
        (f"hits at {p.id}", f"Strike {HITS} times at point {p.id}.", (ImpactPlan(points=(p.id,), hits=HITS),))
        for p in sorted(rig.points, key=lambda p: p.x_m)
        if p.id not in struck and p.x_m > 0
    ]
    if struck:
        again = ImpactPlan(points=tuple(sorted(struck)), hits=HITS)
        options.append(("hits again", "Repeat the hits where they were: noise falls, and time shows.", (again,)))
    if rig.shaker_point is None:
        return options
    sine = next((plan for plan in done if isinstance(plan, SinePlan)), None)
    if sine is None:
        return [*options, ("sines", "Run a sine test.", (SinePlan(),))]
    top = max(sine.levels_v.values())
    louder = SinePlan(frequencies_hz=sine.frequencies_hz, levels_v={"louder": _within(rig, LOUDER * top)})
    options.append(("third level", "Repeat the sines at a level above.", (louder,)))
    inside = [f for f in poles_hz if f < 0.2 * sine.rate_hz]
    if inside:
        close = tuple(round(f * share, 3) for f in inside for share in ABOUT)
        about = SinePlan(frequencies_hz=close, levels_v={"about": _within(rig, top)})
        options.append(("sines about modes", "Drive five frequencies about each mode.", (about,)))
    return options


def _within(rig: Rig, volts: float) -> float:
    return min(volts, rig.limits.drive_v) if rig.limits is not None else volts


def _joined(done: Sequence[Plan], more: Sequence[Plan]) -> list[Plan]:
    """Plans as one campaign: what is planned of sines is one test with all levels and frequencies."""
    sines = [plan for plan in (*done, *more) if isinstance(plan, SinePlan)]
    hits = [plan for plan in (*done, *more) if isinstance(plan, ImpactPlan)]
    if len(sines) < 2:
        return [*hits, *sines]
    frequencies = tuple(sorted({f for plan in sines for f in plan.frequencies_hz}))
    levels = {name: volts for plan in sines for name, volts in plan.levels_v.items()}
    return [*hits, sines[0].model_copy(update={"frequencies_hz": frequencies, "levels_v": levels})]


def _seen(rig: Rig, plans: Sequence[Plan], rivals: Sequence[tuple[str, str]]) -> Distinguishability:
    hits = [(rig.x_of(p), plan.hits) for plan in plans if isinstance(plan, ImpactPlan) for p in plan.points]
    return of_data(planned(rig, plans), hits, {name for pair in rivals for name in pair})


def _distance(found: Distinguishability, rivals: Sequence[tuple[str, str]]) -> float:
    """Smallest distance of any two rivals; of what no record can show it is 0."""
    at = {name: k for k, name in enumerate(found.effects)}
    return min(
        (
            min(float(found.left[at[a]]), float(found.left[at[b]]))
            * float(np.sqrt(max(0.0, 1 - found.cosine[at[a], at[b]] ** 2)))
            if a in at and b in at
            else 0.0
        )
        for a, b in rivals
    )


def _seconds(plan: Plan) -> float:
    if isinstance(plan, ImpactPlan):
        return HIT_S * plan.hits * len(plan.points)
    return SINE_S * len(plan.frequencies_hz) * len(plan.levels_v) if isinstance(plan, SinePlan) else 0.0


def continued(campaign: Campaign, later: Campaign) -> Campaign:
    """A campaign with the records of a later one behind its own, under names that are free."""
    first = 1 + max((b.order for b in campaign.blocks), default=-1)
    taken = {b.name for b in campaign.blocks}
    added = tuple(
        replace(b, order=first + k, name=_free(b.name, taken))
        for k, b in enumerate(sorted(later.blocks, key=lambda b: b.order))
    )
    return replace(campaign, blocks=(*campaign.blocks, *added))


def _free(name: str, taken: set[str]) -> str:
    number = 2
    free = name
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    taken.add(free)
    return free
